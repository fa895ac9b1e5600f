"""``laserfeatures testbench``: pages, figures and pictures, complete or not at all."""

import csv
import io
import json
import os
import re
import signal
import time

import pytest
from cli_runs import fails, run, start
from click.testing import CliRunner
from recordings import DATA, needs_recordings
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.cli import main
from laserfeatures.testbench import noise, table1, table2
from laserfeatures.testbench.paper import TABLE1
from laserfeatures.testbench.real.recordings import RECORDINGS
from laserfeatures.testbench.table2_page import table2_page

PARTS = ("", "_trends", "_reasons", "_defaults")
ROW = {
    "theta_step", "distance_step", "neighborhood", "lines_detected", "lines_filtered",
    "features_matched", "features_extracted", "tp_percent", "fp_percent", "time_ms", "paper",
}  # fmt: skip


pytestmark = needs_compiler


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Run table1 on few scans; return its folder, JSON and output."""
    folder = tmp_path_factory.mktemp("testbench")
    result = run(
        "testbench", "table1", "-o", folder / "new" / "folder", "--json", folder / "t.json",
        "--scans", 4, "--seed", 3, "--workers", 1,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    text = (folder / "t.json").read_text()
    return folder / "new" / "folder", json.loads(text, parse_constant=pytest.fail), result


def test_json_has_what_was_asked_for(made):
    _, found, _ = made
    assert set(found) == {"real_lines", "real_features", "rows", "defaults"}
    assert len(found["rows"]) == 18
    for row, paper in zip(found["rows"], TABLE1, strict=True):
        assert set(row) == ROW
        assert row["paper"] == {key: getattr(paper, key) for key in table1.FIGURES}
        assert row["neighborhood"] == [paper.v_theta, paper.v_d]
    assert [row["extractor"] for row in found["defaults"]] == [*lf.list_extractors(), "oracle"]
    for row in found["defaults"]:
        assert set(row) > ROW - {"theta_step", "distance_step", "neighborhood", "paper"}
        assert {"f1", "oracle_share", "median_error", "line_recall", "duplicates"} < set(row)
        assert {"corner_consistency", "line_consistency", "confusion"} < set(row)


def test_the_folder_has_the_page_and_its_figures(made):
    folder, found, result = made
    files = {path.name for path in folder.iterdir()}
    assert files == {"table1.md", *(f"table1{part}.csv" for part in PARTS)}
    rows = list(csv.DictReader(io.StringIO((folder / "table1.csv").read_text())))
    assert [int(row["lines_detected"]) for row in rows] == [
        row["lines_detected"] for row in found["rows"]
    ]
    page = (folder / "table1.md").read_text()
    row = found["rows"][0]
    cell = f"{row['lines_detected']} (2000)"
    assert f"| 1 | 2 | 1 x 1 | {cell} |" in page
    assert cell in result.stdout
    assert result.stdout.rstrip().endswith(f"are in {folder}")
    assert not result.stderr


def test_what_is_printed_is_aligned(made):
    lines = made[2].stdout.splitlines()
    table = lines[3 : 3 + 18]
    assert len({len(line) for line in table}) == 1
    assert all(re.match(r" *[1235] +(2|5|10)  ", line) for line in table)


def test_figures_and_noise_are_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(noise, "AXES", tuple(axis_of(axis) for axis in noise.AXES))
    one = ("-o", tmp_path, "--json", tmp_path / "n.json", "--scans", 2, "--workers", 1)
    assert run("testbench", "noise", *one).exit_code == 0
    assert run("testbench", "figures", "-o", tmp_path).exit_code == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "n.json", "noise.md", "noise.csv", "noise.png", "figure6.png", "figure7.png",
        "figures.csv", "figures.md",
    }  # fmt: skip
    found = json.loads((tmp_path / "n.json").read_text(), parse_constant=pytest.fail)
    assert (found["scans"], found["seed"]) == (2, 2)
    assert {row["axis"] for row in found["rows"]} == {axis.name for axis in noise.AXES}


@needs_recordings
def test_the_page_of_table_2_stands_beside_the_paper():
    arena = [recording for recording in RECORDINGS if recording.truth == "arena"]
    result = table2.run(DATA, recordings=arena)
    files = table2_page(result).files
    page = files["table2.md"].decode()
    row = result.rows[0]
    assert f"| {row['features_matched']} (135) | {row['features_extracted']} (157) |" in page
    blind = list(csv.DictReader(io.StringIO(files["table2_blind.csv"].decode())))
    assert [line["recording"] for line in blind] == ["arena", "all"]
    assert list(files)[-1] == "table2.md"


def test_table_2_needs_its_recordings(tmp_path):
    said = fails("testbench", "table2", "-o", tmp_path / "out", "--data", tmp_path / "nowhere")
    assert str(tmp_path / "nowhere") in said
    assert "--data" in said


def axis_of(axis):
    """Return an axis with its first and last values, for a short run."""
    return noise.Axis(axis.name, axis.label, axis.field, axis.unit, axis.values[:1])


def test_an_interrupted_run_leaves_the_old_files(tmp_path):
    folder, old = tmp_path / "out", tmp_path / "t.json"
    folder.mkdir()
    (folder / "table1.md").write_text("old")
    old.write_text("{}")
    arguments = ("table1", "-o", folder, "--json", old, "--scans", 3000, "--workers", 2)
    with start("testbench", *arguments, start_new_session=True) as process:
        try:
            until = time.monotonic() + 60
            while len(list(tmp_path.iterdir())) < 3:  # the JSON under another name
                assert time.monotonic() < until
                time.sleep(0.05)
            time.sleep(2)
            os.killpg(process.pid, signal.SIGINT)
            out, said = process.communicate(timeout=60)
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
    assert process.returncode == 130
    assert said.strip() == b"laserfeatures: interrupted"
    assert out == b""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "t.json"]
    assert [path.name for path in folder.iterdir()] == ["table1.md"]
    assert (folder / "table1.md").read_text() == "old"
    assert old.read_text() == "{}"


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    said = fails("testbench", "figures", "-o", tmp_path / "file" / "in")
    assert "file/in cannot be made: Not a directory" in said
    assert "is a file" in fails("testbench", "figures", "-o", tmp_path / "file")


@pytest.mark.parametrize(
    ("option", "value"), [("--workers", "0"), ("--scans", "0"), ("--seed", "-1"), ("--scans", "x")]
)
def test_numbers_that_make_no_sense_are_refused(option, value, tmp_path):
    said = fails("testbench", "table1", "-o", tmp_path, option, value)
    assert option in said
    assert not list(tmp_path.iterdir())


def test_every_part_is_listed_with_the_same_options():
    testbench = main.commands["testbench"]
    assert set(testbench.commands) == {"table1", "table2", "noise", "figures", "all"}
    for name in ("table1", "noise", "all"):
        text = CliRunner().invoke(main, ["testbench", name, "--help"]).output
        for option in ("--output", "--json", "--seed", "--scans", "--workers"):
            assert option in text
