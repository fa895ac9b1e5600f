"""The RPLIDAR driver against the emulated device, on a real pseudo-terminal."""

import os
import time

import numpy as np
import pytest
from bounded import until
from rplidar_room import ROOM, STAND, off_the_walls, room_feed

from laserfeatures.drivers import make_driver
from laserfeatures.drivers.port import Port
from laserfeatures.drivers.reader import Reader
from laserfeatures.drivers.rplidar import RPLidar, driver
from laserfeatures.drivers.rplidar.motor import Motor
from laserfeatures.emulators import Emulator, Faults, ScansFeed, WorldFeed
from laserfeatures.emulators.feed import sampled
from laserfeatures.emulators.ld19 import Ld19Device
from laserfeatures.emulators.rplidar import START_STATES, RPLidarDevice
from laserfeatures.errors import DeviceLostError, DriverError, DriverTimeoutError, ProtocolError
from laserfeatures.scan import LaserScan

SLOWEST_OPENING = 8.0  # [s]


@pytest.fixture
def hasty(monkeypatch):
    """Make the driver lose its patience sooner, where what counts is what happens then."""
    for name, value in (("FIND", 0.3), ("ROUNDS", 1), ("SPIN_UP", 0.6), ("SLOWEST", 0.25)):
        monkeypatch.setattr(driver, name, value)


def scans_of(device, count=2, **parameters):
    """Return scans of a device on a pseudo-terminal, and the driver, closed."""
    with Emulator(device) as emulator, RPLidar(port=emulator.port, **parameters) as lidar:
        return [next(lidar) for _ in range(count)], lidar


@pytest.mark.parametrize(
    ("start", "scan_mode", "beams"),
    [
        *((start, "auto", 1125) for start in START_STATES),
        ("streaming", "standard", 281),
        ("streaming", "express", 562),
    ],
)
def test_a_device_in_any_state_is_taken_over(start, scan_mode, beams):
    device = RPLidarDevice(room_feed(), start=start)
    begin = time.monotonic()
    scans, lidar = scans_of(device, scan_mode=scan_mode)
    assert time.monotonic() - begin < SLOWEST_OPENING
    for scan in scans:
        assert len(scan) == pytest.approx(beams, abs=12)
        assert off_the_walls(scan).max() < 0.015
    assert lidar.losses.refusals == (start == "protection")
    assert lidar.losses.damaged == lidar.losses.garbage == lidar.losses.missed == 0
    assert device._stream is None  # stopped on leaving


@pytest.mark.parametrize(("model", "start"), [("A2", "idle"), ("A3", "streaming"), ("C1", "idle")])
def test_baud_rate_and_motor_of_other_models(model, start):
    device = RPLidarDevice(room_feed(), model=model, start=start)
    (scan, _), lidar = scans_of(device)
    assert lidar.info.model == device.model.code
    assert scan.range_max == device.model.modes[device.model.typical].max_distance
    assert off_the_walls(scan).max() < 0.015
    assert device.motor_on == (not device.model.pwm)  # turned off again where that can be


def test_firmware_that_knows_no_configuration():
    device = RPLidarDevice(room_feed(), troubles=["old_firmware"])
    (scan, _), lidar = scans_of(device)
    assert lidar.info.firmware == (1, 20)
    assert len(scan) == pytest.approx(562, abs=10)  # an express scan
    assert (scan.range_min, scan.range_max) == (0.15, 12.0)


def test_the_stamp_is_the_time_of_measurement():
    device = RPLidarDevice(room_feed())
    with Emulator(device) as emulator, RPLidar(port=emulator.port) as lidar:
        for _ in range(3):
            scan = next(lidar)
            age = time.time() - scan.stamp
            assert 0.14 < age < 0.26  # a turn, and a capsule or two
            assert 0 < lidar.arrival - scan.stamp < 0.03


def test_scans_out_are_scans_in():
    rng = np.random.default_rng(4)
    angles = np.radians(np.arange(-179.5, 180.0))
    given = [LaserScan(angles=angles, ranges=rng.uniform(1, 10, 360)) for _ in range(30)]
    device = RPLidarDevice(ScansFeed(lambda: given))
    scans, _ = scans_of(device, 4, scan_mode="standard")
    for scan in scans:
        errors = [np.nanmedian(abs(sampled(one, scan.angles) - scan.ranges)) for one in given]
        best = given[int(np.argmin(errors))]
        error = abs(sampled(best, scan.angles) - scan.ranges)
        assert (error < 0.0002).mean() > 0.99  # the quarter of a millimetre; ends of cells apart


def test_a_device_that_stays_broken_names_its_error():
    device = RPLidarDevice(room_feed(), troubles=["broken"])
    with pytest.raises(DriverError, match="error 0x8002, also after a reset"):
        scans_of(device)


