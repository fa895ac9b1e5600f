"""The LD19: turns, and its emulator through its driver on a pseudo-terminal."""

import itertools
import math

import numpy as np
import pytest
from numbered import NumberedFeed, numbers_of

from laserfeatures import DriverError, DriverTimeoutError
from laserfeatures.drivers import Sweep, make_driver
from laserfeatures.drivers.ld19 import Ld19
from laserfeatures.emulators import Emulator, Faults, WorldFeed
from laserfeatures.emulators.ld19 import Ld19Device
from laserfeatures.scan import Pose2D
from laserfeatures.simulation import World

ROOM = World.outline([(-2, -1.5), (3, -1.5), (3, 2), (-2, 2)])


def played(device, seconds, **parameters):
    """Return the sweeps that a device's bytes make, its time running as fast as it can."""
    driver = Ld19(port="none", **parameters)
    decoder = driver.decoder()
    device.power_on(0.0)
    found, now = [], 0.0
    while now < seconds:
        now += 0.001
        found += decoder.received(device.take(now), now)
    return [message for message in found if isinstance(message, Sweep)], driver.losses


def test_scans_of_a_room_show_the_room():
    feed = WorldFeed(ROOM, Pose2D(0, 0, 0.3), range_sigma=0.0)
    sweeps, losses = played(Ld19Device(feed), 2.0)
    assert len(sweeps) == 17  # the first turn is not whole, nor the last; spinning up takes one
    for sweep in sweeps[2:]:
        scan = sweep.scan
        assert len(scan) == 450
        points = Pose2D(0, 0, 0.3).transform(scan.points)
        off = np.min(abs(points[:, [0, 0, 1, 1]] - [-2, 3, -1.5, 2]), axis=1)
        assert off.max() < 0.002
    assert losses.garbage == losses.damaged == losses.missed == 0


def test_a_clockwise_sensor_gives_counter_clockwise_angles():
    def feed(angles):  # something to the left only
        return np.where(abs(angles - math.pi / 2) < 0.2, 1.0, math.nan)

    sweeps, _ = played(Ld19Device(feed), 1.0)
    scan = sweeps[-1].scan
    assert np.all(np.diff(scan.angles) > 0)
    assert abs(scan.points.mean(axis=0) - [0, 1]).max() < 0.02


def test_stamps_follow_the_turns_and_the_clock_wraps():
    device = Ld19Device(NumberedFeed(), clock_ms=29_500, spin_up=0.0)
    device.baud = None  # so that frames come whole, and stamps are as exact as the millisecond
    sweeps, losses = played(device, 2.0)
    assert np.allclose(np.diff([sweep.scan.stamp for sweep in sweeps]), 0.1, atol=0.003)
    assert sweeps[0].scan.stamp == pytest.approx(0.1, abs=0.004)
    assert losses.missed == 0


def test_weak_measurements_can_be_left_out():
    sweeps, _ = played(Ld19Device(NumberedFeed(), intensity=10), 1.0, min_intensity=11)
    assert not sweeps[0].scan.valid.any()


def test_a_range_that_looks_like_a_head_is_a_range():
    sweeps, losses = played(Ld19Device(lambda angles: np.full(angles.size, 11.348)), 1.0)
    assert np.allclose(sweeps[-1].scan.ranges, 11.348)
    assert losses.damaged == losses.garbage == 0


@pytest.mark.parametrize("fault", ["garbage", "lost_byte", "doubled_byte", "bit_flip", "cut"])
def test_a_damaged_frame_costs_that_frame_only(fault):
    device = Ld19Device(NumberedFeed(), Faults({fault: 0.1}, seed=1), spin_up=0.0)
    sweeps, losses = played(device, 15.0)
    hit = {}
    for turn, hurt in device.frames:
        hit.setdefault(turn, []).append(hurt is not None)
    whole = sum(not h for frames in hit.values() for h in frames)
    assert losses.frames in {whole, whole - 1}  # the last may be on the line still
    for sweep in sweeps:
        (turn,) = set(numbers_of(sweep.scan))  # no beam of another turn, none invented
        nearby = sum(sum(hit.get(near, [])) for near in (turn - 1, turn, turn + 1))
        assert 450 - len(sweep.scan) <= 12 * nearby
        assert 450 - len(sweep.scan) >= 12 * (sum(hit[turn]) - 1) - 6
    assert len(sweeps) + losses.missed >= 147
    assert losses.missed == 0


def test_a_turn_of_which_most_is_lost_is_counted_not_delivered():
    device = Ld19Device(NumberedFeed(), Faults({"cut": 0.7}, seed=2), spin_up=0.0)
    sweeps, losses = played(device, 10.0)
    assert losses.missed > 60
    assert len(sweeps) + losses.missed == pytest.approx(98, abs=2)
    assert all(len(sweep.scan) > 200 for sweep in sweeps)


def test_the_driver_reads_the_emulator():
    with (
        Emulator(Ld19Device(WorldFeed(ROOM, Pose2D(0, 0, 0)))) as emulator,
        make_driver(f"ld19://{emulator.port}") as driver,
    ):
        scans = list(itertools.islice(driver, 5))
    assert [len(scan) for scan in scans[1:]] == [450] * 4
    assert driver.arrival - scans[-1].stamp == pytest.approx(0.002, abs=0.01)
    assert list(driver) == []  # closed


def test_a_wrong_baud_is_said():
    with (
        Emulator(Ld19Device(NumberedFeed())) as emulator,
        pytest.raises(DriverError, match="wrong baud rate"),
    ):
        make_driver(f"ld19://{emulator.port}?baud=115200").open()


def test_slow_frames_may_be_those_of_another_model(caplog):
    device = Ld19Device(WorldFeed(ROOM, Pose2D(0, 0, 0)))
    device.baud = 115_200
    with (
        Emulator(device) as emulator,
        make_driver(f"ld19://{emulator.port}?baud=115200") as driver,
    ):
        next(iter(driver))
    assert "an LD14 and an LDS-02 send the same frames at 115200 Bd" in caplog.text


def test_silence_is_said():
    device = Ld19Device(NumberedFeed(), Faults({"stuck": 1.0}, stuck_time=60.0))
    with (
        Emulator(device) as emulator,
        pytest.raises(DriverTimeoutError, match="got silence: check that it has power"),
    ):
        make_driver(f"ld19://{emulator.port}").open()


@pytest.mark.parametrize(
    ("query", "message"),
    [
        ("range_max=0", "range_max must be > 0.02 m"),
        ("min_intensity=300", "min_intensity must be in 0..255"),
        ("buffer=0", "buffer must be >= 1"),
        ("baud=-1", "baud must be > 0"),
    ],
)
def test_parameters_are_checked(query, message):
    with pytest.raises(DriverError, match=message):
        make_driver(f"ld19:///dev/null?{query}")
