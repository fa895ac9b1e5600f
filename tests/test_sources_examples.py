"""``example:``: scans without a file, in any installation."""

import json
import math
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from cli_runs import fails, run

import laserfeatures as lf
from laserfeatures.poses import relative
from laserfeatures.simulation.examples import EXAMPLES, example

NAMES = ["hallway", "office", "clutter"]


def read(name, **options):
    with lf.open_source(f"example:{name}", **options) as scans:
        return list(scans)


def test_those_are_all():
    assert list(EXAMPLES) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_a_few_dozen_scans_with_poses_and_stamps_always_the_same(name):
    scans, again = read(name), read(name)
    assert 24 <= len(scans) <= 60
    assert [scan.stamp for scan in scans] == list(range(len(scans)))
    for scan, same in zip(scans, again, strict=True):
        assert np.array_equal(scan.ranges, same.ranges)
        assert scan.pose == same.pose
        millimetres = scan.ranges[scan.valid] * 1000
        np.testing.assert_allclose(millimetres, np.round(millimetres), atol=1e-6)
        assert scan.beams.size > 0.9 * len(scan)


@pytest.mark.parametrize("name", NAMES)
def test_its_odometry_drifts_and_its_corrected_poses_are_true(name):
    odometry, true = read(name, poses="odometry"), read(name, poses="corrected")
    assert read(name)[-1].pose == odometry[-1].pose
    assert [s.pose for s in true] == [shot.observation.pose for shot in example(name)]
    assert odometry[0].pose == true[0].pose
    off = relative(true[-1].pose, odometry[-1].pose)
    assert 0.02 < math.hypot(off.x, off.y) < 2.0
    for before, after in pairwise(true):
        step = relative(before.pose, after.pose)
        assert math.hypot(step.x, step.y) < 1.0
        assert abs(step.theta) < math.radians(65)


def test_the_first_ranges_of_the_hallway_are_these():
    first = read("hallway")[0]
    assert (len(first), first.range_max) == (181, 10.0)
    x, y = first.points[[0, 90]].T  # to the right, and ahead
    assert (x[0], y[0]) == pytest.approx((0.0, -1.0), abs=0.08)
    shot = next(example("hallway"))
    true, _ = EXAMPLES["hallway"].scanner.cast(shot.observation.world, shot.observation.pose)
    np.testing.assert_allclose(first.ranges, true, atol=0.03)


def test_real_corners_of_the_hallway_are_where_its_walls_meet():
    ends = next(example("hallway")).observation.world.walls.reshape(-1, 2)
    extractor = lf.get_extractor("direct_hough")
    found = []
    for scan in read("hallway", poses="corrected"):
        corners = extractor(scan).corners
        found += list(scan.pose.transform(corners.positions[corners.real]))
    off = np.linalg.norm(np.array(found)[:, None] - ends, axis=2).min(axis=1)
    assert len(found) > 100
    assert np.quantile(off, 0.9) < 0.05


def test_any_installation_has_them():
    code = f"""
import sys
for extra in ("mujoco", "matplotlib", "rosbags", "scipy", "open3d", "evo", "pandas", "skimage"):
    sys.modules[extra] = None
import laserfeatures as lf
print([len(list(lf.open_source("example:" + name))) for name in {NAMES}])
"""
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert done.stdout == "[37, 54, 48]\n"
    page = (Path(__file__).parents[1] / "docs/simulation.md").read_text()
    assert re.findall(r"^\| (\w+) \|.*\| (\d+) \|$", page, re.MULTILINE) == [
        ("hallway", "37"), ("office", "54"), ("clutter", "48"),
    ]  # fmt: skip


def test_a_range_limit_overrides_the_scanners():
    assert {scan.range_max for scan in read("office", range_max=3.0)} == {3.0}


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("example:hall", {}, "example:hall: there is no example 'hall'; did you mean 'hallway'"),
        ("example:", {}, "there are: clutter, hallway, office"),
        ("example://office", {}, "there is no example '//office'; did you mean 'office'"),
        ("exmple:/office", {}, "example"),
    ],
)
def test_an_unknown_one_is_refused_with_the_near_ones(name, options, message):
    with pytest.raises(lf.SourceError) as error:
        lf.open_source(name, **options)
    assert message in str(error.value)


def test_options_of_files_are_refused():
    with pytest.raises(ValueError, match="topic does not apply to an example"):
        lf.open_source("example:office", topic="/scan")


def test_a_file_of_that_name_is_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "example:office").write_text("stamp,-0.1,0.1\n5.0,2.0,\n")
    with lf.open_source("example:office") as scans:
        assert scans.format == "csv"


@pytest.mark.parametrize(
    "arguments",
    [
        ["info", "example:clutter"],
        ["extract", "example:office", "--count", 2],
        ["noise", "example:hallway"],
        ["compare", "example:office", "--extractors", "split_and_merge", "--count", 5],
        ["plot", "example:clutter", "--scan", 3, "-o", "scan.png"],
        ["emulate", "urg", "--log", "example:clutter", "--seconds", 1],
        ["slam", "run", "example:hallway", "--reference", "example:hallway", "--count", 8],
    ],
    ids=lambda arguments: arguments[0],
)
def test_commands_take_it_without_the_robots_physics(arguments, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    result = run(*arguments)
    assert result.exit_code == 0, result.output
    assert result.stdout or (tmp_path / "scan.png").stat().st_size > 10_000


def test_slam_finds_the_way_through_the_office(tmp_path):
    summary = tmp_path / "s.json"
    source = "example:office"
    result = run("slam", "run", source, "--reference", source, "--json", summary)
    assert result.exit_code == 0, result.output
    errors = json.loads(summary.read_text())
    assert errors["odometry_ate_rmse"] > 0.3
    assert errors["ate_rmse"] < 0.05


def test_no_output_is_taken_for_the_example(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("extract", "example:office", "--count", 1, "-o", "office").exit_code == 0
    assert "no scan 999" in fails("extract", "example:office", "--start", 999)
