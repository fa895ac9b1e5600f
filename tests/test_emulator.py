"""What all emulators share: the line, the faults, what is seen."""

import itertools
import math
import os
import time
from random import Random

import numpy as np
import pytest
import serial
from numbered import NumberedFeed

from laserfeatures import DriverError, LaserScan, SourceError
from laserfeatures.emulators import FAULTS, Emulator, Faults, ScansFeed, WorldFeed
from laserfeatures.emulators.device import Device
from laserfeatures.emulators.feed import sampled
from laserfeatures.scan import Pose2D
from laserfeatures.simulation import World


class Echo(Device):
    """Sends back what it hears, and a frame every 10 ms when it is told to."""

    name = "echo"

    def __init__(self, faults=None, baud=None):
        super().__init__(NumberedFeed(), faults)
        self.baud = baud
        self.heard = b""
        self.ons = []

    def power_on(self, now):
        self.hush()
        self.ons.append(now)

    def hear(self, data, now):
        self.heard += data
        self.say(data, now)

    def advance(self, now):
        pass

    def next_event(self):
        return math.inf


def test_a_host_talks_to_it_over_a_terminal():
    with Emulator(Echo()) as emulator, serial.Serial(emulator.port, timeout=2) as port:
        port.write(bytes(range(256)))
        assert port.read(256) == bytes(range(256))


def test_a_host_talks_to_it_over_tcp_and_another_after_it():
    with Emulator(Echo(), tcp=0) as emulator:
        for data in (b"abc", b"def"):
            with serial.serial_for_url(emulator.port, timeout=2) as port:
                port.write(data)
                assert port.read(3) == data


def test_at_another_rate_nothing_is_understood():
    device = Echo(baud=9600)
    with (
        Emulator(device) as emulator,
        serial.Serial(emulator.port, baudrate=38_400, timeout=0.1) as port,
    ):
        port.write(b"abc")
        assert port.read(3) == b""
        assert device.heard == b""
        port.baudrate = 9600
        port.write(b"abc")
        assert port.read(3) == b"abc"


@pytest.mark.parametrize("rate", [9600, 115_200, 128_000, 230_400, 256_000, 500_000, 750_000])
def test_the_hosts_rate_is_known(rate):
    with (
        Emulator(Echo(baud=rate)) as emulator,
        serial.Serial(emulator.port, baudrate=rate, timeout=2) as port,
    ):
        port.write(b"abc")
        assert port.read(3) == b"abc"


def test_bytes_take_their_time_on_a_slow_line():
    device = Echo(baud=9600)
    device.hear(bytes(96), 1.0)
    got = {now: len(device.take(1.0 + now)) for now in (0.0, 0.05, 0.0999, 0.1001)}
    assert list(got.values()) == [0, 48, 47, 1]
    assert device.due(2.0) == math.inf


def test_what_was_said_can_be_cut_off():
    device = Echo(baud=9600)
    device.hear(bytes(96), 0.0)
    device.take(0.05)
    device.hush()
    assert device.take(1.0) == b""


def test_a_link_gets_the_terminals_place_and_goes_with_it(tmp_path):
    link = tmp_path / "lidar"
    with Emulator(Echo(), link=link) as emulator:
        assert emulator.port == str(link)
        assert os.ttyname(os.open(link, os.O_RDWR | os.O_NOCTTY)) == str(link.readlink())
    assert not link.is_symlink()


def test_a_file_is_not_replaced_by_a_link(tmp_path):
    (tmp_path / "lidar").write_text("mine")
    with (
        pytest.raises(DriverError, match="got an existing file"),
        Emulator(Echo(), link=tmp_path / "lidar"),
    ):
        pass
    assert (tmp_path / "lidar").read_text() == "mine"


def test_what_a_full_terminal_cannot_hold_is_lost_and_the_emulator_lives_on():
    device = Echo()
    with Emulator(device) as emulator, serial.Serial(emulator.port, timeout=2) as port:
        for _ in range(20):
            device.say(bytes(1000), 0.0)
        time.sleep(0.3)
        port.reset_input_buffer()
        port.write(b"abc")
        assert port.read(3) == b"abc"
        assert 0 < emulator.dropped < 20_000


def test_an_error_of_the_device_reaches_who_plays_it():
    class Broken(Echo):
        def advance(self, _now):
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError), Emulator(Broken()):
        time.sleep(0.1)


@pytest.mark.parametrize("name", ["garbage", "lost_byte", "doubled_byte", "bit_flip", "cut"])
def test_faults_do_what_their_names_say(name):
    frame = bytes(range(20))
    for seed in range(50):
        hit = FAULTS[name](frame, Random(seed))  # noqa: S311 - no secret
        length = {"garbage": range(21, 61), "lost_byte": [19], "doubled_byte": [21],
                  "bit_flip": [20], "cut": range(20)}[name]  # fmt: skip
        assert len(hit) in length
        assert name != "garbage" or hit.endswith(frame)
        flipped = [a ^ b for a, b in zip(frame, hit, strict=False) if a != b]
        assert name != "bit_flip" or (len(flipped) == 1 and flipped[0].bit_count() == 1)
        assert name != "cut" or frame.startswith(hit)


