"""The client `lds2d` takes the emulated RPLIDARs and LDROBOTs for real devices."""

import numpy as np
import pytest
from client_environments import client_python, run_client
from rplidar_room import ROOM, STAND, excess, room_feed

from laserfeatures.emulators import Emulator, WorldFeed
from laserfeatures.emulators.ld19 import Ld19Device
from laserfeatures.emulators.rplidar import RPLidarDevice

LDS2D = "lds2d==0.7.0"


def scans_of(factory, device, model):
    python = client_python(factory, LDS2D)
    with Emulator(device) as emulator:
        return run_client(python, "lds2d_scans.py", emulator.port, model, "4")["scans"]


@pytest.mark.parametrize(("model", "fewest", "most"), [("A1", 250, 310), ("C1", 450, 550)])
def test_an_rplidar(tmp_path_factory, model, fewest, most):
    device = RPLidarDevice(room_feed(), model=model)
    scans = scans_of(tmp_path_factory, device, f"RPLIDAR-{model}")
    points = np.concatenate(scans)
    # It cuts turns wherever the angle goes back, which at the front it may do twice.
    assert fewest * 2 < len(points) < most * 4
    assert excess(points, 0.02).max() < 2.0


def test_an_ld19(tmp_path_factory):
    scans = scans_of(tmp_path_factory, Ld19Device(WorldFeed(ROOM, STAND, range_sigma=0)), "LD19")
    for scan in scans:
        assert len(scan) == pytest.approx(450, abs=15)
        assert excess(scan, 0.5).max() < 5.0