def test_a_warning_is_kept():
    _, lidar = scans_of(RPLidarDevice(room_feed(), troubles=["warning"]))
    assert lidar.losses.problem == "the device warns with code 0x0011"


@pytest.mark.usefixtures("hasty")
def test_a_motor_that_is_not_turned_on():
    device = RPLidarDevice(room_feed(), model="A2")
    with pytest.raises(DriverTimeoutError, match="check that its motor turns"):
        scans_of(device, motor="dtr", scan_mode="standard")


def test_pwm_alone_turns_the_motor():
    device = RPLidarDevice(room_feed(), model="A2")
    scans, _ = scans_of(device, motor="pwm", scan_mode="standard")
    assert len(scans) == 2


def test_silence():
    primary, replica = os.openpty()
    begin = time.monotonic()
    with pytest.raises(DriverTimeoutError, match="got silence"), RPLidar(port=os.ttyname(replica)):
        pass
    assert time.monotonic() - begin < SLOWEST_OPENING
    os.close(primary)
    os.close(replica)


@pytest.mark.usefixtures("hasty")
def test_another_device_is_named():
    device = Ld19Device(WorldFeed(ROOM, STAND))
    with Emulator(device) as emulator:
        begin = time.monotonic()
        lidar = RPLidar(port=emulator.port, baud=device.baud)
        with pytest.raises(ProtocolError, match="an LD06 or LD19"), lidar:
            pass
        assert time.monotonic() - begin < SLOWEST_OPENING


@pytest.mark.usefixtures("hasty")
def test_a_wrong_baud_rate_is_not_mistaken_for_a_device():
    device = RPLidarDevice(room_feed(), model="A3", start="streaming")
    with Emulator(device) as emulator:
        lidar = RPLidar(port=emulator.port, baud=115_200)
        with pytest.raises(ProtocolError, match="wrong baud rate"), lidar:
            pass


@pytest.mark.usefixtures("hasty")
@pytest.mark.parametrize("fault", ["stuck", "restart"])
def test_a_sweep_that_ends_is_started_again(fault):
    device = RPLidarDevice(room_feed(), Faults(stuck_time=1.4))
    with Emulator(device) as emulator, RPLidar(port=emulator.port) as lidar:
        next(lidar)
        device.faults.rates[fault] = 1.0
        until(lambda: any(name for _, name in device.frames))
        device.faults.rates.clear()
        scans = [next(lidar) for _ in range(4)]
    assert lidar.losses.silences >= 1
    assert lidar.losses.restarts >= 1
    assert max(off_the_walls(scan).max() for scan in scans) < 0.015


def test_an_unplugged_device():
    device = RPLidarDevice(room_feed(), Faults({"unplug": 0.02}, seed=1))
    with pytest.raises(DeviceLostError, match="is gone"):
        scans_of(device, 60)


def test_an_unplugged_device_comes_back(tmp_path):
    device = RPLidarDevice(room_feed(), Faults({"unplug": 0.01}, seed=1, unplugged_time=0.2))
    link = tmp_path / "lidar"
    emulator = Emulator(device, link=link)
    with emulator, RPLidar(port=str(link), reconnect=True) as lidar:
        until(lambda: lidar.losses.reconnects, lambda: next(lidar))
        device.faults.rates.clear()
        scan = next(lidar)
    assert off_the_walls(scan).max() < 0.015


def test_the_line_dtr_stops_the_motor_of_an_a1():
    port = Port("loop://", 115_200)  # has modem lines, as a pseudo-terminal has not
    lidar = RPLidar(port="loop://")
    reader = Reader(port, lidar.decoder(), 4, None)
    motor = Motor(reader, lidar.duty)
    assert port._serial.dtr  # as pyserial opens it
    motor.line_on()
    assert not port._serial.dtr
    motor.off()
    assert port._serial.dtr
    reader.stop()


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"scan_mode": "fast"}, "scan_mode must be one of auto, standard, express"),
        ({"motor": "on"}, "motor must be one of"),
        ({"duty": 1024}, "duty must be in 1 .. 1023"),
        ({"coverage": 0}, "coverage must be in"),
        ({"min_quality": 64}, "min_quality must be in"),
        ({"baud": -1}, "baud must be > 0"),
    ],
)
def test_parameters_are_checked(parameters, problem):
    with pytest.raises(ValueError, match=problem):
        RPLidar(port="/dev/null", **parameters)


def test_an_address_takes_the_parameters():
    lidar = make_driver("rplidar:///dev/ttyUSB0?scan_mode=express&coverage=0.5&motor=pwm")
    assert isinstance(lidar, RPLidar)
    assert (lidar.scan_mode, lidar.coverage, lidar.motor) == ("express", 0.5, "pwm")
