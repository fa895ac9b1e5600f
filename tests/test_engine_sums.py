"""Lines and circles fitted to stretches of a scan, against least squares by NumPy."""

import math

import kernels
import numpy as np
import pytest
import reference_engine
from hypothesis import given
from hypothesis import strategies as st
from scenes import poles, scan_of, wall

from laserfeatures import LaserScan
from laserfeatures.engine.sums import COLUMNS

seeds = st.integers(0, 2**32 - 1)
noises = st.tuples(st.floats(0.002, 0.05), st.floats(0, 0.02), st.floats(0, 0.02))


def rough_wall(seed, count, noise=(0.005, 0.0, 0.0)):
    """Return returns about a wall, in any direction, some of them far off."""
    rng = np.random.default_rng(seed)
    step, theta = rng.uniform(0.005, 0.05), rng.uniform(-math.pi, math.pi)
    angles = theta + rng.uniform(-1.2, 1.2 - step * count) + step * np.arange(count)
    ranges = rng.uniform(0.5, 8.0) / np.cos(angles - theta)
    ranges += rng.normal(0, 0.01, count)
    ranges[rng.random(count) < 0.1] += 0.5
    return kernels.weighed(LaserScan(angles=angles, ranges=ranges), *noise)


@given(seeds, st.integers(4, 40), noises)
def test_a_stretch_has_the_misfit_of_least_squares(seed, count, noise):
    points = rough_wall(seed, count, noise)
    rng = np.random.default_rng(seed)
    i = int(rng.integers(0, count - 3))
    j = int(rng.integers(i + 4, count + 1))
    misfit, oblique = kernels.wall_misfit(points, i, j)
    expected = reference_engine.wall_misfit(points, i, j)
    assert misfit == pytest.approx(expected[0], rel=1e-6, abs=1e-3)
    assert oblique == pytest.approx(expected[1], rel=1e-6)


@given(seeds, st.integers(4, 40), noises)
def test_sums_give_the_line_of_least_squares(seed, count, noise):
    points = rough_wall(seed, count, noise)
    total = kernels.running_sums(points)[-1]
    assert total.shape == (COLUMNS,)
    c, s, d, chi2 = kernels.line_of(*total[:6])
    solution, _, expected = reference_engine.fit(points, np.arange(count))
    assert d > 0
    np.testing.assert_allclose([c / d, s / d], solution, rtol=1e-6, atol=1e-9)
    assert math.hypot(c, s) == pytest.approx(1)
    assert chi2 == pytest.approx(expected, rel=1e-6, abs=1e-3)


def test_returns_in_line_with_the_sensor_are_no_wall():
    points = kernels.weighed(LaserScan(angles=[0.3, 0.3 + 1e-9], ranges=[1.0, 2.0]))
    assert kernels.wall_misfit(points, 0, 2)[0] == math.inf
    assert kernels.line_of(*kernels.running_sums(points)[-1][:6])[3] == math.inf


def test_chi_squared_of_a_wall_is_that_of_its_noise():
    angles = np.linspace(-0.6, 0.6, 61)
    rng = np.random.default_rng(1)
    misfits = []
    for _ in range(300):
        ranges = 3.0 / np.cos(angles) + rng.normal(0, 0.004, 61)
        points = kernels.weighed(LaserScan(angles=angles, ranges=ranges), 0.004)
        misfits.append(kernels.wall_misfit(points, 0, 61)[0])
    assert np.mean(misfits) == pytest.approx(59 / 1.02, rel=0.03)


@given(seeds, st.integers(4, 30), st.floats(0.05, 3.0))
def test_a_stretch_has_the_misfit_of_the_algebraic_circle(seed, count, radius):
    rng = np.random.default_rng(seed)
    if rng.random() < 0.3:  # from inside
        angles = np.linspace(-1, 1, count) * rng.uniform(0.5, 2)
        x, y = rng.uniform(-0.6, 0.6, 2) * radius
    else:
        x, y = rng.uniform(1.1, 4.0) * radius, 0.0
        angles = np.linspace(-0.95, 0.95, count) * math.asin(radius / x)
    along = x * np.cos(angles) + y * np.sin(angles)
    root = np.sqrt(radius**2 - (x * np.sin(angles) - y * np.cos(angles)) ** 2)
    ranges = along - root if x > radius else along + root
    ranges = np.maximum(0.01, ranges + rng.normal(0, 0.01 * radius, count))
    turn = rng.uniform(-math.pi, math.pi)
    points = kernels.weighed(LaserScan(angles=angles + turn, ranges=ranges), 0.01 * radius)
    misfit = kernels.arc_misfit(points, 0, count, 1.0)
    assert misfit == pytest.approx(reference_engine.arc_misfit(points, 0, count, 1.0), rel=1e-6)


@pytest.mark.parametrize("radius", [0.05, 0.1, 0.2, 0.35])
@pytest.mark.parametrize("seed", range(5))
def test_a_pole_is_round(radius, seed):
    points = kernels.weighed(poles((2.0, 0.3), radius=radius, beams=721, seed=seed))
    assert kernels.is_round(points)


def test_a_column_larger_than_poles_are_is_not_round():
    points = kernels.weighed(poles((3.0, 0.3), radius=0.6, beams=721))
    assert not kernels.is_round(points)
    assert kernels.is_round(points, max_radius=0.7)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("theta", np.radians([-50, 0, 40]))
def test_a_wall_is_not_round(theta, seed):
    points = kernels.weighed(scan_of(wall(theta, 2.0, -0.4, 0.5), sigma=0.005, seed=seed))
    assert not kernels.is_round(points)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    "corner",
    [
        [[(2.0, -0.5), (2.5, 0.0)], [(2.5, 0.0), (2.0, 0.5)]],
        [[(2.4, -0.4), (2.0, 0.0)], [(2.0, 0.0), (2.4, 0.4)]],
        [[(2.0, -0.8), (2.0, 0.3)], [(2.0, 0.3), (3.0, 0.5)]],
    ],
    ids=["inner", "outer", "edge"],
)
def test_a_corner_is_not_round(corner, seed):
    points = kernels.weighed(scan_of(*corner, sigma=0.005, seed=seed, beams=721))
    assert not kernels.is_round(points)


@pytest.mark.parametrize("radius", [1.0, 3.0])
def test_a_round_room_is_round_however_large(radius):
    angles = np.linspace(-1.4, 1.4, 181)
    x = 0.3 * radius
    ranges = x * np.cos(angles) + np.sqrt(radius**2 - (x * np.sin(angles)) ** 2)
    ranges += np.random.default_rng(3).normal(0, 0.005, 181)
    assert kernels.is_round(kernels.weighed(LaserScan(angles=angles, ranges=ranges)))


def test_fewer_than_four_returns_are_not_round():
    points = kernels.weighed(poles((2.0, 0.0), radius=0.1, beams=721))
    assert not kernels.is_round(points, 2, 5)
