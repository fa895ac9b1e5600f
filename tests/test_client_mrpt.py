"""MRPT's C++ drivers take the emulators for real devices; its RPLIDARs run Slamtec's own SDK.

Needs Debian's packages libmrpt-hwdrivers-dev, cmake and a C++ compiler.
"""

import math
import subprocess
from pathlib import Path
from shutil import which

import numpy as np
import pytest

from laserfeatures.emulators import Emulator, WorldFeed
from laserfeatures.emulators.devices import device_class
from laserfeatures.scan import Pose2D
from laserfeatures.simulation import World
from laserfeatures.simulation.raycast import cast

SOURCE = Path(__file__).parent / "clients/mrpt_client.cpp"
PROJECT = f"""
cmake_minimum_required(VERSION 3.16)
project(client CXX)
set(CMAKE_CXX_STANDARD 17)
find_package(mrpt-hwdrivers REQUIRED)
add_executable(client {SOURCE})
target_link_libraries(client mrpt::hwdrivers)
"""
ROOM = World.outline([(-2, -1.5), (3, -1.5), (3, 2), (-2, 2)])
SCANS = 4

pytestmark = pytest.mark.skipif(
    not (which("cmake") and list(Path("/usr").glob("lib/*/cmake/mrpt-hwdrivers"))),
    reason="MRPT is not installed (apt-get install libmrpt-hwdrivers-dev cmake g++)",
)


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    folder = tmp_path_factory.mktemp("mrpt")
    (folder / "CMakeLists.txt").write_text(PROJECT)
    for command in (["cmake", "."], ["cmake", "--build", "."]):
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)  # noqa: S603 - ours
        assert done.returncode == 0, done.stderr
    return folder / "client"


def scans_of(client, name, *arguments):
    """Return field of view [rad] and ranges [m] of some scans that MRPT reads."""
    device = device_class(name)(WorldFeed(ROOM, Pose2D(0, 0, 0), range_sigma=0.0))
    with Emulator(device) as emulator:
        done = subprocess.run(  # noqa: S603 - the program built above
            [client, name, emulator.port, str(SCANS), *arguments],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines() if line.startswith("scan ")]
    assert len(lines) == SCANS
    return [(float(line[3]), np.array(line[4:], dtype=float)) for line in lines[1:]]


def true_ranges(angles):
    return cast(ROOM, np.zeros(2), angles)[0]


@pytest.mark.parametrize(
    ("name", "arguments", "beams", "view"),
    [("urg", [], 682, 239.77), ("lms", ["38400"], 361, 180.0)],
)
def test_scans_come_through_mrpt(client, name, arguments, beams, view):
    for aperture, ranges in scans_of(client, name, *arguments):
        assert len(ranges) == beams
        assert aperture == pytest.approx(math.radians(view), abs=0.02)
        off = abs(ranges - true_ranges(np.linspace(-0.5, 0.5, beams) * aperture))
        assert np.median(off) < 0.01
        assert np.quantile(off, 0.95) < 0.03


def test_slamtecs_sdk_reads_an_rplidar(client):
    """MRPT puts what the SDK measures, turning clockwise, into 360 places one after the other."""
    for aperture, ranges in scans_of(client, "rplidar"):
        assert aperture == pytest.approx(-2 * math.pi, abs=1e-4)
        number = np.flatnonzero(ranges)
        assert len(number) > 250
        steps = np.radians(np.linspace(0.4, 1.4, 2001))
        off = [np.median(abs(ranges[number] - true_ranges(-number * step))) for step in steps]
        assert min(off) < 0.02
