"""RPLIDAR clients written by others take the emulator for a real device."""

import numpy as np
import pytest
from client_environments import client_python, run_client
from rplidar_room import excess, room_feed

from laserfeatures.emulators import Emulator
from laserfeatures.emulators.rplidar import RPLidarDevice
from laserfeatures.emulators.rplidar.device import SERIAL

SCANS = 4


def talk(factory, requirement, script, *arguments, device=None):
    """Return what a client got from a device in the room."""
    python = client_python(factory, requirement)
    device = device or RPLidarDevice(room_feed())
    with Emulator(device) as emulator:
        return run_client(
            python, script, emulator.port, str(device.baud), str(SCANS), *arguments, timeout=40
        )


def check_scans(got, fewest, most, off_by, within=2.0, hole=6):
    """Check number, size and place of the scans."""
    assert len(got["scans"]) >= SCANS
    for scan in got["scans"][1:SCANS]:  # the first is a part of a turn with some clients
        assert fewest <= len(scan) <= most
        degrees = np.sort(np.array(scan)[:, 0] % 360)
        assert np.diff(degrees, append=degrees[0] + 360).max() < hole  # all around
        assert excess(scan, off_by).max() < within


def test_rplidar(tmp_path_factory):
    got = talk(tmp_path_factory, "rplidar==0.9.2", "rplidar_skoltech.py")
    assert got["info"] == {
        "model": 0x18, "firmware": [1, 29], "hardware": 7, "serialnumber": SERIAL
    }  # fmt: skip
    assert got["health"] == got["again"] == ["Good", 0]
    check_scans(got, 270, 290, 0.02)


def test_rplidar_tells_a_warning(tmp_path_factory):
    device = RPLidarDevice(room_feed(), troubles=["warning"])
    got = talk(tmp_path_factory, "rplidar==0.9.2", "rplidar_skoltech.py", device=device)
    assert got["health"] == ["Warning", 0x1100]  # it reads the code's bytes the wrong way round


@pytest.mark.parametrize(
    ("mode", "fewest", "most", "off_by"),
    # In an express scan it takes each angle one measurement too far, 0.64 degrees, and whole
    # capsules.
    [("normal", 270, 290, 0.02), ("express", 544, 576, 0.7)],
)
def test_rplidar_roboticia(tmp_path_factory, mode, fewest, most, off_by):
    got = talk(tmp_path_factory, "rplidar-roboticia==0.9.5", "rplidar_skoltech.py", mode)
    assert got["info"]["serialnumber"] == SERIAL
    assert got["health"] == got["again"] == ["Good", 0]
    check_scans(got, fewest, most, off_by, hole=6 if mode == "normal" else 22)


def test_a_motor_that_waits_for_its_duty(tmp_path_factory):
    device = RPLidarDevice(room_feed(), model="A2")
    got = talk(tmp_path_factory, "rplidar-roboticia==0.9.5", "rplidar_skoltech.py", device=device)
    check_scans(got, 190, 205, 0.02)
    assert not device.motor_on  # it was told to stop


def test_rplidar_roboticia_resets_a_device_that_protects_itself(tmp_path_factory):
    device = RPLidarDevice(room_feed(), start="protection")
    got = talk(tmp_path_factory, "rplidar-roboticia==0.9.5", "rplidar_skoltech.py", device=device)
    assert got["health"][0] == "Error"
    assert got["again"] == ["Good", 0]
    check_scans(got, 270, 290, 0.02)


def test_adafruit(tmp_path_factory):
    requirement = "adafruit-circuitpython-rplidar==1.2.21"
    got = talk(tmp_path_factory, requirement, "rplidar_adafruit.py")
    assert got["info"]["model"] == 0x18
    assert got["info"]["serialnumber"] == bytes.fromhex(SERIAL)[::-1].hex()
    assert got["health"] == ["Good", 0]
    check_scans(got, 270, 290, 0.02)


@pytest.mark.parametrize(
    ("mode", "fewest", "most", "within"),
    [("-1", 270, 290, 2.0), ("0", 555, 575, 2.0), ("2", 1100, 1150, 12.0)],  # ultra: 8 mm steps
)
def test_pyrplidar(tmp_path_factory, mode, fewest, most, within):
    got = talk(tmp_path_factory, "pyrplidar==0.1.2", "rplidar_pyrplidar.py", mode)
    assert got["info"]["serialnumber"] == SERIAL
    assert got["health"] == {"status": 0, "error_code": 0}
    assert got["rate"] == {"t_standard": 508, "t_express": 254}
    assert got["names"] == ["Standard", "Express", "Boost"]
    assert got["typical"] == 2
    check_scans(got, fewest, most, 0.05, within)


@pytest.mark.parametrize("model", ["A1", "C1"])
def test_rplidarc1(tmp_path_factory, model):
    device = RPLidarDevice(room_feed(), model=model)
    got = talk(tmp_path_factory, "rplidarc1==0.1.3", "rplidar_rplidarc1.py", device=device)
    points = np.concatenate(got["scans"])
    assert len(points) == 300 * SCANS
    # It takes the bits of the angle a place too high in the lower byte, and rounds to a third.
    assert excess(points, 1.7).max() < 2.0


@pytest.mark.parametrize(
    ("model", "troubles", "fewest", "most", "within"),
    [
        ("A1", [], 1100, 1150, 12.0),
        ("A1", ["old_firmware"], 555, 575, 2.0),
        ("A2", [], 770, 800, 12.0),
        ("A3", [], 1590, 1615, 12.0),
        ("C1", [], 495, 505, 2.0),
    ],
)
def test_the_vendors_library(tmp_path_factory, model, troubles, fewest, most, within):
    device = RPLidarDevice(room_feed(), model=model, troubles=troubles)
    got = talk(tmp_path_factory, "pyrplidarsdk==0.1.2", "rplidar_sdk.py", device=device)
    assert got["connected"]
    assert got["started"]
    version = device.firmware[0] << 8 | device.firmware[1]
    assert got["info"] == [device.model.code, version, device.model.hardware, SERIAL.lower()]
    assert got["health"] == [0, 0]
    check_scans(got, fewest, most, 0.05, within)
    assert device.motor_on == (not device.model.pwm)
