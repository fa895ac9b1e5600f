"""Whether stated covariances are those of the errors: NEES, and the 95 % ellipse."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures import Features, LaserScan, Lines, LineSegments, PointFeatures
from laserfeatures.evaluation import Score, Truth, score
from laserfeatures.evaluation.true_lines import normalised

seeds = st.integers(0, 10**6).map(np.random.default_rng)
SCAN = LaserScan.uniform(np.ones(8), -1.0, 0.1)


def corners(positions, covariance, lines=None):
    n = len(positions)
    return PointFeatures(
        positions=positions,
        covariance=covariance,
        lines=np.full((n, 2), -1) if lines is None else lines,
        angles=np.ones(n),
        real=np.ones(n, bool),
    )


def points_found(positions, covariance):
    return Features(
        scan=SCAN, segments=LineSegments.none(len(SCAN)), corners=corners(positions, covariance)
    )


def lines_found(theta, d, covariance, *, corners):
    """Return features with lines of which each has four beams of its own."""
    n = len(theta)
    segments = LineSegments(
        lines=Lines(theta=theta, d=d, support=np.full(n, 4.0), covariance=covariance),
        line=np.arange(n),
        endpoints=np.zeros((n, 2, 2)),
        support=np.full(n, 4.0),
        rms=np.zeros(n),
        points=np.repeat(np.eye(n, dtype=bool), 4, axis=1),
    )
    scan = LaserScan.uniform(np.ones(4 * n), -1.0, 1e-3)
    return Features(scan=scan, segments=segments, corners=corners)


def true_lines(theta, d, positions=(), pairs=()):
    """Return the truth of lines of which each has four beams of its own."""
    positions = np.reshape(positions, (-1, 2))
    return Truth(
        theta=theta,
        d=d,
        line=np.repeat(np.arange(len(theta)), 4),
        corners=positions,
        pairs=np.reshape(pairs, (-1, 2)),
        real=np.ones(len(positions), bool),
    )


NO_CORNERS = corners(np.empty((0, 2)), np.empty((0, 2, 2)))


def some_covariances(rng, count):
    """Return covariances of all shapes and directions, from 1 mm to 10 cm."""
    roots = (
        10 ** rng.uniform(-3, -1, (count, 1, 2)) * np.linalg.qr(rng.normal(size=(count, 2, 2)))[0]
    )
    return roots @ roots.transpose(0, 2, 1)


def draw(rng, covariance):
    return (np.linalg.cholesky(covariance) @ rng.normal(size=(len(covariance), 2, 1)))[..., 0]


def point_scores(rng, stated):
    """Return the score of 3000 corners without lines, told `stated` times their covariance."""

    def one():
        true = 10.0 * np.stack(np.meshgrid(np.arange(20), np.arange(15)), axis=-1).reshape(-1, 2)
        covariance = some_covariances(rng, len(true))
        features = points_found(true + draw(rng, covariance), stated * covariance)
        return score(features, Truth.of_corners(SCAN, true, np.ones(len(true), bool)), gate=4.0)

    return Score.total(one() for _ in range(10))


def line_scores(rng, stated):
    """Return the score of 3000 lines, many near the wrap; `stated` as above."""
    n = 3000
    theta, d = normalised(rng.uniform(-0.2, 0.2, n), rng.uniform(-5, 5, n))
    covariance = some_covariances(rng, n)
    # Drawn about the line found, whose theta and d the covariance is of.
    error = draw(rng, covariance)
    true = true_lines(*normalised(theta - error[:, 0], d - error[:, 1]))
    assert (abs(true.theta - theta) > 3).sum() > 50  # across the wrap
    rows = np.array_split(np.arange(n), 10)
    return Score.total(
        score(
            lines_found(theta[k], d[k], stated * covariance[k], corners=NO_CORNERS),
            true_lines(true.theta[k], true.d[k]),
        )
        for k in rows
    )


@pytest.mark.parametrize(
    ("stated", "inside"),
    # The share of a 2D Gaussian within a squared distance x is 1 - exp(-x / 2).
    [(1.0, 0.95), (0.25, 1 - 0.05**0.25), (4.0, 1 - 0.05**4)],
)
@pytest.mark.parametrize("scores", [point_scores, line_scores])
def test_as_many_errors_are_inside_the_ellipse_as_its_covariance_says(scores, stated, inside):
    total = scores(np.random.default_rng(7), stated)
    of_points = scores is point_scores
    nees = total.corner_nees if of_points else total.line_nees
    share = total.corner_consistency if of_points else total.line_consistency
    assert nees.size == 3000
    assert abs(share - inside) < 3 * math.sqrt(inside * (1 - inside) / 3000)
    assert nees.mean() == pytest.approx(2 / stated, rel=0.08)  # chi^2 with two degrees of freedom


@given(seeds)
def test_nees_is_that_of_the_inverse(rng):
    covariance, true = some_covariances(rng, 4), 10.0 * np.arange(8).reshape(4, 2)
    error = rng.normal(0, 0.1, (4, 2))
    truth = Truth.of_corners(SCAN, true, np.ones(4, bool))
    found = score(points_found(true + error, covariance), truth, gate=5.0).corner_nees
    expected = [e @ np.linalg.inv(c) @ e for e, c in zip(error, covariance, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize(
    "covariance",
    [
        [(0, 0), (0, 0)],
        [(1, 1), (1, 1)],
        [(1, 2), (2, 1)],
        [(-1, 0), (0, -1)],  # its determinant is positive
        [(1, 0), (0, -1)],
        [(math.nan, math.nan)] * 2,
        [(1, 0), (0, math.nan)],
        [(math.inf, 0), (0, math.inf)],
        [(math.inf, 0), (0, 1)],
    ],
)
@pytest.mark.parametrize("error", [0.0, 0.1])
def test_what_is_no_covariance_counts_as_outside(covariance, error):
    truth = Truth.of_corners(SCAN, [(1, 1)], [True])
    scored = score(points_found([(1 + error, 1)], [covariance]), truth)
    assert scored.corner_nees.tolist() == [math.inf]
    assert scored.corner_consistency == 0
    lines = lines_found([1.0 + error], [2.0], [covariance], corners=NO_CORNERS)
    assert score(lines, true_lines([1.0], [2.0])).line_nees.tolist() == [math.inf]


TRUE = true_lines([0.0, math.pi / 2, 1.0], [2.0, 3.0, 9.0], [(2, 3)], [(0, 1)])


def nees_of(positions, lines, *, lines_found_too=True, truth=TRUE):
    """Return the NEES of corners of TRUE's lines, each with a standard deviation of 1 m."""
    n = len(positions)
    made = corners(np.reshape(positions, (-1, 2)), np.tile(np.eye(2), (n, 1, 1)), lines)
    features = lines_found(TRUE.theta, TRUE.d, np.tile(np.eye(2), (3, 1, 1)), corners=made)
    if not lines_found_too:
        features = Features(scan=features.scan, segments=LineSegments.none(12), corners=made)
    return score(features, truth).corner_nees.tolist()


