"""Table I: the paper's rows, the scans' totals, and what comes out."""

import csv
import math
from dataclasses import asdict

import numpy as np
import pytest
from recordings import DATA
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.data import LineSegments
from laserfeatures.evaluation import Truth, truth_of
from laserfeatures.simulation import Scanner
from laserfeatures.testbench import table1
from laserfeatures.testbench.measuring import Measured, extract, measure, trials_of
from laserfeatures.testbench.paper import (
    REAL_FEATURES,
    REAL_LINES,
    TABLE1,
    TABLE2,
    PaperRow,
    paper_extractor,
)
from laserfeatures.testbench.reasons import reasons_of
from laserfeatures.testbench.scans import any_scans, on_grid, paper_scans
from laserfeatures.testbench.trends import trends

PAPER = DATA.parent / "paper"
needs_paper = pytest.mark.skipif(
    not PAPER.is_dir(), reason="the paper's tables (../shared/paper) are not here"
)


@needs_paper
@pytest.mark.parametrize(("name", "rows"), [("table1.csv", TABLE1), ("table2.csv", TABLE2)])
def test_rows_are_those_of_the_paper(name, rows):
    text = (PAPER / name).read_text().splitlines()
    read = list(csv.DictReader(line for line in text if not line.startswith("#")))
    assert [{key: float(value) for key, value in row.items()} for row in read] == [
        asdict(row) for row in rows
    ]


def test_the_literal_algorithm_has_the_papers_parameters():
    extractor = paper_extractor(math.radians(2), 0.05, 31, 51)
    detector = extractor.detector
    assert detector.neighborhood == (51, 31)  # along d, along theta
    assert (detector.min_votes, detector.max_peaks, detector.max_distance) == (4, 8, 0.04)
    assert detector.relative_threshold == 0.15
    assert extractor.segment_filter.min_points == 4
    assert extractor.segment_filter.max_error == 0.02
    assert extractor.segment_filter.min_angle == math.radians(15)
    assert extractor.intersections.max_distance == 20
    assert TABLE1[-1].extractor.detector.theta_step == math.radians(5)
    assert TABLE1[-1].extractor.detector.distance_step == 0.1
    assert TABLE1[-1].extractor.detector.neighborhood == (7, 11)


@pytest.mark.parametrize("seed", [1, 2, 7])
def test_the_scans_have_the_papers_totals(seed):
    truths = [truth_of(scan) for scan in paper_scans(seed)]
    assert len(truths) == 250
    assert sum(t.theta.size for t in truths) == pytest.approx(REAL_LINES, rel=0.05)
    assert sum(len(t.corners) for t in truths) == pytest.approx(REAL_FEATURES, rel=0.05)


def test_the_scans_are_the_papers_sensor_in_worlds_of_their_own():
    scans = paper_scans(1, 20)
    assert all(len(s.scan) == 181 and s.scan.range_max == 10 for s in scans)
    assert len({s.world.walls.tobytes() for s in scans}) == 20
    assert all(s.scan.valid.mean() > 0.5 for s in scans)


def test_the_same_seed_gives_the_same_scans_and_another_one_others():
    first, again, other = (paper_scans(seed, 5) for seed in (1, 1, 2))
    for a, b in zip(first, again, strict=True):
        assert np.array_equal(a.scan.ranges, b.scan.ranges)
    assert not np.array_equal(first[0].scan.ranges, other[0].scan.ranges)


def test_another_scanner_sees_the_same_worlds():
    few, many = (any_scans(3, 5, Scanner(beams=beams)) for beams in (91, 361))
    for a, b in zip(few, many, strict=True):
        assert np.array_equal(a.world.walls, b.world.walls)
        assert a.pose == b.pose


def test_trends_go_by_what_changes_within_a_resolution():
    rows = [
        {
            "theta_step": paper.dtheta_deg,
            "distance_step": paper.dd_cm,
            "neighborhood": [paper.v_theta, paper.v_d],
            "tp_percent": 10.0 * number,
            "fp_percent": 30.0,
            "paper": asdict(paper),
        }
        for number, paper in enumerate(TABLE1)
    ]
    steps = trends(rows)
    assert len(steps) == 12
    assert steps[0] == {
        "resolution": "1°, 2 cm", "from": "1 x 1", "to": "11 x 21", "TP_paper": "+14.2",
        "TP_ours": "+10.0", "FP_paper": "-40.2", "FP_ours": "+0.0", "same": "TP",
    }  # fmt: skip
    assert steps[4]["resolution"] == "3°, 2 cm"
    assert steps[5]["same"] == "TP, FP"  # the paper's FP changes by 0.2 % there: not at all


def counted(result):
    """Return a result as plain figures but for the times, which differ."""
    rows = [{**row, "time_ms": None} for row in result.rows]
    defaults = [
        {**row, "time_ms": None, "confusion": row["confusion"].tolist()} for row in result.defaults
    ]
    return str((result.real_lines, result.real_features, rows, result.reasons, defaults))


@pytest.fixture(scope="module")
def result():
    return table1.run(seed=3, scans=8, workers=1)


