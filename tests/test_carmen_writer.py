import io
import math

import numpy as np
import pytest
from robots import room

import laserfeatures as lf
from laserfeatures.simulation import Scanner, World, hallway
from laserfeatures.simulation.robot import drive
from laserfeatures.sources.carmen_writer import write_carmen


def written(readings):
    file = io.StringIO()
    write_carmen(file, readings)
    return file.getvalue()


def read_back(path, text):
    path.write_text(text, encoding="ascii")
    with lf.open_source(path) as source:
        scans = list(source)
    return source, scans


def same(scans, others):
    """Check that the scans are the same, but for limits that no return shows."""
    assert len(scans) == len(others) > 0
    for scan, other in zip(scans, others, strict=True):
        np.testing.assert_allclose(scan.angles, other.angles, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(scan.valid, other.valid)
        np.testing.assert_array_equal(scan.ranges[scan.valid], other.ranges[other.valid])
        assert scan.stamp == other.stamp or math.isnan(other.stamp)


@pytest.mark.parametrize(
    "scanner",
    [
        Scanner(),  # directions follow from the number of beams: FLASER
        Scanner(beams=361, range_max=3.0),
        Scanner.model("urg04lx_ug01"),
        Scanner(beams=720, field_of_view=2 * math.pi * 719 / 720, range_max=2.5),
        Scanner(dropouts=0.1, outliers=0.05, range_min=1.2),
        Scanner(dropouts=1.0),
    ],
)
def test_a_drive_comes_back_as_it_was(tmp_path, scanner):
    readings = list(drive(room(9.0, 7.0, scanner=scanner, scan_rate=2.0)))
    source, scans = read_back(tmp_path / "run.log", written(readings))
    assert source.format == "carmen"
    assert source.poses == "corrected"
    same(scans, [reading.scan for reading in readings])
    assert [scan.pose for scan in scans] == [reading.observation.pose for reading in readings]


def test_the_log_says_where_the_laser_sits_and_holds_the_odometry():
    readings = list(drive(room(scan_rate=2.0)))
    lines = written(readings).splitlines()
    assert "PARAM robot_frontlaser_offset 0.06" in lines
    odometry = [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith("ODOM")]
    flaser = [line.split() for line in lines if line.startswith("FLASER")]
    expected = [(r.odometry.x, r.odometry.y, r.odometry.theta) for r in readings]
    assert odometry == expected
    assert [tuple(map(float, fields[-6:-3])) for fields in flaser] == expected
    speeds = [float(line.split()[4]) for line in lines if line.startswith("ODOM")]
    assert speeds[0] == 0
    assert max(speeds) == pytest.approx(0.4, rel=0.02)


def test_plain_scans_are_written_with_their_pose(tmp_path):
    """Noise-free scans too, whose equal ranges must not pass for no returns."""
    world, path = hallway()
    scanner = Scanner(range_sigma=0.0)
    rng = np.random.default_rng(1)
    scans = [scanner.scan(world, pose, rng) for pose in path]
    source, again = read_back(tmp_path / "run.log", written(scans))
    assert source.poses == "odometry"
    assert [scan.pose for scan in again] == path
    same(again, scans)
    assert all(math.isnan(scan.stamp) for scan in again)


@pytest.mark.parametrize("beams", [0, 1, 2])
def test_scans_of_few_beams(tmp_path, beams):
    scan = lf.LaserScan.uniform(
        [2.0] * beams, 0.25, 0.5, range_max=9.0, stamp=5.0, pose=lf.Pose2D(1, 2, 3)
    )
    _, (again,) = read_back(tmp_path / "run.log", written([scan]))
    same([again], [scan])


def test_what_a_log_cannot_hold():
    beams = {"ranges": [1.0, 2.0, 3.0], "pose": lf.Pose2D(0, 0, 0)}
    uneven = lf.LaserScan(angles=[0.0, 0.1, 0.3], **beams)
    with pytest.raises(ValueError, match=r"evenly spaced directions, got steps of 0\.1 to 0\.2"):
        written([uneven])
    with pytest.raises(ValueError, match=r"scans with poses, got none at 7\.5 s"):
        written([lf.LaserScan(angles=[0.0], ranges=[1.0], stamp=7.5)])
    far = lf.LaserScan(angles=[0.0, 0.1, 0.2], ranges=[1.0, 90.0, 3.0], pose=lf.Pose2D(0, 0, 0))
    with pytest.raises(ValueError, match=r"ranges below 81\.825 m, got 90\.0 m"):
        written([far])


def test_readings_are_written_one_by_one():
    """What was read before an error is in the file; memory does not grow."""
    file = io.StringIO()
    pose = lf.Pose2D(1.0, 1.0, 0.0)
    world = World.outline([(0, 0), (3, 0), (3, 3), (0, 3)])

    def scans():
        yield Scanner().scan(world, pose, np.random.default_rng(1))
        raise RuntimeError

    with pytest.raises(RuntimeError):
        write_carmen(file, scans())
    assert file.getvalue().count("FLASER 181 ") == 1


def test_no_scans_give_a_log_of_nothing():
    assert all(line.startswith("#") for line in written([]).splitlines())
