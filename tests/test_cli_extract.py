import csv
import json
from dataclasses import replace

import numpy as np
import pytest
from cli_runs import carmen_log, fails, run

import laserfeatures as lf
from laserfeatures import registry
from laserfeatures.noise_model import NoiseModel
from laserfeatures.records import COLUMNS, to_record


@pytest.fixture
def log(tmp_path):
    return carmen_log(tmp_path / "hallway.log")


def records(text):
    return [json.loads(line) for line in text.splitlines()]


def test_each_scan_is_a_line_of_json_with_the_library_s_own_numbers(log):
    result = run("extract", log)
    assert result.exit_code == 0
    extractor, model = lf.get_extractor("direct_hough"), NoiseModel()
    with lf.open_source(log) as scans:
        expected = [
            to_record(extractor(scan, noise=model.feed(scan)), index)
            for index, scan in enumerate(scans)
        ]
    assert records(result.stdout) == expected
    assert [record["stamp"] for record in expected] == pytest.approx([0, 0.1, 0.2, 0.3, 0.4])
    assert all(record["lines"] and record["segments"] for record in expected)
    assert any(record["corners"] for record in expected)
    lines, segments, corners = (
        sum(len(record[kind]) for record in expected) for kind in ("lines", "segments", "corners")
    )
    real = sum(corner["real"] for record in expected for corner in record["corners"])
    assert result.stderr == (
        f"laserfeatures: wrote 5 scans with {lines} lines, {segments} segments and {corners} "
        f"corners ({real} real) to standard output\n"
    )


def test_start_and_count_choose_scans_and_keep_their_numbers(log):
    every = records(run("extract", log).stdout)
    assert records(run("extract", log, "--start", 1, "--count", 2).stdout) == every[1:3]
    assert records(run("extract", log, "--start", 3, "--count", 99).stdout) == every[3:]


def test_parameters_reach_detector_and_stages(log):
    result = run("extract", log, "-p", "theta_step=2deg", "-p", "intersections.max_distance=2m")
    extractor = lf.get_extractor(
        "direct_hough",
        theta_step=0.03490658503988659,
        intersections=lf.Intersections(max_distance=2.0),
    )
    model = NoiseModel()
    with lf.open_source(log) as scans:
        expected = [
            to_record(extractor(scan, noise=model.feed(scan)), index)
            for index, scan in enumerate(scans)
        ]
    assert records(result.stdout) == expected
    assert records(run("extract", log).stdout) != expected


def test_min_evidence_chooses_the_surer_lines(log, monkeypatch):
    detector = lf.get_extractor("direct_hough").detector

    def telling(scan):
        found = detector(scan)
        evidence = 10.0 * np.arange(len(found.lines))
        return replace(found, lines=replace(found.lines, evidence=evidence))

    monkeypatch.setitem(registry._registered, "telling", lambda: telling)
    asked = ("extract", log, "-e", "telling", "-p", "intersections.max_distance=20")
    every = records(run(*asked).stdout)
    sure = records(run(*asked, "-p", "segment_filter.min_evidence=15").stdout)
    for before, after in zip(every, sure, strict=True):
        assert after["lines"] == [line for line in before["lines"] if line["evidence"] >= 15]
        kept = [
            corner
            for corner in before["corners"]
            if all(before["lines"][k]["evidence"] >= 15 for k in corner["lines"])
        ]
        for name in ("x", "y", "evidence"):
            assert [each[name] for each in after["corners"]] == [each[name] for each in kept]
    assert any(record["corners"] for record in sure)
    assert sum(len(r["lines"]) for r in sure) < sum(len(r["lines"]) for r in every)
    message = fails("extract", log, "-p", "segment_filter.min_evidence=-1")
    assert "min_evidence must be >= 0, got -1.0" in message


def test_range_max_drops_farther_returns(log):
    near = records(run("extract", log, "--range-max", "300cm", "--noise", "scan").stdout)
    with lf.open_source(log, range_max=3.0) as scans:
        extractor = lf.get_extractor("direct_hough")
        assert near == [to_record(extractor(scan), index) for index, scan in enumerate(scans)]


