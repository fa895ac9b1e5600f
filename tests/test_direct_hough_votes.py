import math
import re

import kernels
import kernels_proposals
import numpy as np
import pytest
import reference_candidates
import reference_hough
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.direct_hough import DirectHough, accumulator, search, voting
from scenes import chain, niche_scan, scan_of, wall

from laserfeatures import LaserScan, get_extractor

ROWS = 90
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def vote(points, live, chord, tolerance, partners, *, votes=None, base=0):
    """Run `vote_pairs` at 2 degrees and 5 cm; return each row's most votes and a voter's number."""
    theta = np.arange(ROWS) * math.pi / ROWS
    if votes is None:
        votes = np.zeros((ROWS, voting.ROW), np.int32)
    return kernels.vote_pairs(points, live, theta, 0.05, chord, tolerance, partners, votes, base)


def random_walk(rng, count):
    """Return points of a few walls and some strays, in beam order."""
    corners = rng.uniform(-4, 4, (4, 2))
    share = np.linspace(0, 2.999, count)
    k = share.astype(int)
    points = corners[k] + (share - k)[:, None] * (corners[k + 1] - corners[k])
    points += rng.normal(0, 0.01, points.shape)
    stray = rng.random(count) < 0.1
    points[stray] += rng.uniform(-1, 1, (stray.sum(), 2))
    return points


@given(
    seeds, st.integers(0, 60), st.sampled_from([0.05, 0.15, 0.6]), st.sampled_from([0.01, 0.05]),
    st.integers(1, 2),
)  # fmt: skip
def test_pairs_vote_as_often_as_their_twin_says(rng, count, chord, tolerance, partners):
    points = random_walk(rng, count)
    live = np.flatnonzero(rng.random(count) < 0.9)
    rules = (voting.THINNING, voting.ORIGIN, voting.BINS)
    most, voter = vote(points, live, chord, tolerance, partners)
    low, high = (
        reference_hough.pair_votes(
            points, live, ROWS, 0.05, chord, tolerance, partners, rules, slack
        )
        for slack in (-0.1, 0.1)
    )
    assert (low <= most).all()
    assert (most <= high).all()
    assert np.isin(voter[most > 0], live).all()


def row_of_points():
    """Return 21 points on a wall at 40 degrees, 30 cm apart: none too near to another to vote."""
    first, last = wall(math.radians(40), 2.0, -3.0, 3.0)
    return np.linspace(first, last, 21)


def test_a_wall_gets_one_vote_of_each_pair_at_its_own_theta():
    most, voter = vote(row_of_points(), np.arange(21), 0.25, 0.01, 1)
    assert most.argmax() == 20
    assert most.max() == 20  # each point but the last has a partner
    assert 0 <= voter[20] < 20
    assert most[:18].max() == most[23:].max() == 0


def test_points_that_may_not_vote_do_not():
    most, _ = vote(row_of_points(), np.arange(0), 0.25, 0.01, 1)
    assert not most.any()
    most, voter = vote(row_of_points(), np.arange(10, 21), 0.25, 0.01, 1)
    assert most.max() == 10
    assert voter[most > 0].min() >= 10


def test_of_points_much_nearer_than_the_chord_one_votes_for_all():
    twice = np.repeat(row_of_points(), 2, axis=0)
    most, _ = vote(twice, np.arange(42), 0.25, 0.01, 1)
    assert most.max() == 20


def test_votes_at_or_below_the_base_count_as_none():
    points = random_walk(np.random.default_rng(3), 50)
    fresh = vote(points, np.arange(50), 0.3, 0.02, 2)
    used = np.random.default_rng(4).integers(0, 1001, (ROWS, voting.ROW)).astype(np.int32)
    again = vote(points, np.arange(50), 0.3, 0.02, 2, votes=used, base=1000)
    np.testing.assert_array_equal(again, fresh)


def test_every_vote_before_a_fresh_epoch_is_at_or_below_its_base():
    votes = np.zeros((ROWS, voting.ROW), np.int32)
    epoch = np.zeros(1, np.int64)
    points = random_walk(np.random.default_rng(5), 50)
    for _ in range(5):
        base = kernels.fresh_epoch(votes, epoch, 50)
        assert votes.max() <= base
        vote(points, np.arange(50), 0.3, 0.02, 2, votes=votes, base=base)
    assert votes.max() > base


