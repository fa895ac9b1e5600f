"""Asking a source for raw odometry, or for poses that are corrected."""

import io
import math

import numpy as np
import pytest
from recordings import DATA, needs_recordings
from robots import PLAN_FILE

import laserfeatures as lf
from laserfeatures.poses import compose, relative
from laserfeatures.simulation import Scanner
from laserfeatures.sources.carmen_writer import write_carmen
from laserfeatures.sources.simulated import readings_of

MOUNTING = lf.Pose2D(0.2, 0, 0)
START = lf.Pose2D(0, 0, 0)
RANGES = "2 2.0 2.5"


def way(count=12, turn=0.1):
    return [lf.Pose2D(0.1 * i, 0.03 * i, turn * i) for i in range(count)]


def flaser(lasers, robots, before=""):
    lines = [before]
    for laser, robot in zip(lasers, robots, strict=True):
        poses = " ".join(f"{v:.6f}" for p in (laser, robot) for v in (p.x, p.y, p.theta))
        lines.append(f"FLASER {RANGES} {poses} 1 host 1\n")
    return "".join(lines)


def read(path, text, poses):
    path.write_text(text)
    with lf.open_source(path, poses=poses) as source:
        return source.poses, [scan.pose for scan in source]


def assert_close(poses, expected):
    for pose, wanted in zip(poses, expected, strict=True):
        off = relative(wanted, pose)
        assert math.hypot(off.x, off.y) < 1e-5
        assert abs(off.theta) < 1e-5


@pytest.fixture
def path(tmp_path):
    return tmp_path / "robot.log"


def test_a_log_as_recorded_has_odometry_in_both_places(path):
    robots = way()
    lasers = [compose(robot, MOUNTING) for robot in robots]
    for wanted in (None, "odometry"):
        poses, found = read(path, flaser(lasers, robots), wanted)
        assert poses == "odometry"
        assert_close(found, lasers)
    with pytest.raises(lf.SourceError, match="more than odometry, got one with raw odometry"):
        read(path, flaser(lasers, robots), "corrected")


@pytest.mark.parametrize("mark", ["", "NEFF 1 0 host 0\n"])
@pytest.mark.parametrize("mounted", [True, False])
def test_a_corrected_log_with_odometry_beside_has_both(path, mark, mounted):
    robots = way()
    turned = lf.Pose2D(500, -3, 1)  # odometry starts anywhere
    lasers = [compose(robot, MOUNTING) for robot in way(turn=0.05)]
    param = "PARAM robot_frontlaser_offset 0.2\n" if mounted else ""
    text = flaser(lasers, [compose(turned, robot) for robot in robots], param + mark)
    poses, found = read(path, text, "corrected")
    assert poses == "corrected"
    assert_close(found, lasers)
    poses, found = read(path, text, "odometry")
    assert poses == "odometry"
    offset = MOUNTING if mounted else START  # it is not known then
    assert_close(found, [compose(compose(turned, robot), offset) for robot in robots])
    poses, found = read(path, text, None)
    assert poses == "corrected"


def test_where_no_param_says_it_the_first_record_shows_how_the_laser_is_mounted(path):
    lasers = [compose(robot, MOUNTING) for robot in way(turn=0.05)]
    _, found = read(path, flaser(lasers, way(), "NEFF 1 0 host 0\n"), "odometry")
    assert_close(found, [compose(robot, MOUNTING) for robot in way()])


def test_a_corrected_log_without_odometry_is_refused(path):
    lasers = way(30)
    expected = "expected a log with raw odometry, got one with corrected poses only"
    for text in (
        flaser(lasers, lasers, "NEFF 1 0 host 0\n"),
        flaser(lasers[:1], lasers[:1]) + flaser(lasers, lasers, "NEFF 1 0 host 0\n"),
    ):
        with pytest.raises(lf.SourceError, match=f"robot.log: {expected}"):
            read(path, text, "odometry")
        assert read(path, text, "corrected")[0] == "corrected"


def test_a_robot_that_stands_for_long_is_waited_for(path):
    lasers = [START] * 1100 + way(turn=0.05)
    robots = [START] * 1100 + way()
    poses, found = read(path, flaser(lasers, robots, "NEFF 1 0 host 0\n"), "odometry")
    assert poses == "odometry"
    assert_close(found, robots)


def test_a_mounting_that_is_no_number_is_named(path):
    with pytest.raises(lf.SourceError, match=r":1: expected PARAM robot_frontlaser_offset in m"):
        read(path, "PARAM robot_frontlaser_offset far\n" + flaser(way(), way()), "odometry")


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("plan") / "room.toml"
    path.write_text(PLAN_FILE)
    return path


@pytest.mark.parametrize(("record", "view"), [("FLASER", math.pi), ("ROBOTLASER1", 2.0)])
def test_a_simulated_drive_gives_back_its_odometry_and_its_truth(path, plan_file, record, view):
    scanner = Scanner(beams=90, field_of_view=view)
    readings = list(readings_of(plan_file, scanner=scanner))
    file = io.StringIO()
    write_carmen(file, readings)
    assert f"\n{record} " in file.getvalue()
    for wanted, expected in (
        ("odometry", [reading.scan.pose for reading in readings]),
        ("corrected", [reading.observation.pose for reading in readings]),
    ):
        poses, found = read(path, file.getvalue(), wanted)
        assert poses == wanted
        assert_close(found, expected)


def test_a_plan_has_odometry_and_truth(plan_file):
    truth = [reading.observation.pose for reading in readings_of(plan_file)]
    for wanted in ("odometry", "corrected"):
        with lf.open_source(plan_file, poses=wanted) as source:
            assert source.poses == wanted
            poses = [scan.pose for scan in source]
        assert (poses == truth) == (wanted == "corrected")


def test_what_a_tables_poses_are_its_user_says(path, tmp_path):
    archive = tmp_path / "scans.npz"
    np.savez(archive, ranges=np.ones((1, 2)), angles=[0, 0.1], poses=[[2, 3, 0]])
    for wanted in ("odometry", "corrected"):
        found = read(path, "stamp,x,y,theta,0,0.1\n1,2,3,0,1,1\n", wanted)
        assert found == (wanted, [lf.Pose2D(2, 3, 0)])
        with lf.open_source(archive, poses=wanted) as source:
            assert source.poses == wanted
    with pytest.raises(lf.SourceError, match="raw odometry, got one with no poses"):
        read(path, "stamp,0,0.1\n1,1,1\n", "odometry")


def test_a_port_has_no_poses_and_there_are_two_kinds():
    with pytest.raises(lf.SourceError, match="got a port"):
        lf.open_source("urg:///dev/ttyACM0", poses="odometry")
    with pytest.raises(ValueError, match="poses must be 'odometry' or 'corrected', got 'raw'"):
        lf.open_source("x.log", poses="raw")


@needs_recordings
def test_of_the_real_logs_only_the_raw_ones_have_odometry():
    for path in ("sick/csail-corrected.log.gz", "sick/flirt_mit-cscail.log.gz"):
        with pytest.raises(lf.SourceError, match="corrected poses only"):
            lf.open_source(DATA / path, poses="odometry")
    for path in ("sick/csail.corrected.gfs.gz", "urg/breezy_exp1.dat.gz", "urg/brenner_robot4"):
        with lf.open_source(DATA / path, poses="odometry") as source:
            assert source.poses == "odometry"
        with pytest.raises(lf.SourceError, match="got one with raw odometry"):
            lf.open_source(DATA / path, poses="corrected")