def test_a_corner_of_lines_is_held_against_the_crossing_of_their_true_lines_however_far():
    assert nees_of([(2, 8)], [(0, 1)]) == [25]
    assert nees_of([(2, 8)], [(1, 0)]) == [25]


def test_a_corner_of_lines_that_have_no_true_corner_is_not_counted_though_it_matches_one():
    assert nees_of([(2, 3)], [(0, 2)]) == []


def test_a_corner_without_lines_is_held_against_its_match_also_beside_corners_with_lines():
    found = [(5, 3), (2.1, 3), (7, 7)]
    np.testing.assert_allclose(nees_of(found, [(0, 1), (-1, -1), (-1, -1)]), [9, 0.01])
    np.testing.assert_allclose(nees_of([(2.1, 3)], [(-1, -1)], lines_found_too=False), [0.01])


def test_a_corner_of_a_line_that_is_on_no_true_one_is_not_counted():
    unknown = Truth(
        theta=TRUE.theta,
        d=TRUE.d,
        line=[0] * 4 + [-1] * 4 + [2] * 4,
        corners=TRUE.corners,
        pairs=TRUE.pairs,
        real=TRUE.real,
    )
    assert nees_of([(2, 3)], [(0, 1)], truth=unknown) == []


def test_each_error_is_held_against_its_own_covariance():
    variances = np.array([1.0, 4.0, 25.0])
    covariance = variances[:, None, None] * np.eye(2)
    unknown = Truth(
        theta=TRUE.theta,
        d=TRUE.d,
        line=[-1] * 4 + [1] * 4 + [2] * 4,
        corners=[(50, 0), (3, 3)],
        pairs=[(0, 1), (2, 1)],
        real=[True, True],
    )
    made = corners([(50, 0), (3, 0), (3, 8)], covariance, [(0, 1), (1, 2), (2, 1)])
    scored = score(lines_found(TRUE.theta, TRUE.d + 2.0, covariance, corners=made), unknown)
    np.testing.assert_allclose(scored.line_nees, [4 / 4, 4 / 25])
    np.testing.assert_allclose(scored.corner_nees, [9 / 4, 25 / 25])
    alone = Truth.of_corners(SCAN, [(3, 3)], [True])
    points = points_found([(60, 0), (3, 3.1), (70, 0)], covariance)
    np.testing.assert_allclose(score(points, alone).corner_nees, [0.01 / 4])
