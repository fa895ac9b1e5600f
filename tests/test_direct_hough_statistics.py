"""How well direct_hough measures: seeded noise, known truth."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import (
    TURN,
    chain,
    found_lines,
    line_errors,
    look,
    nearest_line,
    needs_compiler,
    random_room,
    scan_of,
    true_lines,
    wall,
)

from laserfeatures import get_extractor

SIGMA = 0.005
CHI2_95 = 5.991  # of two degrees of freedom
DRAWS = 2000  # the variance of that many errors is known to 3 %

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def extract():
    return get_extractor("direct_hough", range_sigma=SIGMA)


def error_of(features, k, truth):
    """Return the error of line k and its covariance; across theta = 0, d changes sign in both."""
    line = found_lines(features)[k]
    flip = np.diag([1, -1 if abs(line[0] - truth[0]) > 1 else 1])
    return line_errors(line, truth), flip @ features.lines.covariance[k] @ flip


def mahalanobis(errors, covariance):
    return np.einsum("ni,nij,nj->n", errors, np.linalg.inv(covariance), errors)


@pytest.fixture(scope="module")
def rooms(extract):
    """Return what was found in 150 rooms: (world, pose, true lines, beams on each, features)."""
    rng = np.random.default_rng(0)
    found = []
    for seed in range(150):
        world, pose = random_room(rng)
        view = {"beams": 720, "view": TURN * 719 / 720}
        scan, hit = look(world, sigma=SIGMA, seed=seed, pose=pose, **view)
        truth = true_lines(world, pose)
        beams = np.bincount(hit[hit >= 0], minlength=len(truth))
        found.append((world, pose, truth, beams, extract(scan)))
    return found


def matches(rooms):
    """Yield (features, index of the line found or None, true line) for each wall of ten beams."""
    for _, _, truth, beams, features in rooms:
        for k in np.flatnonzero(beams >= 10):
            near = nearest_line(found_lines(features), truth[k], math.radians(2), 0.04)
            yield features, near[0] if len(near) == 1 else None, truth[k]


def test_walls_are_found(rooms):
    # Measured: 99.9 % of the walls that ten beams hit.
    found = [k is not None for _, k, _ in matches(rooms)]
    assert len(found) > 900
    assert np.mean(found) > 0.98


def test_what_is_found_is_a_wall(rooms):
    # Measured: 99.5 % of the lines.
    right = [
        len(nearest_line(truth, line, math.radians(2), 0.04)) > 0
        for _, _, truth, _, features in rooms
        for line in found_lines(features)
    ]
    assert np.mean(right) > 0.98


def test_walls_are_found_among_false_returns(extract):
    # Measured: 98.1 % of the walls, and 97.5 % of what is found is a wall.
    rng = np.random.default_rng(0)
    found, right = [], []
    for seed in range(100):
        world, pose = random_room(rng)
        view = {"beams": 360, "view": TURN * 359 / 360}
        scan, hit = look(world, sigma=SIGMA, seed=seed, pose=pose, **view)
        false = rng.random(360) < 0.3
        ranges = np.where(false, rng.uniform(0.3, 8.0, 360), scan.ranges)
        lines = found_lines(extract(replace(scan, ranges=ranges)))
        truth = true_lines(world, pose)
        beams = np.bincount(hit[(hit >= 0) & ~false], minlength=len(truth))
        near = [nearest_line(lines, line, math.radians(2), 0.04) for line in truth]
        found += [len(near[k]) > 0 for k in np.flatnonzero(beams >= 10)]
        right += [k in np.concatenate(near) for k in range(len(lines))]
    assert np.mean(found) > 0.965
    assert np.mean(right) > 0.96


def test_walls_are_measured_to_hundredths_of_a_degree_and_half_millimetres(rooms):
    # Measured: medians of 0.018 degrees and 0.46 mm.
    errors = np.array([
        abs(line_errors(found_lines(f)[k], t)) for f, k, t in matches(rooms) if k is not None
    ])  # fmt: skip
    assert math.degrees(np.median(errors[:, 0])) < 0.03
    assert np.median(errors[:, 1]) < 0.0007


def test_covariances_of_walls_tell_their_errors(rooms):
    # Measured: 96.3 % of the errors are within the ellipse that should hold 95 %.
    pairs = [error_of(f, k, t) for f, k, t in matches(rooms) if k is not None]
    errors, covariance = (np.array(column) for column in zip(*pairs, strict=True))
    assert 0.93 < np.mean(mahalanobis(errors, covariance) < CHI2_95) < 0.985


def test_real_corners_are_corners_of_the_room(rooms):
    # Measured: a median of 1.1 mm, 95 % within 3.7 mm.
    off = []
    for world, pose, _, _, features in rooms:
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        corners = (world.walls[:, 1] - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
        real = features.corners.positions[features.corners.real]
        off += [np.hypot(*(corners - position).T).min() for position in real]
    assert len(off) > 500
    assert np.median(off) < 0.0017
    assert np.quantile(off, 0.95) < 0.006


def assert_tells(errors, covariance):
    """Check that stated covariances are those of the errors: within 15 % in every direction."""
    stated = covariance.mean(axis=0)
    ratios = np.linalg.eigvals(np.linalg.solve(stated, np.cov(errors.T)))
    assert (ratios > 0.85).all()
    assert (ratios < 1.15).all()
    assert abs(errors.mean(axis=0) / np.sqrt(np.diag(stated))).max() < 0.15  # no bias to speak of


@pytest.mark.parametrize("theta", [0.0, 0.3, -0.9])
def test_the_covariance_of_a_wall_is_that_of_its_errors(extract, theta):
    # Measured: ratios of 0.97 to 1.03.
    walls = [wall(theta, 2.0, -1.5, 1.0)]
    truth = true_lines(walls)[0]
    errors, covariance = [], []
    for seed in range(DRAWS):
        features = extract(scan_of(*walls, sigma=SIGMA, seed=seed, beams=181))
        assert len(features.lines) == 1
        error, spread = error_of(features, 0, truth)
        errors.append(error)
        covariance.append(spread)
    assert_tells(np.array(errors), np.array(covariance))


def test_the_covariance_of_a_corner_is_that_of_its_errors(extract):
    # Measured: ratios of 0.99 and 1.11: which wall a point at the corner is on is no part of it.
    errors, covariance = [], []
    for seed in range(DRAWS):
        scan = scan_of(*chain((2, -1.5), (2, 1), (0, 1.4)), sigma=SIGMA, seed=seed)
        corners = extract(scan).corners
        assert len(corners) == 1
        errors.append(corners.positions[0] - (2, 1))
        covariance.append(corners.covariance[0])
    assert_tells(np.array(errors), np.array(covariance))
