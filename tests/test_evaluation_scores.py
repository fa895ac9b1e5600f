"""Scores: counts, the paper's measures, errors, and how they add up."""

import math
from dataclasses import fields
from functools import reduce

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracles import corners_at
from scenes import segments_of

import laserfeatures as lf
from laserfeatures import Features, LaserScan, LineSegments, PointFeatures
from laserfeatures.evaluation import Score, Truth, oracle, score, truth_of
from laserfeatures.simulation import Observation, Scanner, World, hallway

seeds = st.integers(0, 10**6).map(np.random.default_rng)
SCAN = LaserScan.uniform(np.ones(12), -1.0, 0.1)
NONE = LineSegments.none(12)
COUNTS = [f.name for f in fields(Score) if f.type is int]
LISTS = ["errors", "angle_errors", "distance_errors", "corner_nees", "line_nees"]
RATES = [
    "tp_percent", "fp_percent", "f1", "median_error", "rms_error",
    "line_recall", "line_precision", "corner_consistency", "line_consistency",
]  # fmt: skip


def found(positions, real=None, segments=NONE, lines=None):
    """Return features with corners there."""
    corners = corners_at(positions)
    return Features(
        scan=SCAN,
        segments=segments,
        corners=PointFeatures(
            positions=corners.positions,
            covariance=corners.covariance,
            lines=corners.lines if lines is None else lines,
            angles=corners.angles,
            real=corners.real if real is None else real,
        ),
    )


def corners_alone(positions, real=None):
    real = np.ones(len(positions), bool) if real is None else real
    return Truth.of_corners(SCAN, np.reshape(positions, (-1, 2)), real)


@pytest.mark.parametrize(
    ("matched", "extracted", "true", "tp", "fp"),
    [
        # Rows of the paper's Table I and, below, of its Table II.
        (496, 1000, 2950, 16.8, 50.4),
        (915, 1019, 2950, 31.0, 10.2),
        (1601, 1601, 2950, 54.3, 0.0),
        (1497, 1511, 2950, 50.7, 0.9),
        (135, 157, 163, 82.8, 14.0),
        (91, 126, 163, 55.8, 27.8),
    ],
)
def test_true_and_false_positives_are_the_papers(matched, extracted, true, tp, fp):
    of_many = Score(features_matched=matched, features_extracted=extracted, features_true=true)
    assert round(of_many.tp_percent, 1) == tp
    assert round(of_many.fp_percent, 1) == fp
    recall, precision = tp / 100, 1 - fp / 100
    harmonic = 2 * recall * precision / (recall + precision)
    assert of_many.f1 == pytest.approx(harmonic, abs=1e-3)


@pytest.mark.parametrize(
    ("counts", "defined"),
    [
        ({}, set()),
        ({"features_true": 4}, {"tp_percent", "f1"}),
        ({"features_extracted": 4}, {"fp_percent", "f1"}),
        ({"lines_true": 4}, {"line_recall"}),
        ({"lines_extracted": 4}, {"line_precision"}),
        ({"errors": np.zeros(1)}, {"median_error", "rms_error"}),
        ({"corner_nees": np.zeros(1)}, {"corner_consistency"}),
        ({"line_nees": np.zeros(1)}, {"line_consistency"}),
    ],
)
def test_what_is_not_defined_is_nan(counts, defined):
    of_counts = Score(**counts)
    assert {name for name in RATES if not math.isnan(getattr(of_counts, name))} == defined


def test_the_shares_and_means_by_hand():
    by_hand = Score(
        lines_true=8,
        lines_extracted=5,
        lines_matched=4,
        errors=np.array([0.03, 0.0, 0.04, 0.0]),
        corner_nees=np.array([5.99, 6.0, math.inf, 0.0]),  # the 95 % point of chi^2 is 5.991
        line_nees=np.array([5.991, 5.992, 1.0]),
    )
    assert (by_hand.line_recall, by_hand.line_precision) == (0.5, 0.8)
    assert by_hand.median_error == pytest.approx(0.015)
    assert by_hand.rms_error == pytest.approx(0.025)
    assert by_hand.corner_consistency == 0.5
    assert by_hand.line_consistency == pytest.approx(2 / 3)


def random_score(rng):
    return Score(
        **{name: int(rng.integers(0, 100)) for name in COUNTS},
        **{name: rng.random(rng.integers(0, 4)) for name in LISTS},
        confusion=rng.integers(0, 9, (2, 2)),
    )


def assert_same(a, b):
    for item in fields(Score):
        np.testing.assert_array_equal(getattr(a, item.name), getattr(b, item.name))


@given(seeds, st.integers(0, 6), st.integers(0, 6))
def test_scores_add_up_in_any_grouping(rng, count, cut):
    scores = [random_score(rng) for _ in range(count)]
    total = Score.total(scores)
    assert_same(sum(scores, Score()), total)
    assert_same(Score.total(scores[:cut]) + Score.total(scores[cut:]), total)
    assert_same(reduce(lambda a, b: b + a, reversed(scores), Score()), total)
    for name in COUNTS:
        assert getattr(total, name) == sum(getattr(part, name) for part in scores)
    for name in LISTS:
        assert getattr(total, name).tolist() == [x for part in scores for x in getattr(part, name)]
    assert total.confusion.tolist() == sum((s.confusion for s in scores), np.zeros((2, 2))).tolist()


def test_a_total_leaves_its_parts_alone():
    part = Score(scans=1, confusion=np.eye(2, dtype=int), errors=np.ones(1))
    Score.total([part, part])
    assert (part.scans, part.confusion.sum(), part.errors.size) == (1, 2, 1)
    assert Score().confusion.sum() == 0


