"""The returns in the order in which they are explained: rings, jumps, lone returns."""

import math

import kernels
import numpy as np
import pytest
import reference_engine
from hypothesis import example, given
from hypothesis import strategies as st
from scenes import TURN, look, random_room

from laserfeatures import LaserScan
from laserfeatures.engine import sequence
from laserfeatures.engine.sequence import DOUBLED, OPEN, RING

seeds = st.integers(0, 2**32 - 1)
some_ranges = st.lists(
    st.sampled_from([0.0, 2.0, 2.01, math.inf, math.nan, -1.0]) | st.floats(0.1, 9),
    min_size=4,
    max_size=30,
)


def around(ranges, ring=RING, first=-math.pi):
    """Return a scan whose beams do not go round, go round, or do and repeat the first."""
    beams = len(ranges)
    step = {OPEN: 0.5 * TURN / beams, RING: TURN / beams, DOUBLED: TURN / (beams - 1)}[ring]
    scan = LaserScan.uniform(ranges, first, step, range_max=30.0)
    assert scan.ring == ring
    return scan


def room_around(seed, beams=360, sigma=0.005):
    """Return the ranges of a full turn in a room with a pillar and a cut corner."""
    world, pose = random_room(np.random.default_rng(seed))
    view = TURN * (beams - 1) / beams
    return look(world, sigma=sigma, seed=seed, beams=beams, view=view, pose=pose)[0].ranges.copy()


@given(some_ranges, st.sampled_from([OPEN, RING, DOUBLED]), st.floats(-4, 4))
@example([0.0, 0.25, 0.0, 1.5, 1.5, 0.0], DOUBLED, 0.0)  # two steps alike but for rounding
def test_the_order_of_returns_is_that_of_a_loop(ranges, ring, first):
    scan = around(ranges, ring, first)
    points = kernels.sequence.Sequence(*kernels.in_order(scan))
    chosen, beams = reference_engine.order(scan, *points.beam[:1])
    np.testing.assert_array_equal(points.beam, beams)
    expected = scan.ranges[chosen, None] * scan.directions[chosen]
    np.testing.assert_array_equal(reference_engine.xy(points), expected)
    np.testing.assert_array_equal(reference_engine.directions(points), scan.directions[chosen])


@given(some_ranges, st.tuples(st.floats(0.001, 0.3), st.floats(0, 0.05), st.floats(0, 0.05)))
def test_what_follows_from_the_noise_is_that_of_a_loop(ranges, noise):
    points = kernels.weighed(around(ranges), *noise)
    variance, weight, floor, jump = reference_engine.weigh(points, *noise)
    np.testing.assert_allclose(points.variance, variance)
    np.testing.assert_allclose(points.weight, weight)
    np.testing.assert_allclose(points.floor, floor)
    np.testing.assert_array_equal(points.jump, jump)


@given(st.lists(st.sampled_from([2.0, 2.01, 1.98, 5.0, 5.01, 0.5]), min_size=1, max_size=30))
def test_lone_returns_are_those_of_a_loop(ranges):
    points = kernels.weighed(LaserScan.uniform(ranges, -0.5, 0.02))
    stay, jump = reference_engine.without_lone(points)
    left = kernels.without_lone(points)
    np.testing.assert_array_equal(left.beam, points.beam[stay])
    np.testing.assert_array_equal(left.x, points.x[stay])
    np.testing.assert_array_equal(left.variance, points.variance[stay])
    np.testing.assert_array_equal(left.jump, jump)


@pytest.mark.parametrize("seed", range(5))
def test_a_ring_begins_at_the_same_return_whatever_the_first_beam_is(seed):
    ranges = room_around(seed)
    start = kernels.weighed(around(ranges)).beam[0]
    for turn in range(0, 360, 7):
        points = kernels.weighed(around(np.roll(ranges, turn)))
        assert points.beam[0] == (start + turn) % 360
        assert np.diff(points.beam).min() == 1
        assert points.beam[-1] == points.beam[0] + 359


