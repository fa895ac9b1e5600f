"""The cheapest explanation of a scan, against a search that tries every wall and object."""

import math

import kernels
import numpy as np
import pytest
import reference_engine
from hypothesis import given
from hypothesis import strategies as st
from scenes import chain, needs_compiler, poles, scan_of, wall

from laserfeatures import LaserScan
from laserfeatures.engine.partition import ARC, STRAY, Limits
from laserfeatures.engine.prices import PRICE, RETURN_PRICE

SIGMA = 0.005
LIMITS = Limits(4, 3, 0.25, 0.4, 1 << 40, False)
SHORT = LIMITS._replace(longest=12)
NO_LINES = np.empty((0, 5))
SLACK = 4.0  # that dropped starts may cost: far less than a wall

seeds = st.integers(0, 2**32 - 1)


def random_scene(seed, most=40):
    """Return few returns on some walls, a pole, and strays."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, most + 1))
    angles = np.linspace(-0.7, 0.7, count) * rng.uniform(0.3, 1.0) + rng.uniform(-3, 3)
    ranges = np.full(count, math.inf)
    for _ in range(rng.integers(1, 5)):
        theta, d = angles.mean() + rng.uniform(-1.2, 1.2), rng.uniform(1.0, 4.0)
        with np.errstate(divide="ignore"):
            hit = d / np.cos(angles - theta)
        low, high = np.sort(rng.integers(0, count + 1, 2))
        hit[:low], hit[high:] = math.inf, math.inf
        ranges = np.fmin(ranges, np.where((hit > 0) & (hit < 15), hit, math.inf))
    if rng.random() < 0.5:
        bearing, far, radius = rng.choice(angles), rng.uniform(0.7, 2), rng.uniform(0.05, 0.3)
        across = far * np.sin(angles - bearing)
        root = np.sqrt(np.maximum(radius**2 - across**2, 0))
        near = far * np.cos(angles - bearing) - root
        ranges = np.where(abs(across) < radius, np.fmin(ranges, near), ranges)
    stray = rng.random(count) < rng.choice([0.0, 0.1])
    ranges[stray] = rng.uniform(0.5, 5, stray.sum())
    ranges += rng.normal(0, SIGMA, count)
    return kernels.weighed(LaserScan(angles=angles, ranges=ranges), SIGMA)


def some_lines(points, seed):
    """Return lines through pairs of near returns, with the runs that they were found in."""
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(rng.integers(1, 5)):
        i = int(rng.integers(0, max(len(points.x) - 3, 1)))
        j = min(i + int(rng.integers(3, 15)), len(points.x))
        if j - i >= 3:
            solution, _, _ = reference_engine.fit(points, np.arange(i, j))
            d = 1 / np.hypot(*solution)
            lines.append((*(solution * d), d, i, j))
    return np.reshape(lines, (-1, 5))


def excess(points, lines, limits, price=PRICE, columns=()):
    """Return by how much an explanation costs more than the cheapest."""
    label, _ = kernels.partition(points, lines, limits, price, columns)
    cost = reference_engine.explanation_cost(points, label, lines, limits, price, columns)
    return cost - reference_engine.partition_cost(points, lines, limits, price, columns)


@given(seeds, st.sampled_from([LIMITS, SHORT, LIMITS._replace(max_pole_radius=0.0)]))
def test_no_explanation_is_cheaper(seed, limits):
    assert -1e-3 < excess(random_scene(seed), NO_LINES, limits) < SLACK


@needs_compiler
def test_most_explanations_are_the_cheapest():
    more = [excess(random_scene(seed), NO_LINES, LIMITS) for seed in range(150)]
    assert np.mean(np.array(more) < 1e-3) > 0.9


@given(seeds, st.sampled_from([PRICE, RETURN_PRICE]))
def test_no_explanation_by_lines_and_walls_is_cheaper(seed, price):
    points = random_scene(seed)
    assert -1e-3 < excess(points, some_lines(points, seed), SHORT, price) < SLACK


@given(seeds, st.sampled_from([LIMITS, LIMITS._replace(max_pole_radius=0.0)]))
def test_no_explanation_with_columns_is_cheaper(seed, limits):
    points = random_scene(seed)
    rng = np.random.default_rng(seed)
    n = len(points.x)
    if n == 0:
        return
    ends = np.unique(rng.integers(1, n + 1, 3))  # at a return one column ends at the most
    columns = [(int(rng.integers(0, end)), int(end)) for end in ends]
    first = reference_engine.objects(points)[0]  # one ends at a jump, and begins within the object
    if first[1] not in ends:
        columns.append((int(rng.integers(*first)), first[1]))
    assert -1e-3 < excess(points, NO_LINES, limits, columns=columns) < SLACK


def test_a_column_before_a_jump_does_not_hide_the_whole_object():
    points = kernels.weighed(poles((1.5, 0.3), beams=361))
    n = points.x.size
    label, _ = kernels.partition(points, NO_LINES, LIMITS, round_objects=[(n - 5, n)])
    assert (label == ARC).all()


@needs_compiler
def test_most_explanations_by_lines_are_the_cheapest():
    scenes = [random_scene(seed) for seed in range(150)]
    more = [excess(points, some_lines(points, 7 * k), SHORT) for k, points in enumerate(scenes)]
    assert np.mean(np.array(more) < 1e-3) > 0.9


def explained(scan, lines=NO_LINES, limits=LIMITS):
    """Return the label of each return as (label, number of returns) of each run."""
    label, count = kernels.partition(kernels.weighed(scan, SIGMA), lines, limits)
    assert label.max(initial=-1) < count
    edges = np.flatnonzero(np.diff(label, prepend=-9, append=-9))
    return [(int(label[i]), int(n)) for i, n in zip(edges[:-1], np.diff(edges), strict=True)]


@pytest.mark.parametrize("lines", [NO_LINES, [(1.0, 0.0, 2.0, 0, 50)]])
def test_nothing_is_explained_by_nothing(lines):
    assert explained(LaserScan(angles=[], ranges=[]), lines) == []


def test_a_wall_is_one_piece():
    scan = scan_of(wall(0.2, 2.0, -1, 1), sigma=SIGMA, beams=181)
    assert [k for k, _ in explained(scan)] == [0]


def test_a_corner_parts_two_walls():
    scan = scan_of(*chain((2, -1.5), (2, 1.2), (-0.5, 1.2)), sigma=SIGMA, beams=181)
    runs = explained(scan)
    assert sorted(k for k, _ in runs) == [0, 1]
    first = math.atan2(1.2, 2) - math.atan2(-1.5, 2)
    assert runs[0][1] == pytest.approx(math.degrees(first), abs=2)


def test_a_pole_is_round_and_what_is_alone_is_stray():
    scan = poles((1.5, 0.3), beams=361)
    ranges = scan.ranges.copy()
    first, last = scan.beams[[0, -1]]
    ranges[[first - 1, last + 1]] = 3.0
    scan = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
    assert explained(scan) == [(STRAY, 1), (ARC, last - first + 1), (STRAY, 1)]
    assert ARC not in dict(explained(scan, limits=LIMITS._replace(max_pole_radius=0.0)))


def test_poles_far_apart_are_round_each():
    scan = poles((1.5, 0.8), (1.8, -0.7), (3.0, 0.1), radius=0.15, beams=361)
    assert {k for k, _ in explained(scan)} == {ARC}


def test_three_returns_are_no_wall():
    angles = np.array([-0.02, 0.0, 0.02])
    scan = LaserScan(angles=angles, ranges=2 / np.cos(angles))
    assert explained(scan) == [(STRAY, 3)]
    assert explained(scan, limits=LIMITS._replace(min_points=3)) == [(0, 3)]


def test_an_outlier_does_not_end_a_wall_that_was_proposed():
    angles = np.linspace(-0.4, 0.4, 41)
    ranges = 2 / np.cos(angles)
    ranges[20] = 2.3
    scan = LaserScan(angles=angles, ranges=ranges)
    assert explained(scan, [(1.0, 0.0, 2.0, 0, 41)]) == [(0, 41)]
    assert [k for k, _ in explained(scan)] == [1, STRAY, 0]


def test_a_line_explains_returns_near_its_own_only():
    angles = np.linspace(-0.4, 0.4, 41)
    scan = LaserScan(angles=angles, ranges=2 / np.cos(angles))
    runs = explained(scan, [(1.0, 0.0, 2.0, 18, 22)], SHORT)
    assert [k for k, _ in runs] == [2, 0, 1]
    assert 15 < runs[1][1] <= 20


def test_walls_count_on_from_the_lines_proposed():
    angles = np.linspace(-0.4, 0.4, 41)
    scan = LaserScan(angles=angles, ranges=2 / np.cos(angles))
    points = kernels.weighed(scan, SIGMA)
    label, count = kernels.partition(points, [(0.0, 1.0, 5.0, 0, 41)] * 3, LIMITS)
    assert count == 4
    assert set(label) == {3}


def test_what_costs_a_wall_more_than_strays_is_no_wall():
    rng = np.random.default_rng(4)
    scan = LaserScan.uniform(rng.uniform(1, 8, 60), -0.6, 0.02)
    runs = explained(scan)
    assert sum(n for k, n in runs if k == STRAY) > 50
    assert PRICE > 0
