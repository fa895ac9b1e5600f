import copy
import dataclasses
import math
import pickle

import numpy as np
import pytest
from scenes import segments_of

from laserfeatures import Features, LaserScan, Lines, LineSegments, PointFeatures, Pose2D

LINES = {
    "theta": [0.0, 1.0],
    "d": [1.0, -2.0],
    "support": [5, 6],
    "covariance": np.zeros((2, 2, 2)),
    "evidence": [0.0, math.inf],
}
SEGMENTS = {
    "lines": Lines(**LINES),
    "line": [1, 1, 0],
    "endpoints": np.arange(12.0).reshape(3, 2, 2),
    "support": [3, 3, 5],
    "rms": [0.1, 0.2, 0.3],
    "points": np.zeros((3, 7), bool),
}
CORNERS = {
    "positions": [(1, 2)],
    "covariance": np.zeros((1, 2, 2)),
    "lines": [(0, 1)],
    "angles": [1.0],
    "real": [True],
    "evidence": [7.5],
}
KINDS = [(Lines, LINES), (LineSegments, SEGMENTS), (PointFeatures, CORNERS)]


@pytest.mark.parametrize(("kind", "fields"), KINDS)
def test_fields_are_read_only_c_contiguous_copies(kind, fields):
    record = kind(**fields)
    for name, value in fields.items():
        if name == "lines" and kind is LineSegments:
            continue
        array = getattr(record, name)
        np.testing.assert_array_equal(array, value)
        assert array is not value
        assert array.flags.c_contiguous
        assert not array.flags.writeable


def test_length_is_the_number_of_lines_segments_or_corners():
    assert [len(kind(**fields)) for kind, fields in KINDS] == [2, 3, 1]


@pytest.mark.parametrize(("kind", "fields"), KINDS)
def test_fields_cannot_be_set(kind, fields):
    record = kind(**fields)
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(record, next(iter(fields)), None)


@pytest.mark.parametrize(
    ("kind", "fields", "wrong"),
    [
        (kind, fields, name)
        for kind, fields in KINDS
        for name in fields
        if not isinstance(fields[name], Lines)
    ],
)
def test_a_field_of_the_wrong_shape_is_named_with_both_shapes(kind, fields, wrong):
    value = np.zeros((1, 2, 3, 4))
    with pytest.raises(ValueError, match=rf"{wrong} must have shape \(.*\), got \(1, 2, 3, 4\)"):
        kind(**{**fields, wrong: value})


def test_fields_must_be_as_many():
    with pytest.raises(ValueError, match=r"d must have shape \(2\), got \(3,\)"):
        Lines(**{**LINES, "d": [1, 2, 3]})
    with pytest.raises(ValueError, match=r"points must have shape \(3, n\), got \(2, 7\)"):
        LineSegments(**{**SEGMENTS, "points": np.zeros((2, 7), bool)})


@pytest.mark.parametrize("theta", [-0.1, math.pi, math.nan])
def test_theta_lies_below_pi(theta):
    with pytest.raises(ValueError, match=r"theta must lie in \[0, pi\) rad, got \[0\.0, "):
        Lines(**{**LINES, "theta": [0.0, theta]})


@pytest.mark.parametrize(("kind", "fields"), [KINDS[0], KINDS[2]])
def test_evidence_that_is_left_out_is_zeros(kind, fields):
    record = kind(**{name: value for name, value in fields.items() if name != "evidence"})
    assert record.evidence.tolist() == [0.0] * len(record)
    assert not record.evidence.flags.writeable


@pytest.mark.parametrize("evidence", [-0.1, math.nan, -math.inf])
@pytest.mark.parametrize(("kind", "fields"), [KINDS[0], KINDS[2]])
def test_evidence_is_not_negative(kind, fields, evidence):
    given = [*fields["evidence"][1:], evidence]
    with pytest.raises(ValueError, match=rf"evidence must be >= 0 and not nan, got \[.*{evidence}"):
        kind(**{**fields, "evidence": given})


@pytest.mark.parametrize("line", [-1, 2])
def test_a_segment_is_of_one_of_the_lines(line):
    with pytest.raises(ValueError, match=r"line must index one of the 2 lines, got \[0, 0, "):
        LineSegments(**{**SEGMENTS, "line": [0, 0, line]})


