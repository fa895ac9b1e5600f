import json
import math
from dataclasses import replace

import numpy as np
import pytest

from laserfeatures import Features, LaserScan, Lines, LineSegments, PointFeatures
from laserfeatures.records import COLUMNS, to_record, to_rows


def corner(stamp=12.5, rms=0.002):
    lines = Lines(
        theta=[0.0, 1.5], d=[2.0, -1.0], support=[5, 4], covariance=[[[0.0] * 2] * 2] * 2,
        evidence=[30.5, 7.25],
    )  # fmt: skip
    segments = LineSegments(
        lines=lines,
        line=[1, 0],
        endpoints=[[[1.0, 2.0], [3.0, 4.0]], [[5.0, 6.0], [7.0, 8.0]]],
        support=[4, 5],
        rms=[rms, 0.001],
        points=[[True], [False]],
    )
    corners = PointFeatures(
        positions=[[0.1, 1 / 3]],
        covariance=[[[1e-4, 2e-5], [2e-5, 3e-4]]],
        lines=[[0, 1]],
        angles=[1.5],
        real=[True],
        evidence=[7.25],
    )
    scan = LaserScan(angles=[0.0], ranges=[2.0], stamp=stamp)
    return Features(scan=scan, segments=segments, corners=corners)


def nothing():
    scan = LaserScan(angles=[0.0], ranges=[math.inf])
    lines = Lines(theta=[], d=[], support=[], covariance=_empty(2, 2))
    segments = LineSegments(
        lines=lines, line=[], endpoints=_empty(2, 2), support=[], rms=[], points=_empty(1)
    )
    corners = PointFeatures(
        positions=_empty(2), covariance=_empty(2, 2), lines=_empty(2), angles=[], real=[]
    )
    return Features(scan=scan, segments=segments, corners=corners)


def _empty(*shape):
    return np.empty((0, *shape))


def test_a_corner_without_lines_names_none():
    features = replace(corner(), corners=replace(corner().corners, lines=[[-1, -1]]))
    record = to_record(features)
    assert record["corners"][0]["lines"] is None
    (row,) = to_rows(record, "corners")
    assert row["line_1"] is row["line_2"] is None
    assert row["x"] == 0.1


def test_a_record_holds_everything_in_full():
    assert to_record(corner(), 3) == {
        "index": 3,
        "stamp": 12.5,
        "lines": [
            {"theta": 0.0, "d": 2.0, "support": 5, "evidence": 30.5},
            {"theta": 1.5, "d": -1.0, "support": 4, "evidence": 7.25},
        ],
        "segments": [
            {"line": 1, "x1": 1.0, "y1": 2.0, "x2": 3.0, "y2": 4.0, "support": 4, "rms": 0.002},
            {"line": 0, "x1": 5.0, "y1": 6.0, "x2": 7.0, "y2": 8.0, "support": 5, "rms": 0.001},
        ],
        "corners": [
            {
                "x": 0.1,
                "y": 1 / 3,
                "lines": [0, 1],
                "angle": 1.5,
                "real": True,
                "cov": [[1e-4, 2e-5], [2e-5, 3e-4]],
                "evidence": 7.25,
            }
        ],
    }


def test_a_record_survives_json():
    record = to_record(corner(), 3)
    text = json.dumps(record, allow_nan=False)
    assert json.loads(text) == record
    assert '"support": 5, ' in text


def test_what_is_not_finite_is_null():
    record = to_record(corner(stamp=math.nan, rms=math.inf))
    assert record["index"] is None
    assert record["stamp"] is None
    assert record["segments"][0]["rms"] is None
    assert record["segments"][1]["rms"] == 0.001
    assert json.dumps(record, allow_nan=False)


def test_nothing_found_is_empty_lists_and_no_rows():
    record = to_record(nothing(), 0)
    assert record == {"index": 0, "stamp": None, "lines": [], "segments": [], "corners": []}
    assert not [row for kind in COLUMNS for row in to_rows(record, kind)]


def test_a_table_has_one_kind_of_row_and_each_fills_all_columns():
    record = to_record(corner(), 3)
    assert list(COLUMNS) == ["lines", "segments", "corners"]
    for kind, columns in COLUMNS.items():
        rows = list(to_rows(record, kind))
        assert [row["id"] for row in rows] == list(range(len(record[kind])))
        for row in rows:
            assert set(row) == set(columns)
            assert None not in row.values()
            assert (row["index"], row["stamp"]) == (3, 12.5)


def test_a_corners_row_names_its_lines_and_spells_out_its_covariance():
    (row,) = to_rows(to_record(corner(), 3), "corners")
    assert (row["line_1"], row["line_2"], row["evidence"]) == (0, 1, 7.25)
    assert [row[f"cov_{key}"] for key in ("xx", "xy", "yy")] == [
        pytest.approx(value) for value in (1e-4, 2e-5, 3e-4)
    ]
