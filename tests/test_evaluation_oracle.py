"""The oracle: least squares that is told which beams belong to which wall."""

import math

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import ORIGIN, line_errors, random_room

from laserfeatures import Pose2D
from laserfeatures.evaluation import Truth, oracle, score, truth_of
from laserfeatures.simulation import Scanner, World, hallway

seeds = st.integers(0, 10**6).map(np.random.default_rng)
NOISY = Scanner(beams=361, field_of_view=2 * math.pi - 0.01, range_max=20.0, range_sigma=0.02)
EXACT = Scanner(beams=361, field_of_view=2 * math.pi - 0.01, range_max=20.0, range_sigma=0.0)


def told(world, pose, scanner, rng=0):
    """Return what the oracle finds, and what is true."""
    seen = scanner.observe(world, pose, np.random.default_rng(rng))
    truth = truth_of(seen)
    return oracle(seen.scan, truth), truth


def errors(features, truth):
    found = np.stack([features.lines.theta, features.lines.d], axis=1)
    return line_errors(found, np.stack([truth.theta, truth.d], axis=1))


@given(seeds)
def test_without_noise_the_oracle_is_exact(rng):
    features, truth = told(*random_room(rng), EXACT)
    assert truth.theta.size > 3
    assert abs(errors(features, truth)).max() < 1e-9
    assert features.corners.lines.tolist() == truth.pairs.tolist()
    found = score(features, truth)
    assert (found.tp_percent, found.fp_percent, found.line_recall) == (100, 0, 1)
    assert found.errors.max() < 1e-6  # a short wall's tiny error, carried to the farthest corner
    assert found.median_error < 1e-9


@given(seeds)
def test_with_noise_each_line_is_that_of_the_slow_twin_through_all_its_beams(rng):
    features, truth = told(*random_room(rng), NOISY, rng)
    scan, segments = features.scan, features.segments
    assert segments.line.tolist() == list(range(truth.theta.size))
    for k in range(truth.theta.size):
        beams = np.flatnonzero(truth.line == k)
        points = np.array(
            [(r * math.cos(a), r * math.sin(a)) for r, a in zip(
                scan.ranges[beams], scan.angles[beams], strict=True
            )]
        )  # fmt: skip
        theta, d, *_ = reference.fit_line(points, np.ones(len(points)), 1.0)
        found = segments.lines.theta[k], segments.lines.d[k]
        np.testing.assert_allclose(line_errors(found, (theta, d)), 0, atol=1e-9)
        normal, along = (np.array(v) for v in zip(
            (math.cos(theta), -math.sin(theta)), (math.sin(theta), math.cos(theta)), strict=True
        ))  # fmt: skip
        assert np.flatnonzero(segments.points[k]).tolist() == beams.tolist()
        assert segments.support[k] == segments.lines.support[k] == len(beams)
        assert segments.rms[k] == pytest.approx(np.sqrt(np.mean((points @ normal - d) ** 2)))
        np.testing.assert_allclose(segments.endpoints[k] @ normal, d, atol=1e-9)
        np.testing.assert_allclose(segments.endpoints[k] @ along, points[[0, -1]] @ along)


def test_no_other_unweighted_line_is_nearer_to_the_beams():
    features, truth = told(*random_room(np.random.default_rng(5)), NOISY)
    lines = features.lines
    points = features.scan.ranges[:, None] * features.scan.directions
    for k in range(truth.theta.size):
        mine = points[truth.line == k]

        def off(theta, d, mine=mine):
            return ((mine @ (math.cos(theta), math.sin(theta)) - d) ** 2).sum()

        best = off(lines.theta[k], lines.d[k])
        for turn, shift in [(1e-4, 0), (-1e-4, 0), (0, 1e-4), (0, -1e-4)]:
            assert off(lines.theta[k] + turn, lines.d[k] + shift) > best


def test_its_errors_are_those_that_theory_gives_least_squares():
    sigma, pose = 0.01, Pose2D(0.4, -0.3, 0.2)
    world = World(walls=[[(3, -2), (3, 2)]])
    scanner = Scanner(beams=121, range_sigma=sigma)
    exact = Scanner(beams=121, range_sigma=0).observe(world, pose, np.random.default_rng(0))
    truth = truth_of(exact)
    x, y = exact.scan.points.T
    c, s = math.cos(truth.theta[0]), math.sin(truth.theta[0])
    across = (x * c + y * s) / np.hypot(x, y) * sigma  # deviation off the wall: cos(incidence)
    along = y * c - x * s
    centre = along.mean()
    lever = (along - centre) / ((along - centre) ** 2).sum()
    turns = math.sqrt((lever**2 * across**2).sum())
    shifts = math.sqrt(((1 / len(x) + centre * lever) ** 2 * across**2).sum())
    rng = np.random.default_rng(1)
    found = np.array(
        [errors(oracle(scanner.scan(world, pose, rng), truth), truth)[0] for _ in range(1000)]
    )
    np.testing.assert_allclose(found.std(axis=0), (turns, shifts), rtol=0.08)
    assert (abs(found.mean(axis=0)) < (4 * turns / 31, 4 * shifts / 31)).all()


def test_all_crossings_that_count_are_given_and_none_is_withheld():
    features, truth = told(*random_room(np.random.default_rng(2)), NOISY)
    corners = features.corners
    assert len(corners) > 5
    for a, b in corners.lines:
        assert a < b
    theta = features.lines.theta
    turn = np.degrees(abs(theta[:, None] - theta))
    steep = np.minimum(turn, 180 - turn) >= 15
    near = {(a, b) for a, b in np.argwhere(np.triu(steep)) if a < b}
    assert set(map(tuple, corners.lines.tolist())) <= near
    assert np.hypot(*corners.positions.T).max() <= 20
    np.testing.assert_allclose(
        np.sin(corners.angles), abs(np.sin(np.subtract(*theta[corners.lines].T))), atol=1e-12
    )
    assert corners.angles.max() <= math.pi / 2
    assert np.isnan(corners.covariance).all()
    assert np.isnan(features.lines.covariance).all()
    found = score(features, truth)
    assert found.corner_consistency == found.line_consistency == 0


def test_beams_without_return_are_left_alone():
    # A gap straight ahead: infinite times a zero direction would be no number.
    world = World(walls=[[(1, -5), (1, -0.1)], [(1, 0.1), (1, 5)], [(1, 5), (-3, 5)]])
    features, truth = told(world, ORIGIN, Scanner(beams=181))
    assert np.isinf(features.scan.ranges[90])
    assert len(features.lines) == truth.theta.size == 2


@pytest.mark.parametrize("world", [World(), World(poles=[(2, 0, 0.5)])])
def test_of_no_true_line_nothing_is_found(world):
    features, _ = told(world, ORIGIN, Scanner())
    assert (len(features.lines), len(features.segments), len(features.corners)) == (0, 0, 0)
    assert features.segments.points.shape == (0, 181)


def test_of_corners_without_lines_nothing_is_found():
    world, poses = hallway()
    scan = Scanner().scan(world, poses[0], np.random.default_rng(0))
    features = oracle(scan, Truth.of_corners(scan, [(1, 2)], [True]))
    assert (len(features.lines), len(features.corners)) == (0, 0)


def test_one_line_has_no_corner():
    features, _ = told(World(walls=[[(2, -2), (2, 2)]]), ORIGIN, Scanner())
    assert (len(features.lines), len(features.corners)) == (1, 0)
