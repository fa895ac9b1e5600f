import re
import sys

import numpy as np
import pytest
from robots import PLAN_FILE

import laserfeatures as lf
from laserfeatures.optional import install_line
from laserfeatures.simulation import read_plan
from laserfeatures.simulation.robot import drive
from laserfeatures.sources.formats import FORMATS
from laserfeatures.sources.simulated import is_plan, readings_of


@pytest.fixture
def plan_file(tmp_path):
    path = tmp_path / "plan"  # told by its content
    path.write_text(PLAN_FILE)
    return path


def test_a_plan_is_a_source_of_the_scans_of_its_drive(plan_file):
    with lf.open_source(plan_file) as source:
        scans = list(source)
    assert source.format == "plan"
    assert source.poses == "odometry"
    readings = list(drive(read_plan(plan_file)))
    assert len(scans) == len(readings) > 50
    for scan, reading in zip(scans, readings, strict=True):
        np.testing.assert_array_equal(scan.ranges, reading.scan.ranges)
        assert scan.pose == reading.scan.pose
        assert scan.stamp == reading.scan.stamp
    assert scans[-1].pose != readings[-1].observation.pose  # odometry has drifted


def test_a_shorter_range_is_taken(plan_file):
    with lf.open_source(plan_file, range_max=2.0) as source:
        scan = next(source)
    assert scan.range_max == 2.0
    assert scan.ranges[scan.valid].max() < 2.0
    assert not scan.valid.all()


def test_a_world_without_a_drive_says_what_to_add(tmp_path):
    path = tmp_path / "world.toml"
    path.write_text(PLAN_FILE.partition("[drive]")[0])
    with pytest.raises(lf.SourceError, match=r"world.toml: .* add a table \[drive\] with waypoint"):
        lf.open_source(path)


@pytest.mark.parametrize(
    ("before", "after", "complaint"),
    [
        ("[drive]", "[[drive]]", r"plan:\d+: "),
        ("waypoints", "waypionts", r"plan:\d+: .*did you mean 'waypoints'"),
        ("[[outline]]", "[[wal]]", r"plan:\d+: .*'wal'.*did you mean 'wall'"),
        ("seed = 3", "seed = ", r"plan:\d+: expected TOML"),
        (
            "[1.5, 2.5]",
            "[1.5, 4.5]",
            r"plan: the robot is stuck at .* to way-point 3 \(1\.5, 4\.5\) against box 0",
        ),
        ("seed = 3", "speed = 5.0", r"plan: speed must be at most 1.0 m/s"),
        ("[1, 1]", "[0.1, 1]", r"plan: the robot does not fit at way-point 0 .*wall 3"),
    ],
)
def test_mistakes_in_a_plan_are_errors_of_one_line_with_its_name(
    plan_file, before, after, complaint
):
    plan_file.write_text(PLAN_FILE.replace(before, after))
    with (
        pytest.raises(lf.SourceError, match=complaint) as error,
        lf.open_source(plan_file) as scans,
    ):
        for _ in scans:
            pass
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "head",
    [
        b"[[wall]]\n",
        b"# a plan\n\n  [[ pole ]] # of oak\r\n",
        b"title = 'x'\n[drive]\n",
        b"[[wal]]\nfrom = [0, 0]\n",
    ],
)
def test_plans_are_told_by_their_tables(head):
    assert is_plan(head)


@pytest.mark.parametrize(
    "head", [b"FLASER 1 2.5 0 0 0 0 0 0\n", b"[1, 2]\n[3, 4]\n", b"angle,range\n", b"a [wall] here"]
)
def test_other_texts_are_no_plans(head):
    assert not is_plan(head)


def test_no_other_format_claims_a_plan():
    head = PLAN_FILE.encode()
    assert [name for name, format_ in FORMATS.items() if format_.is_it(head)] == ["plan"]


def test_the_seed_can_be_another_than_the_plans(plan_file):
    own, same, other = (next(readings_of(plan_file, seed=seed)) for seed in (None, 3, 4))
    np.testing.assert_array_equal(own.scan.ranges, same.scan.ranges)
    assert (own.scan.ranges != other.scan.ranges).any()


def test_without_mujoco_the_error_says_what_to_install(plan_file, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(lf.MissingDependencyError, match=re.escape(install_line("sim"))):
        lf.open_source(plan_file)