@needs_compiler
def test_results_do_not_depend_on_the_workers(result):
    assert counted(table1.run(seed=3, scans=8, workers=2)) == counted(result)


@needs_compiler
def test_rows_stand_beside_the_papers(result):
    assert len(result.rows) == 18
    for row, paper in zip(result.rows, TABLE1, strict=True):
        assert (row["theta_step"], row["distance_step"]) == (paper.dtheta_deg, paper.dd_cm)
        assert row["neighborhood"] == [paper.v_theta, paper.v_d]
        assert row["paper"] == {key: getattr(paper, key) for key in table1.FIGURES}
        assert row["lines_filtered"] <= row["lines_detected"] <= 8 * 8
        assert row["features_matched"] <= row["features_extracted"]
        share = row["features_matched"] / result.real_features
        assert row["tp_percent"] == pytest.approx(100 * share)
        assert 0 < row["time_ms"] < 1000


@needs_compiler
def test_every_extractor_has_a_row_and_the_oracle_the_last(result):
    names = [row["extractor"] for row in result.defaults]
    assert names == [*lf.list_extractors(), "oracle"]
    best = result.defaults[-1]
    assert best["oracle_share"] == 1
    assert best["f1"] > 0.9
    assert best["time_ms"] is None
    assert best["lines_detected"] == result.real_lines
    ours = result.defaults[names.index("direct_hough")]
    literal = max(row["tp_percent"] for row in result.rows)
    assert ours["tp_percent"] > literal
    assert 0.5 < ours["oracle_share"] < 1.1


@needs_compiler
def test_reasons_add_up(result):
    for row, reason in zip(result.rows, result.reasons, strict=True):
        assert reason["true_lines"] == result.real_lines
        found = sum(reason[f"found_{what}"] for what in ("true", "copies", "false"))
        kept = sum(reason[f"kept_{what}"] for what in ("true", "copies", "false"))
        assert (found, kept) == (row["lines_detected"], row["lines_filtered"])
        false = row["features_extracted"] - row["features_matched"]
        assert reason["false_corners"] == false
        assert sum(reason[what] for what in ("shallow", "stray", "off")) == false


@needs_compiler
def test_a_line_in_the_window_of_a_stronger_one_is_shadowed():
    beams = np.repeat([0, 1, 2], [80, 60, 41])
    truth = Truth(
        theta=np.array([0.0, 0.0, math.pi / 2]),
        d=np.array([3.0, 3.3, 2.0]),
        line=beams,
        corners=np.empty((0, 2)),
        pairs=np.empty((0, 2), int),
        real=np.empty(0, bool),
    )
    angles = np.linspace(-0.7, 0.7, 181)
    scan = lf.LaserScan(angles=angles, ranges=3 / np.cos(angles), range_max=10)
    wide, narrow = (PaperRow(1, 2, 5, cells) for cells in (31, 29))
    trials = {"trials": [(scan, truth)], "on_grid": [(scan, truth)]}
    assert reasons_of(wide, **trials)["shadowed"] == 1  # 15 cells are 0.30 m
    assert reasons_of(narrow, **trials)["shadowed"] == 0
    assert reasons_of(wide, **trials)["weak"] == 0


def test_on_the_grid_the_right_angled_walls_have_whole_multiples():
    seen = paper_scans(1, 12)
    turned = on_grid(seen, 1, table1.HEADINGS)
    off = 0
    for before, after in zip(seen, turned, strict=True):
        assert (before.pose.x, before.pose.y) == (after.pose.x, after.pose.y)
        theta = np.degrees(truth_of(after).theta) / 30
        off += int((abs(theta - theta.round()) > 1e-6).sum())
    lines = sum(truth_of(after).theta.size for after in turned)
    assert off < 0.1 * lines  # the walls that cut off a corner


@needs_compiler
def test_measuring_counts_before_and_after_the_filter():
    trials = trials_of(paper_scans(1, 3))
    extractor = TABLE1[0].extractor
    measured = measure(extractor, trials)
    assert isinstance(measured, Measured)
    detected = [extractor.detector(scan) for scan, _ in trials]
    assert measured.lines_detected == sum(len(found.lines) for found in detected)
    kept = [extractor.segment_filter(found) for found in detected]
    assert measured.lines_filtered == sum(len(found.lines) for found in kept)


def test_an_extractor_of_points_has_no_lines():
    (trial,) = trials_of(paper_scans(1, 1))
    found, features = extract(lf.get_extractor("kanade_tomasi"), trial, 0)
    assert isinstance(found, LineSegments)
    assert len(found.lines) == 0
    assert len(features.corners) > 0


def test_an_extractor_that_fails_is_named_with_the_scan(monkeypatch):
    monkeypatch.setattr("laserfeatures.registry._registered", {})

    def detector(_scan):
        raise ZeroDivisionError("by nothing")

    lf.register_extractor("broken", lambda: detector)
    with pytest.raises(lf.PluginError, match="broken failed at scan 0: ZeroDivisionError: by noth"):
        measure(lf.get_extractor("broken"), trials_of(paper_scans(1, 1)))
