"""Frames damaged at random on the way to the driver: none is lost but those, none is invented."""

from itertools import pairwise

import pytest
from urg_lines import number_of, numbered

from laserfeatures.drivers.urg import Urg
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.urg import UrgDevice

SCANS = 150
WHOLE = {None, "garbage"}


class Planned(Faults):
    """A fault that hits certain scans."""

    def __init__(self, name, scans, **times):
        super().__init__(**times)
        self.name = name
        self.scans = set(scans)
        self.seen = 0

    def damage(self, frame):
        self.seen += b"\n99b\n" in frame
        if self.seen not in self.scans:
            return frame, None
        self.scans.remove(self.seen)
        self.unplugged = self.name == "unplug"
        return frame, self.name


def run(device, tmp_path, count=SCANS):
    """Return the numbers of the turns that come, their stamps and the driver."""
    link = tmp_path / "urg"
    with (
        Emulator(device, speed=20, patient=True, link=link),
        Urg(port=str(link), reconnect=True, buffer=SCANS) as driver,
    ):
        scans = [next(driver) for _ in range(count)]
    return [number_of(scan) for scan in scans], [scan.stamp for scan in scans], driver


@pytest.mark.parametrize("fault", ["garbage", "lost_byte", "doubled_byte", "bit_flip", "cut"])
def test_every_undamaged_frame_comes_and_no_other(fault, tmp_path):
    device = UrgDevice(numbered(), Faults({fault: 0.1}, seed=1))
    turns, stamps, driver = run(device, tmp_path)
    hit = {turn for turn, name in device.frames if name not in WHOLE and turn < turns[-1]}
    assert set(turns) >= set(range(turns[0], turns[-1] + 1)) - hit
    assert all(a < b for a, b in pairwise(turns))
    assert all(a < b for a, b in pairwise(stamps))
    assert driver.losses.missed >= turns[-1] - turns[0] + 1 - SCANS
    assert (driver.losses.restarts, driver.losses.overruns) == (0, 0)
    if fault != "garbage":
        assert 5 < len(hit) < 35


def test_all_of_them_at_once(tmp_path):
    rates = dict.fromkeys(["garbage", "lost_byte", "doubled_byte", "bit_flip", "cut"], 0.06)
    device = UrgDevice(numbered(), Faults(rates, seed=2), troubles={"check": 0.01, "frozen": 0.02})
    turns, _, driver = run(device, tmp_path, 100)
    assert all(a < b for a, b in pairwise(turns))
    assert driver.losses.damaged > 12


@pytest.mark.parametrize("event", ["stuck", "restart", "unplug"])
def test_what_happens_to_the_device_is_survived(event, tmp_path):
    device = UrgDevice(numbered(), Planned(event, [60], stuck_time=1.0, unplugged_time=0.1))
    turns, stamps, driver = run(device, tmp_path, 100)
    names = [name for _, name in device.frames]
    assert event in names
    hit = {turn for turn, name in device.frames if name}
    assert all(a < b for a, b in pairwise(turns))
    assert driver.losses.damaged == 0
    if event == "restart":
        assert driver.losses.restarts == 1
        assert len(set(range(turns[0], turns[-1] + 1)) - set(turns) - hit) == 0
    elif event == "unplug":
        assert driver.losses.reconnects == 1
    else:
        assert all(a < b for a, b in pairwise(stamps))
