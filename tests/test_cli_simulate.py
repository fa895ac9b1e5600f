import json
import math
import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from cli_runs import fails, run
from robots import PLAN_FILE

import laserfeatures as lf


@pytest.fixture
def plan_file(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(PLAN_FILE)
    return path


def test_a_log_is_written_that_reads_back(plan_file, tmp_path):
    log = tmp_path / "run.log"
    result = run("simulate", plan_file, "-o", log)
    assert result.exit_code == 0, result.output
    assert not result.stdout
    with lf.open_source(log) as scans:
        told = list(scans)
    said = re.fullmatch(
        r"laserfeatures: wrote (\d+) scans along ([\d.]+) m in ([\d.]+) s to (.*)\n", result.stderr
    )
    assert (int(said[1]), said[4]) == (len(told), str(log))
    assert float(said[3]) == pytest.approx(told[-1].stamp, abs=0.06)
    way = sum(math.dist((a.x, a.y), (b.x, b.y)) for a, b in pairwise(s.pose for s in told))
    assert float(said[2]) == pytest.approx(way, rel=0.1)
    with lf.open_source(log) as scans, lf.open_source(plan_file) as driven:
        for scan, direct in zip(scans, driven, strict=True):
            np.testing.assert_array_equal(scan.ranges[scan.valid], direct.ranges[direct.valid])


def test_seed_and_scanner_take_the_place_of_the_plans(plan_file, tmp_path):
    def log(*options):
        path = tmp_path / "run.log"
        assert run("simulate", plan_file, "-o", path, *options).exit_code == 0
        return path.read_text()

    assert log() == log("--seed", 3)
    assert log() != log("--seed", 4)
    hokuyo = log("--scanner", "urg04lx_ug01")
    assert "FLASER 181" not in hokuyo
    assert "ROBOTLASER1 0 " in hokuyo
    rows = run("info", tmp_path / "run.log").stdout
    assert "239.8 deg" in rows


def test_without_a_file_the_log_goes_to_standard_output(plan_file, tmp_path):
    result = run("simulate", plan_file)
    assert result.exit_code == 0
    run("simulate", plan_file, "-o", tmp_path / "run.log")
    assert result.stdout == (tmp_path / "run.log").read_text()


def test_the_other_commands_take_a_plan_for_a_log(plan_file, tmp_path):
    info = run("info", plan_file)
    assert info.exit_code == 0, info.output
    assert "odometry" in info.stdout
    extracted = run(
        *("extract", plan_file, "--extractor", "region_growing", "--start", 2, "--count", 3)
    )
    assert extracted.exit_code == 0, extracted.output
    records = [json.loads(line) for line in extracted.stdout.splitlines()]
    assert [record["index"] for record in records] == [2, 3, 4]
    assert all(record["corners"] for record in records)
    page = tmp_path / "report.md"
    compared = run(
        *("compare", plan_file, "--extractors", "region_growing", "--count", 12), "-o", page
    )
    assert compared.exit_code == 0, compared.output
    assert "raw odometry" in page.read_text()


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (PLAN_FILE.partition("[drive]")[0], "add a table [drive]"),
        (
            PLAN_FILE.replace("[4, 1]", "[6, 1]"),
            "on its way to way-point 1 (6, 1) against wall 1: no progress",
        ),
        (PLAN_FILE.replace("[drive]", "[drive"), "expected TOML"),
        (PLAN_FILE.replace("seed", "sead"), "did you mean 'seed'"),
    ],
)
def test_a_plan_that_cannot_be_driven_leaves_no_log(tmp_path, content, complaint):
    path = tmp_path / "room.toml"
    path.write_text(content)
    line = fails("simulate", path, "-o", tmp_path / "run.log")
    assert complaint in line
    assert str(path) in line
    assert list(tmp_path.iterdir()) == [path]
    if "stuck" not in line and "no progress" not in line:  # else it has driven, and told so far
        assert complaint in fails("simulate", path)  # nor a word of one on standard output


def test_arguments_that_make_no_sense(plan_file, tmp_path):
    assert "would overwrite the input" in fails("simulate", plan_file, "-o", plan_file)
    assert "'lms200'" in fails("simulate", plan_file, "--scanner", "lms")
    assert "No such file" in fails("simulate", tmp_path / "none.toml", "-o", tmp_path / "run.log")
    assert "--seed" in fails("simulate", plan_file, "--seed", -1)


def test_a_scanner_that_sees_farther_than_a_log_can_say_is_an_error_of_one_line(tmp_path):
    path = tmp_path / "hall.toml"
    path.write_text(
        "[[outline]]\npoints = [[0, 0], [200, 0], [200, 4], [0, 4]]\n"
        "[scanner]\nrange_max = 300.0\n[drive]\nwaypoints = [[2, 2], [4, 2]]\n"
    )
    line = fails("simulate", path, "-o", tmp_path / "run.log")
    assert "ranges below 81.825 m" in line
    assert str(path) in line


def test_mujoco_is_imported_only_to_drive():
    code = "import laserfeatures.cli, laserfeatures.simulation.robot, sys; print(*sys.modules)"
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert "mujoco" not in done.stdout.split()
