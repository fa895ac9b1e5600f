"""Errors by evo, held against plain NumPy."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

from laserfeatures.mapping.measures import align, alignment, errors
from laserfeatures.mapping.trajectory import Trajectory


def trajectory(poses):
    poses = np.asarray(poses, dtype=float)
    return Trajectory(stamps=np.arange(len(poses)), poses=poses)


def moved(poses, x, y, theta):
    c, s = math.cos(theta), math.sin(theta)
    turned = poses[:, :2] @ np.array([[c, s], [-s, c]]) + (x, y)
    return np.column_stack([turned, poses[:, 2] + theta])


@pytest.fixture
def pair():
    """Return a reference of steps of 0.3 m, and what a drifting, shaking robot makes of it."""
    rng = np.random.default_rng(7)
    headings = np.cumsum(rng.normal(0.05, 0.2, 60))
    steps = 0.3 * np.column_stack([np.cos(headings), np.sin(headings)])
    reference = np.column_stack([np.cumsum(steps, axis=0), headings])
    noise = np.cumsum(rng.normal(0, 0.02, reference.shape), axis=0)
    return moved(reference + noise, 500, -20, 2.0), reference


def wrapped(angles):
    return np.angle(np.exp(1j * angles))


def steps(poses, first, last):
    """Return the steps (K, 3) between pairs of poses, each in the frame of its first."""
    d = poses[last] - poses[first]
    c, s = np.cos(poses[first, 2]), np.sin(poses[first, 2])
    return np.column_stack(
        [c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], wrapped(d[:, 2])]
    )


def relative(estimate, reference, first, last):
    a, b = steps(estimate, first, last), steps(reference, first, last)
    turn = wrapped(a[:, 2] - b[:, 2])
    return np.sqrt(((a - b)[:, :2] ** 2).sum(axis=1).mean()), np.sqrt((turn**2).mean())


def test_the_absolute_error_is_the_least_that_turning_and_shifting_leaves(pair):
    estimate, reference = pair

    def distances(change):
        return np.hypot(*(moved(estimate, *change) - reference)[:, :2].T)

    # from the true change on, the least squares solution by search
    c, s = math.cos(-2), math.sin(-2)
    back = [-(c * 500 + s * 20), -(s * 500 - c * 20), -2]
    best = minimize(
        lambda change: (distances(change) ** 2).sum(),
        back,
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-14, "maxiter": 20_000, "maxfev": 20_000},
    ).x
    found = errors(trajectory(estimate), trajectory(reference))
    expected = distances(best)
    assert found.ate_rmse == pytest.approx(np.sqrt((expected**2).mean()), rel=1e-4)
    assert found.ate_median == pytest.approx(np.median(expected), rel=1e-2)
    assert found.ate_max == pytest.approx(expected.max(), rel=1e-2)


def test_the_relative_error_from_scan_to_scan_and_a_metre(pair):
    estimate, reference = pair
    estimate[:, :2] *= 1.2  # whose metre it is makes a difference
    found = errors(trajectory(estimate), trajectory(reference))
    first = np.arange(len(reference) - 1)
    expected = relative(estimate, reference, first, first + 1)
    assert (found.rpe_scan_translation, found.rpe_scan_rotation) == pytest.approx(expected)
    ends = np.arange(0, len(reference), 4)  # 0.3 m a step: 1 m is full after four of them
    expected = relative(estimate, reference, ends[:-1], ends[1:])
    assert (found.rpe_translation, found.rpe_rotation) == pytest.approx(expected)


def test_a_turned_and_shifted_copy_is_without_error(pair):
    _, reference = pair
    found = errors(trajectory(moved(reference, -3, 9, 3.0)), trajectory(reference))
    assert max(vars(found).values()) < 1e-6


def test_a_mirrored_copy_is_not(pair):
    """In space a half turn about an axis of the plane would make it fit."""
    _, reference = pair
    mirrored = trajectory(reference * [1, -1, -1])
    found = errors(mirrored, trajectory(reference))
    assert found.ate_rmse > 1
    turn, _ = alignment(mirrored, trajectory(reference))
    assert np.linalg.det(turn) == pytest.approx(1)


def test_a_straight_way_is_aligned():
    line = np.column_stack([np.arange(9.0), np.zeros(9), np.zeros(9)])
    found = align(trajectory(line), trajectory(moved(line, 1, 2, 0.5)))
    np.testing.assert_allclose(found.poses, moved(line, 1, 2, 0.5), atol=1e-12)


def test_without_headings_there_is_no_error_of_turning(pair):
    estimate, reference = pair
    blind = reference.copy()
    blind[:, 2] = math.nan
    found = errors(trajectory(estimate), trajectory(blind))
    assert found.ate_rmse == errors(trajectory(estimate), trajectory(reference)).ate_rmse
    assert found.rpe_rotation is found.rpe_scan_rotation is None
    lengths = [np.hypot(*np.diff(p[:, :2], axis=0).T) for p in pair]
    expected = np.sqrt(((lengths[0] - lengths[1]) ** 2).mean())
    assert found.rpe_scan_translation == pytest.approx(expected)


def test_a_way_shorter_than_a_metre_has_no_error_over_one(pair):
    estimate, reference = pair
    found = errors(trajectory(estimate[:3]), trajectory(reference[:3]))
    assert found.rpe_translation is found.rpe_rotation is None
    assert found.rpe_scan_translation > 0


@pytest.mark.parametrize(
    ("estimate", "reference", "complaint"),
    [
        (np.eye(3)[:2], np.eye(3)[:2], "expected at least 3 matched poses, got 2"),
        (np.empty((0, 3)), np.empty((0, 3)), "expected at least 3 matched poses, got 0"),
        (np.eye(3), np.eye(3)[:2], "expected poses in pairs, got 3 and 2"),
        (np.ones((4, 3)), np.eye(4, 3), "a trajectory that moves, got 4 times the same place"),
        (np.eye(4, 3), np.ones((4, 3)), "a reference that moves"),
        (np.full((3, 3), math.inf), np.eye(3), "a trajectory of finite positions"),
    ],
)
def test_what_cannot_be_compared_is_named(estimate, reference, complaint):
    with pytest.raises(ValueError, match=complaint):
        errors(trajectory(estimate), trajectory(reference))