def test_a_beam_that_repeats_the_first_counts_once():
    ranges = room_around(1)
    once = kernels.weighed(around(ranges))
    twice = kernels.weighed(around([*ranges, ranges[0] + 0.003], DOUBLED))
    np.testing.assert_array_equal(once.beam, twice.beam)
    np.testing.assert_allclose(once.x, twice.x, atol=1e-9)


@pytest.mark.parametrize("missing", [0, -1])
def test_a_beam_that_repeats_the_first_counts_where_the_other_has_no_return(missing):
    ranges = np.append(room_around(1), 2.0)
    ranges[missing] = math.inf
    points = kernels.weighed(around(ranges, DOUBLED))
    assert len(points.x) == 360
    assert len(set(np.mod(points.beam, 360))) == 360


def test_an_open_scan_begins_at_its_first_return():
    ranges = room_around(1)
    ranges[:3] = 0.0
    points = kernels.weighed(around(ranges, OPEN))
    np.testing.assert_array_equal(points.beam, np.arange(3, 360))


@given(seeds, st.integers(1, 359))
def test_a_turned_ring_is_the_same_begun_elsewhere(seed, start):
    points = kernels.weighed(around(room_around(seed % 10)))
    other = kernels.turned(points, start, 360)
    for name in ("x", "y", "ux", "uy", "variance", "weight", "floor"):
        expected = np.roll(getattr(points, name), -start)
        np.testing.assert_array_equal(getattr(other, name), expected)
    np.testing.assert_array_equal(other.beam, points.beam[0] + start + np.arange(360))
    np.testing.assert_array_equal(other.jump, reference_engine.weigh(other, 0.005, 0, 0)[3])


def test_a_return_alone_before_a_wall_is_left_out_and_the_wall_goes_on():
    ranges = 2.0 / np.cos(np.linspace(-0.4, 0.4, 41))
    ranges[[9, 30]] = 1.0, 4.0
    points = kernels.weighed(LaserScan.uniform(ranges, -0.4, 0.02))
    assert np.flatnonzero(points.jump).tolist() == [0, 9, 10, 30, 31]
    left = kernels.without_lone(points)
    assert set(range(41)) - set(left.beam) == {9, 30}
    assert np.flatnonzero(left.jump).tolist() == [0]


def test_the_edge_of_an_object_is_no_lone_return():
    ranges = [2.0] * 10 + [3.0] * 2 + [4.0] * 10
    points = kernels.weighed(LaserScan.uniform(ranges, -0.2, 0.02))
    assert kernels.without_lone(points).beam.tolist() == list(range(22))


@pytest.mark.parametrize("ranges", [[], [2.0], [2.0, 5.0]])
def test_few_returns_are_left_as_they_are(ranges):
    points = kernels.weighed(LaserScan.uniform(ranges, -0.2, 0.02))
    assert kernels.without_lone(points).x.size == len(ranges)


@pytest.mark.parametrize("correlation", [0.0, 0.1, 0.25, 1.0])
def test_errors_that_last_widen_long_surfaces_most(correlation):
    floors = []
    for beams in (90, 361, 2000):
        world, pose = random_room(np.random.default_rng(7))
        scan, _ = look(world, sigma=0.005, beams=beams, view=1.5 * math.pi, pose=pose)
        plain, points = (sequence.Sequence(*kernels.in_order(scan)) for _ in range(2))
        kernels.weigh(plain, 0.005, 0.0, 0.002)
        kernels.weigh(points, 0.005, 0.0, 0.002, correlation)
        starts = np.flatnonzero(points.jump)
        runs = np.diff([*starts, len(points.x)])
        share = min((runs**2).sum() / runs.sum() / sequence.LONG, 1.0) ** sequence.STRAYING
        expected = sequence.LASTING * max(correlation - sequence.LIKENESS, 0.0) * share
        np.testing.assert_allclose(points.lasting, expected)
        np.testing.assert_allclose(points.floor - plain.floor, expected, atol=1e-12)
        floors.append(expected)
    assert floors == sorted(floors)