def test_the_accumulator_is_cleared_before_its_counts_overflow():
    votes = np.full((ROWS, voting.ROW), 2**31 - 5, np.int32)
    epoch = np.array([2**31 - 5])
    base = kernels.fresh_epoch(votes, epoch, 50)
    assert not votes.any()
    assert base == 0
    assert epoch[0] >= 100  # two votes of each of 50 voters may come


@pytest.mark.parametrize("count", [2**31 - 800, 2**31 - 3])
def test_an_accumulator_about_to_overflow_finds_the_same(count):
    scan = scan_of(*chain((3, -2), (3, 1), (-0.5, 1.2)), sigma=0.005)
    detector = DirectHough()
    first = detector(scan)
    epoch = next(a for a in detector._accumulator if isinstance(a, np.ndarray) and a.size == 1)
    epoch[0] = count
    again = detector(scan)
    np.testing.assert_array_equal(again.lines.theta, first.lines.theta)
    assert epoch[0] < 2**31 - 1


@given(st.floats(-math.pi, math.pi))
def test_direction_of_a_normal_is_good_to_a_milliradian(angle):
    off = kernels.direction(math.cos(angle), math.sin(angle)) - angle
    assert abs((off + math.pi / 2) % math.pi - math.pi / 2) < 1e-3


@given(st.lists(st.integers(0, 9), min_size=8, max_size=40), seeds)
def test_peaks_come_by_falling_votes_without_their_flanks(counts, rng):
    # The kernel's keys differ in their low half, the voter.
    best = (np.array(counts) << 32) + rng.permutation(len(counts))
    found = kernels.peaks(best, 3)
    assert found == reference_hough.peak_rows(best.tolist(), 3, voting.FLANK)


@given(seeds, st.sampled_from([0.05, 0.15]), st.integers(0, 4), st.sampled_from([0.003, 0.02]))
def test_lines_are_proposed_as_the_twin_does(rng, chord, max_missed, sigma):
    points = kernels.weighed(niche_scan(rng)[0], sigma)

    def votes(at, live, tolerance, partners):
        most, voter = vote(at, live, chord, tolerance, partners)
        return most << 32 | voter

    rules = (search.LEAST, search.PARTNERS, search.MIN_VOTES, voting.FLANK)
    expected = reference_hough.propose(points, ROWS, 0.05, max_missed, votes, rules)
    found = kernels_proposals.voted(points, ROWS, 0.05, chord, max_missed, row=voting.ROW)
    reference_candidates.assert_same(found, expected)


@given(
    st.lists(st.floats(0.1, 5) | st.just(math.nan), max_size=12),
    st.sampled_from([0.1, 0.37]),
    st.sampled_from([0.05, 0.21]),
)
def test_accumulator_counts_each_point_once_for_each_theta(ranges, theta_step, distance_step):
    scan = LaserScan.uniform(ranges, -2.0, 0.31)
    plane = accumulator.accumulate(scan, theta_step, distance_step)
    assert (plane.votes.sum(axis=1) == len(scan.points)).all()
    expected = reference_hough.votes(scan.points, plane.theta, plane.d)
    np.testing.assert_array_equal(plane.votes, expected)


def test_accumulator_axes_are_evenly_spaced_and_d_is_symmetric():
    plane = accumulator.accumulate(LaserScan(angles=[0.0], ranges=[2.0]), 0.1, 0.05)
    assert plane.theta[0] == 0
    np.testing.assert_allclose(np.diff(plane.theta), math.pi / 31)
    np.testing.assert_allclose(np.diff(plane.d), 0.05)
    np.testing.assert_array_equal(plane.d, -plane.d[::-1])
    assert plane.d[-1] >= 2.0


def test_an_accumulator_too_large_for_memory_is_refused_with_a_hint():
    scan = LaserScan(angles=[0.0], ranges=[2e6])
    with pytest.raises(ValueError, match=r"too large for returns at 2e\+06 m: are the ranges metr"):
        DirectHough().accumulator(scan)


@pytest.mark.parametrize("far", [1e155, 1e200, 1e308])
def test_ranges_that_overflow_are_refused_by_their_number(far):
    scan = LaserScan(angles=[0.0, 0.1], ranges=[far, 2.0])
    with pytest.raises(ValueError, match=re.escape(f"too large for returns at {far:.6g} m")):
        get_extractor("direct_hough", preset="paper")(scan)


def test_the_accumulator_of_no_points_is_empty():
    plane = DirectHough().accumulator(LaserScan(angles=[], ranges=[]))
    assert plane.votes.shape == (180, plane.d.size)
    assert not plane.votes.any()
