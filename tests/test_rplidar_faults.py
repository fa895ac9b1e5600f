"""What faults on the line cost an RPLIDAR's scans."""

import numpy as np
import pytest
from rplidar_room import off_the_walls, room_feed
from rplidar_talk import ASK, PERIOD, SCANS, SOON, Watched, decoder_for, scans_of, talk

from laserfeatures.emulators import Faults


@pytest.mark.parametrize("coverage", [0.8, 0.999])
@pytest.mark.parametrize("mode", SCANS)
def test_nothing_is_lost_on_a_good_line(mode, coverage):
    device = Watched(room_feed())
    heard, decoder = talk(device, [*ASK, *PERIOD[mode], SCANS[mode]], 5.0, decoder_for(coverage))
    scans = scans_of(heard)
    assert decoder.losses.counts() == dict.fromkeys(decoder.losses.counts(), 0)
    begins = device.clean_turns({})
    assert len(scans) >= len(begins) >= 30
    stamps = np.array([scan.stamp for scan in scans])
    assert np.diff(stamps) == pytest.approx(1 / 7, rel=0.02)
    for scan in scans:
        assert scan.valid.all()
        assert off_the_walls(scan).max() < (0.015 if mode == "boost" else 0.002)


# What may be wrong in a standard scan, which has no checksum: a flipped distance, say.
UNDETECTABLE = 0.002
AROUND = {"stuck": 2.2, "restart": 3.0}


@pytest.mark.parametrize("mode", SCANS)
@pytest.mark.parametrize(
    ("fault", "rate"),
    [
        ("garbage", 0.03), ("lost_byte", 0.03), ("doubled_byte", 0.03), ("bit_flip", 0.03),
        ("cut", 0.03), ("stuck", 0.001), ("restart", 0.001),
    ],
)  # fmt: skip
def test_faults_cost_what_they_hit(mode, fault, rate):
    device = Watched(room_feed(), Faults({fault: rate}, seed=5))
    heard, decoder = talk(device, [*ASK, SCANS[mode]], 25.0)
    scans = scans_of(heard)
    begins = device.clean_turns({fault: AROUND.get(fault, 0.02)})
    stamps = np.array([scan.stamp for scan in scans])
    missed = [begin for begin in begins if abs(stamps - begin).min() > SOON]
    assert begins
    assert len(missed) <= (0.03 * len(begins) if mode == "standard" else 0)
    off = np.concatenate([off_the_walls(scan) for scan in scans])
    wrong = (off > 0.02).mean()
    assert wrong <= (UNDETECTABLE if mode == "standard" else 0)
    assert (np.diff(stamps) > 0.1).all()  # no turn twice
    assert len(begins) < 170 or fault == "garbage"  # something was hit
    assert decoder.losses.damaged or fault in AROUND


@pytest.mark.parametrize("trouble", ["bad_checksum", "angle_jump"])
def test_troubles_of_capsules(trouble):
    device = Watched(room_feed(), troubles=[trouble], trouble_rate=0.01)
    heard, decoder = talk(device, [*ASK, SCANS["express"]], 20.0)
    assert decoder.losses.damaged > 10
    assert len(scans_of(heard)) > 120
    off = np.concatenate([off_the_walls(scan) for scan in scans_of(heard)])
    # Two capsules in a row that jump alike have nothing wrong but where they are.
    assert (off > 0.002).mean() < (0.001 if trouble == "angle_jump" else 1e-9)