def test_faults_come_at_their_rate_and_the_same_for_a_seed():
    faults, again = (Faults({"cut": 0.2, "bit_flip": 0.1}, seed=4) for _ in range(2))
    hits = [faults.damage(b"abc") for _ in range(5000)]
    assert hits == [again.damage(b"abc") for _ in range(5000)]
    share = {name: sum(hit == name for _, hit in hits) / 5000 for name in ("cut", "bit_flip")}
    assert share["cut"] == pytest.approx(0.2, abs=0.02)
    assert share["bit_flip"] == pytest.approx(0.08, abs=0.02)


def test_unknown_faults_and_rates_are_refused():
    with pytest.raises(ValueError, match=r"there is no fault 'bit_flop'.*bit_flip"):
        Faults({"bit_flop": 0.1})
    with pytest.raises(ValueError, match=r"the rate of cut must be in \[0, 1\], got 2"):
        Faults({"cut": 2})


def test_only_frames_that_arrive_whole_count_as_such():
    device = Echo(Faults({"doubled_byte": 0.5}, seed=1))
    for turn in range(200):
        device.say(b"ab", 0.0, turn)
    whole = device.take(1.0).count(b"ab")
    assert whole == sum(fault is None for _, fault in device.frames)


def test_restart_and_stuck_silence_it():
    device = Echo(Faults({"restart": 1.0}))
    device.say(b"abc", 5.0, 0)
    assert (device.take(6.0), device.ons, device.frames[0]) == (b"", [5.0], (0, "restart"))
    device = Echo(Faults({"stuck": 1.0}, stuck_time=2.0))
    device.say(b"abc", 5.0, 0)
    device.faults.rates.clear()
    device.say(b"def", 6.0, 1)
    device.give(b"ghi", 6.5)
    device.say(b"jkl", 7.1, 2)
    assert device.take(8.0) == b"jkl"
    assert [fault for _, fault in device.frames] == ["stuck", "stuck", None]


def test_a_world_is_seen_with_noise_by_seed():
    world = World.outline([(-2, -1), (2, -1), (2, 1), (-2, 1)])
    angles = np.array([0.0, math.pi / 2])
    exact = WorldFeed(world, Pose2D(0.5, 0, 0), range_sigma=0.0)
    assert exact(angles) == pytest.approx([1.5, 1.0])
    assert exact(angles + math.pi) == pytest.approx([2.5, 1.0])
    one, two = (WorldFeed(world, Pose2D(0.5, 0, 0), seed=3) for _ in range(2))
    first = one(angles)
    assert first.tolist() == two(angles).tolist()
    assert first.tolist() != one(angles).tolist()
    near = WorldFeed(world, Pose2D(0.5, 0, 0), range_max=1.2, range_sigma=0)
    assert np.isnan(near(angles)).tolist() == [True, False]
    with pytest.raises(ValueError, match="on wall 2"):
        WorldFeed(world, Pose2D(2.0, 0, 0))


def test_scans_are_played_over_and_over():
    scans = [LaserScan(angles=[0.0, 0.1], ranges=[r, r]) for r in (1.0, 2.0)]
    feed = ScansFeed(lambda: scans)
    seen = [feed(np.array([0.0]))[0] for _ in range(5)]
    assert seen == [1.0, 2.0, 1.0, 2.0, 1.0]
    with pytest.raises(SourceError, match="expected a scan to play"):
        ScansFeed(list)(np.array([0.0]))


def test_a_direction_gets_the_nearest_beam_or_nothing():
    scan = LaserScan(angles=[-0.2, -0.1, 0.0, 0.1], ranges=[1.0, 2.0, math.nan, 4.0])
    seen = sampled(scan, np.array([-0.21, -0.12, -0.04, 0.09, 0.1 + math.tau, 0.3, -3.0]))
    expected = [1.0, 2.0, math.nan, 4.0, 4.0, math.nan, math.nan]
    assert np.array_equal(seen, expected, equal_nan=True)


def test_time_can_run_faster():
    class Ticks(Echo):
        ticks = 0

        def advance(self, now):
            self.ticks = now

    device = Ticks()
    with Emulator(device, speed=50):
        time.sleep(0.2)
    assert device.ticks == pytest.approx(10, rel=0.5)
    assert list(itertools.islice(device.frames, 1)) == []


def test_a_log_all_round_has_a_return_at_its_seam():
    beams = np.linspace(-math.pi, math.pi, 360, endpoint=False) + 0.3
    scan = LaserScan(angles=beams, ranges=np.arange(1.0, 361.0), range_max=400.0)
    step = math.tau / 360
    for around in (-math.tau, 0.0, math.tau):
        asked = np.array([beams[0] - 0.3 * step, beams[-1] + 0.3 * step, beams[0] - 0.6 * step])
        assert sampled(scan, asked + around).tolist() == [1.0, 360.0, 360.0]
    half = LaserScan(angles=beams[:180], ranges=np.ones(180))
    assert np.isnan(sampled(half, np.array([beams[0] - 2 * step, beams[179] + 2 * step]))).all()