def test_types_are_float_int_and_bool():
    segments, corners = LineSegments(**SEGMENTS), PointFeatures(**CORNERS)
    assert segments.line.dtype == corners.lines.dtype == np.int64
    assert segments.points.dtype == corners.real.dtype == np.bool_
    assert segments.support.dtype == corners.positions.dtype == np.float64


def test_lengths_are_from_end_to_end():
    segments = segments_of([0.3], [2.0], [(0, -1.0, 2.5, range(5), 0.0)])
    assert segments.lengths.tolist() == pytest.approx([3.5])


def test_features_hold_the_lines_of_their_segments():
    segments = LineSegments(**SEGMENTS)
    scan = LaserScan(angles=[], ranges=[])
    features = Features(scan=scan, segments=segments, corners=PointFeatures(**CORNERS))
    assert features.lines is segments.lines


def pickled(data):
    return pickle.loads(pickle.dumps(data))  # noqa: S301 - our own bytes


@pytest.mark.parametrize("again", [copy.deepcopy, pickled])
def test_what_was_pickled_or_copied_is_the_same_and_read_only(again):
    scan = LaserScan(angles=[0.0, 0.1, 0.2], ranges=[2.0, 3.0, math.inf])
    scan.points  # noqa: B018 - cached, and so pickled
    other = again(scan)
    for field in ("angles", "ranges", "points", "valid", "beams"):
        array = getattr(other, field)
        np.testing.assert_array_equal(array, getattr(scan, field))
        assert not array.flags.writeable
    segments = again(LineSegments(**SEGMENTS))
    assert not segments.lines.theta.flags.writeable
    np.testing.assert_array_equal(segments.endpoints, SEGMENTS["endpoints"])


def test_what_is_printed_is_a_line_or_two_with_counts():
    scan = LaserScan(
        angles=np.linspace(-1, 1, 7), ranges=[0, 1, 2.5, 3, 4, 5, math.inf], stamp=170000.25,
        pose=Pose2D(1.0, -2.0, math.pi / 2),
    )  # fmt: skip
    records = [kind(**fields) for kind, fields in KINDS]
    features = Features(scan=scan, segments=records[1], corners=records[2])
    assert [str(record) for record in (scan, *records)] == [
        (
            "LaserScan(7 beams from -57.3 to 57.3 deg, 5 returns from 1 to 5 m, at 170000.25 s, "
            "pose 1 m, -2 m, 90 deg)"
        ),
        "Lines(2 lines)",
        "LineSegments(3 segments on 2 lines)",
        "PointFeatures(1 corner, 1 real)",
    ]
    assert str(features) == (f"Features(2 lines, 3 segments, 1 corner (1 real)\n  of {scan})")
    assert repr(features) == str(features)
    nothing = LaserScan(angles=[], ranges=[])
    assert str(nothing) == "LaserScan(0 beams, 0 returns)"
    assert str(LineSegments.none(3)) == "LineSegments(0 segments on 0 lines)"


@pytest.mark.parametrize(
    ("kind", "fields"), [*KINDS, (LaserScan, {"angles": [0.0, 0.1], "ranges": [1, 2]})]
)
def test_what_is_no_array_of_numbers_is_named(kind, fields):
    for name in fields:
        if (name == "lines" and kind is LineSegments) or name in {"points", "real"}:
            continue  # anything is true or false
        for value in (["a", "b"], [[1], [1, 2]], {"a": 1}):
            with pytest.raises(ValueError, match=f"^{name} must be an array of numbers: "):
                kind(**{**fields, name: value})


def test_some_corners_are_selected_with_all_that_belongs_to_them():
    corners = PointFeatures(
        positions=[(1, 2), (3, 4), (5, 6)], covariance=[k * np.eye(2) for k in (1, 2, 3)],
        lines=[(0, 1), (0, 2), (1, 2)], angles=[0.5, 1.0, 1.5], real=[True, False, True],
        evidence=[1.0, 2.0, 3.0],
    )  # fmt: skip
    for kept in (corners.real, np.array([0, 2])):
        some = corners.select(kept)
        assert some.positions.tolist() == [[1, 2], [5, 6]]
        assert some.covariance[:, 0, 0].tolist() == [1, 3]
        assert some.lines.tolist() == [[0, 1], [1, 2]]
        assert (some.angles.tolist(), some.evidence.tolist()) == ([0.5, 1.5], [1.0, 3.0])
    assert len(corners.select(np.zeros(3, bool))) == 0
