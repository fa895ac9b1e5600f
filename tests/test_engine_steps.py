"""Walls of two faces, parted where their returns step: against NumPy."""

import kernels
import numpy as np
import pytest
import reference_engine
import reference_steps
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures import LaserScan
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.steps import LEAST, STEP_PRICE

SIGMA = 0.005
MIN_POINTS = 4
SUMS = ("w", "x", "y", "xx", "xy", "yy")

seeds = st.integers(0, 2**32 - 1)


def stepped(heights, *, seed=0, beams=60, sigma=SIGMA, d=2.0):
    """Return the returns of a wall before which the beams step by some heights, in equal parts."""
    angles = np.linspace(-0.5, 0.5, beams)
    height = np.repeat(heights, -(-beams // len(heights)))[:beams]
    ranges = (d + height) / np.cos(angles)
    ranges += np.random.default_rng(seed).normal(0, sigma, beams)
    return kernels.weighed(LaserScan(angles=angles, ranges=ranges), SIGMA)


def random_walls(seed):
    """Return returns on up to three walls with steps, a label each, and the walls fitted."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 4))
    beams = int(rng.integers(count, 60))
    angles = np.linspace(-0.8, 0.8, beams)
    label = np.sort(rng.integers(0, count, beams))
    theta, d = rng.uniform(-0.5, 0.5, count), rng.uniform(1, 4, count)
    height = np.where(rng.random(beams) < 0.1, 1, 0).cumsum() % 3 * rng.uniform(0, 0.05)
    ranges = (d[label] + height) / np.cos(angles - theta[label]) + rng.normal(0, SIGMA, beams)
    points = kernels.weighed(LaserScan(angles=angles, ranges=ranges), SIGMA)
    label[rng.random(beams) < 0.1] = STRAY
    return points, label, kernels.settled(points, label)


@given(seeds)
def test_excursions_are_the_extremes_of_cumulative_sums(seed):
    points, label, walls = random_walls(seed)
    found = kernels.excursions(points, label, walls)
    np.testing.assert_array_equal(found, reference_steps.excursions(points, label, walls))


@given(seeds)
def test_the_parts_of_a_wall_have_the_sums_of_their_returns(seed):
    points, label, walls = random_walls(seed)
    at = np.random.default_rng(seed).integers(-1, len(label), (len(walls), 2))
    found = kernels.parts_of(points, label, walls, at)
    for k, row in enumerate(found):
        weight = points.weight * reference_steps.shares(points, walls[k])
        for part, mine in zip(row, reference_steps.parts_of(label, k, at[k]), strict=True):
            x, y, w = points.x[mine], points.y[mine], weight[mine]
            expected = [sum(w * f) for f in (np.ones(len(mine)), x, y, x * x, x * y, y * y)]
            np.testing.assert_allclose([part[name] for name in SUMS], expected, rtol=1e-9)
            ends = (mine[0], mine[-1] + 1) if len(mine) else (0, 0)
            assert (part["points"], part["first"], part["last"]) == (len(mine), *ends)


@given(seeds)
def test_walls_are_parted_as_by_the_twin(seed):
    points, label, walls = random_walls(seed)
    after, found = kernels.part_at_steps(points, label, walls, MIN_POINTS)
    expected = reference_steps.part_at_steps(points, label, walls, MIN_POINTS)
    np.testing.assert_array_equal(after, expected)
    assert len(found) == max(len(walls), expected.max(initial=-1) + 1)
    for k, row in enumerate(found):
        mine = np.flatnonzero(after == k)
        assert row["points"] == len(mine)
        if k < len(walls) and len(mine) == walls[k]["points"]:
            assert row == walls[k]
            continue
        old = walls[label[mine[0]]]
        solution, _, chi2 = reference_engine.fit(
            points, mine, reference_steps.shares(points, old)[mine]
        )
        assert row["chi2"] == pytest.approx(chi2, rel=1e-6, abs=1e-3)
        np.testing.assert_allclose([row["c"], row["s"]] / row["d"], solution, rtol=1e-6, atol=1e-9)
        assert row["first"] <= mine[0]
        assert row["last"] >= mine[-1] + 1


def parted(heights, **more):
    """Return the runs (label, returns) of one wall after it was parted."""
    points = stepped(heights, **more)
    label = np.zeros(points.x.size, np.int64)
    label, found = kernels.part_at_steps(points, label, kernels.settled(points, label), MIN_POINTS)
    edges = np.flatnonzero(np.diff(label, prepend=-9, append=-9))
    for k, row in enumerate(found):
        mine = np.flatnonzero(label == k)
        assert (row["first"], row["last"]) == (mine[0], mine[-1] + 1)
    return [(int(label[i]), int(n)) for i, n in zip(edges[:-1], np.diff(edges), strict=True)]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("height", [0.03, -0.03, 0.08])
def test_two_faces_are_parted_where_they_step(height, seed):
    runs = parted([0.0, height], seed=seed)
    assert sorted(k for k, _ in runs) == [0, 1]
    assert [n for _, n in runs] == pytest.approx([30, 30], abs=1)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("height", [0.03, -0.03])
def test_a_leaf_before_a_wall_is_parted_from_both_of_its_sides(height, seed):
    runs = parted([0.0, height, 0.0], seed=seed)
    assert [k for k, _ in runs] == [0, 1, 0]
    assert [n for _, n in runs] == pytest.approx([20, 20, 20], abs=1)


def test_noise_is_seldom_a_step():
    # Measured: 22 of 400 at 60 beams, 1 of 400 at 400. The next explanation drops such parts.
    for beams, most in ((60, 10), (400, 2)):
        runs = [parted([0.0], seed=seed, beams=beams) for seed in range(100)]
        assert sum(len(each) > 1 for each in runs) <= most


def test_a_step_of_less_than_the_noise_is_none_however_sure_it_is():
    low, high = 0.5 * SIGMA, 2 * SIGMA
    beams = 600
    assert (low / SIGMA) ** 2 * beams / 4 > STEP_PRICE
    assert low**2 < LEAST * SIGMA**2 < high**2
    assert parted([0.0, low], beams=beams) == [(0, beams)]
    assert len(parted([0.0, high], beams=beams)) == 2


def test_faces_of_fewer_returns_than_a_wall_has_are_not_parted():
    for beams, runs in ((6, 1), (8, 2)):
        assert len(parted([0.0, 0.1], beams=beams)) == runs


def test_the_walls_that_are_handed_in_stay_as_they_are_where_none_is_parted():
    points = stepped([0.0])
    label = np.zeros(points.x.size, np.int64)
    before = kernels.settled(points, label)
    after, found = kernels.part_at_steps(points, label, before, MIN_POINTS)
    np.testing.assert_array_equal(after, label)
    assert found == before