def test_corners_by_hand():
    truth = corners_alone([(0, 0), (1, 0), (2, 0), (3, 0)], [True, True, False, False])
    features = found(
        [(0, 0.1), (1, 0.05), (2.15, 0), (3, 0.3), (9, 9)], [True, False, True, True, True]
    )
    scored = score(features, truth)
    assert (scored.scans, scored.blind_scans) == (1, 0)
    assert (scored.features_true, scored.features_extracted) == (4, 5)
    assert scored.features_matched == 3
    np.testing.assert_allclose(np.sort(scored.errors), [0.05, 0.1, 0.15])
    assert scored.confusion.tolist() == [[0, 1], [1, 1]]  # rows: what is true
    assert (scored.tp_percent, scored.fp_percent) == (75, pytest.approx(40))
    assert score(features, truth, gate=0.301).features_matched == 4
    assert score(features, truth, gate=0.06).features_matched == 1


@pytest.mark.parametrize("real", [True, False])
@pytest.mark.parametrize("called", [True, False])
def test_confusion_has_what_is_true_in_rows_and_what_was_found_in_columns(real, called):
    scored = score(found([(1, 1)], [called]), corners_alone([(1, 1)], [real]))
    assert scored.confusion[int(real), int(called)] == 1
    assert scored.confusion.sum() == 1


def test_scans_in_which_no_corner_is_found_are_blind():
    truth, nothing = corners_alone([(1, 1)]), corners_alone([])
    seen, blind = found([(7, 7)]), found([])
    total = sum(
        (score(*pair) for pair in [(seen, truth), (blind, truth), (blind, nothing)]), Score()
    )
    assert (total.scans, total.blind_scans) == (3, 2)
    assert (total.features_true, total.features_extracted, total.features_matched) == (2, 1, 0)
    assert math.isnan(score(blind, nothing).f1)
    assert score(seen, nothing).fp_percent == 100


def scene():
    """Return what is true of three walls, two seen, and lines found: one false, one found twice."""
    world = World(walls=[[(2, 0), (2, 3)], [(2, 3), (0, 3)], [(2, -1), (1, -1)]])
    surface = [0] * 5 + [1] * 4 + [-1] * 3
    seen = Observation(scan=SCAN, world=world, pose=lf.Pose2D(0, 0, 0), surface=surface)
    segments = segments_of(
        # The wall y = 3, a false line, the wall x = 2 with a normal just below pi, and again.
        [math.pi / 2 + 0.002, 0.5, math.pi - 0.001, 0.0],
        [2.98, 4.0, -2.01, 2.0],
        [
            (0, 0, 1, range(5, 9), 0.0),
            (1, 0, 1, (9, 10, 11), 0.0),
            (2, 0, 1, range(3), 0.0),
            (3, 0, 1, (3, 4), 0.0),
        ],
    )
    return truth_of(seen), segments


def test_lines_by_hand():
    truth, segments = scene()
    scored = score(found([], segments=segments), truth)
    assert (scored.lines_true, scored.lines_extracted, scored.lines_matched) == (2, 4, 2)
    assert scored.duplicates == 1
    np.testing.assert_allclose(scored.angle_errors, [0.002, -0.001], atol=1e-12)
    np.testing.assert_allclose(scored.distance_errors, [-0.02, -0.01], atol=1e-12)
    np.testing.assert_allclose(scored.line_nees, [(4e-6 + 4e-4) / 1e-6, (1e-6 + 1e-4) / 1e-6])


def test_where_only_corners_are_known_no_line_is_scored():
    _, segments = scene()
    scored = score(found([(2, 3.01)], segments=segments, lines=[(0, 1)]), corners_alone([(2, 3)]))
    assert scored.lines_true == scored.lines_extracted == scored.lines_matched == 0
    assert scored.duplicates == scored.line_nees.size == scored.angle_errors.size == 0
    np.testing.assert_allclose(scored.corner_nees, [1.0])  # by the match: 1 cm, sigma 1 cm


def test_where_no_line_is_true_lines_found_are_false():
    world = World(poles=[(2, 0, 0.5)])
    seen = Observation(scan=SCAN, world=world, pose=lf.Pose2D(0, 0, 0), surface=[0] * 12)
    _, segments = scene()
    scored = score(found([(1, 1)], segments=segments, lines=[(0, 1)]), truth_of(seen))
    assert (scored.lines_true, scored.lines_extracted, scored.lines_matched) == (0, 4, 0)
    assert (scored.line_precision, scored.fp_percent, scored.corner_nees.size) == (0, 100, 0)


def test_a_detector_without_lines_misses_them():
    truth, _ = scene()
    scored = score(found([(2, 3)]), truth)
    assert (scored.lines_true, scored.lines_extracted, scored.line_recall) == (2, 0, 0)
    assert math.isnan(scored.line_precision)


def test_the_oracle_without_noise_scores_full_marks_and_a_real_extractor_nearly():
    world, poses = hallway()
    full, nearly = [], []
    for pose in poses:
        exact = Scanner(range_sigma=0.0).observe(world, pose, np.random.default_rng(0))
        full.append(score(oracle(exact.scan, truth_of(exact)), truth_of(exact)))
        noisy = Scanner(beams=361).observe(world, pose, np.random.default_rng(0))
        extract = lf.get_extractor("direct_hough", range_sigma=0.005)
        nearly.append(score(extract(noisy.scan), truth_of(noisy)))
    best, good = Score.total(full), Score.total(nearly)
    assert (best.f1, best.line_recall, best.line_precision) == (1, 1, 1)
    assert best.rms_error < 1e-6
    assert (best.scans, best.blind_scans, best.duplicates) == (8, 0, 0)
    assert 0.85 < good.f1 <= 1
    assert 0.85 < good.line_recall <= 1
    assert 0.9 < good.line_precision <= 1
    assert 0 < good.median_error < 0.02