def test_a_file_holds_what_standard_output_would(log, tmp_path):
    result = run("extract", log, "-o", tmp_path / "out.jsonl")
    assert result.exit_code == 0
    assert not result.stdout
    assert result.stderr.startswith("laserfeatures: wrote 5 scans with ")
    assert result.stderr.endswith(f" to {tmp_path / 'out.jsonl'}\n")
    assert (tmp_path / "out.jsonl").read_text() == run("extract", log).stdout


def table(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_the_ending_csv_makes_a_table_of_corners(log, tmp_path):
    result = run("extract", log, "-o", tmp_path / "out.CSV")
    assert result.exit_code == 0
    rows = table(tmp_path / "out.CSV")
    assert tuple(rows[0]) == COLUMNS["corners"]
    whole = records(run("extract", log).stdout)
    assert len(rows) == sum(len(record["corners"]) for record in whole)
    corner = rows[0]
    first = whole[int(corner["index"])]["corners"][0]
    assert float(corner["x"]) == first["x"]
    assert float(corner["cov_xy"]) == first["cov"][0][1]
    assert float(corner["evidence"]) == first["evidence"]
    assert all(value for row in rows for value in row.values())
    real = sum(row["real"] == "True" for row in rows)
    assert result.stderr == (
        f"laserfeatures: wrote {len(rows)} corners ({real} real) of 5 scans to "
        f"{tmp_path / 'out.CSV'}\n"
    )


@pytest.mark.parametrize("kind", ["lines", "segments", "corners"])
def test_rows_chooses_their_kind_and_help_names_the_columns(log, tmp_path, kind):
    result = run("extract", log, "--rows", kind, "-o", tmp_path / "out.csv")
    assert result.exit_code == 0, result.output
    rows = table(tmp_path / "out.csv")
    assert tuple(rows[0]) == COLUMNS[kind]
    assert len(rows) == sum(len(r[kind]) for r in records(run("extract", log).stdout))
    assert all(value for row in rows for value in row.values())
    assert f"wrote {len(rows)} {kind}" in result.stderr
    page = " ".join(run("extract", "--help").stdout.split())
    assert f"{kind} {', '.join(COLUMNS[kind][3:])} " in page


def test_rows_without_a_table_is_refused(log, tmp_path):
    assert "-o must end in .csv, got '-'" in fails("extract", log, "--rows", "lines")
    path = tmp_path / "a.jsonl"
    assert "-o must end in .csv" in fails("extract", log, "--rows", "lines", "-o", path)
    assert not path.exists()


def corners_of(*arguments):
    result = run("extract", "example:clutter", "--count", 6, *arguments)
    assert result.exit_code == 0, result.output
    found = records(result.stdout)
    return found, [corner for record in found for corner in record["corners"]]


def worst(corner):
    return np.sqrt(np.linalg.eigvalsh(corner["cov"])[-1])


def test_real_only_leaves_virtual_corners_out():
    (whole, every), (chosen, real) = corners_of(), corners_of("--real-only")
    assert real == [corner for corner in every if corner["real"]]
    assert 0 < len(real) < len(every)
    assert [record["lines"] for record in chosen] == [record["lines"] for record in whole]


@pytest.mark.parametrize("extractor", ["direct_hough", "kanade_tomasi"])
def test_max_sigma_bounds_the_worst_direction_of_any_extractors_corners(extractor):
    _, every = corners_of("-e", extractor)
    _, chosen = corners_of("-e", extractor, "--max-sigma", "12mm")
    assert chosen == [corner for corner in every if worst(corner) <= 0.012]
    assert 0 < len(chosen) < len(every)
    _, wider = corners_of("-e", extractor, "--max-sigma", "1m")  # more than the default of 0.25 m
    assert len(wider) >= len(every)
    assert max(map(worst, wider)) > max(map(worst, every)) or extractor == "kanade_tomasi"


def test_min_evidence_bounds_that_of_lines_and_corners():
    whole, every = corners_of()
    chosen, sure = corners_of("--min-evidence", 18)
    for record, all_of_it in zip(chosen, whole, strict=True):
        assert record["lines"] == [line for line in all_of_it["lines"] if line["evidence"] >= 18]
    places = [
        (corner["x"], corner["y"])
        for record in whole
        for corner in record["corners"]
        if corner["evidence"] >= 18
        and min(record["lines"][k]["evidence"] for k in corner["lines"]) >= 18
    ]
    assert [(corner["x"], corner["y"]) for corner in sure] == places
    assert 0 < len(sure) < len(every)
    assert corners_of("--min-evidence", 0) == (whole, every)
    assert not corners_of("-e", "kanade_tomasi", "--min-evidence", 1)[1]  # it tells none


@pytest.mark.parametrize(
    "command", [["extract"], ["plot", "--scan", 0, "-o", "a.png"], ["compare"]]
)
@pytest.mark.parametrize(
    ("option", "value", "message"),
    [
        ("--max-sigma", "-1", "max_sigma must be > 0 m, got -1.0"),
        ("--max-sigma", "5deg", "is a length"),
        ("--min-evidence", "nan", "min_evidence must be >= 0, got nan"),
        ("--min-evidence", "-3", "min_evidence must be >= 0, got -3.0"),
    ],
)
def test_a_limit_that_makes_no_sense_is_one_line(log, command, option, value, message):
    assert message in fails(*command, log, option, value)


def test_a_start_past_the_end_says_how_many_there_are(log, tmp_path):
    line = fails("extract", log, "--start", 5, "-o", tmp_path / "out.jsonl")
    assert "there is no scan 5: the log has 5, 0 to 4" in line
    assert [path.name for path in tmp_path.iterdir()] == ["hallway.log"]


def broken(log):
    with open(log, encoding="ascii") as file:  # noqa: PTH123 - a string as users give it
        lines = file.readlines()
    lines[2] = "FLASER 181 1.0 oops\n"
    with open(log, "w", encoding="ascii") as file:  # noqa: PTH123 - the same
        file.writelines(lines)


def test_a_broken_record_leaves_no_file(log, tmp_path):
    broken(log)
    line = fails("extract", log, "-o", tmp_path / "out.jsonl")
    assert "hallway.log:3" in line
    assert [path.name for path in tmp_path.iterdir()] == ["hallway.log"]


def test_skipping_says_how_many_and_why(log):
    broken(log)
    result = run("extract", log, "--on-error", "skip")
    assert result.exit_code == 0
    assert [record["index"] for record in records(result.stdout)] == [0, 1, 2, 3]
    assert result.stderr.startswith("laserfeatures: skipped 1 broken record; the first: ")
    assert "hallway.log:3" in result.stderr
    assert result.stderr.splitlines()[-1].startswith("laserfeatures: wrote 4 scans with ")


def test_an_extractor_that_fails_is_named_with_the_scan(log, tmp_path, monkeypatch):
    detector = lf.get_extractor("direct_hough").detector

    def fragile(scan):
        if scan.stamp > 0.15:
            raise ZeroDivisionError("oh\nno")
        return detector(scan)

    monkeypatch.setitem(registry._registered, "fragile", lambda: fragile)
    line = fails("extract", log, "-e", "fragile", "-o", tmp_path / "out.jsonl")
    assert "extractor 'fragile' failed at scan 2: ZeroDivisionError: oh no" in line
    assert [path.name for path in tmp_path.iterdir()] == ["hallway.log"]


def test_an_extractor_that_cannot_be_made_is_named(log, monkeypatch):
    def factory():
        raise RuntimeError("no licence")

    monkeypatch.setitem(registry._registered, "shy", factory)
    assert "extractor 'shy' cannot be made: RuntimeError: no licence" in fails(
        "extract", log, "-e", "shy"
    )
