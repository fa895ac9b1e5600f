import math
from dataclasses import replace

import kernels
import kernels_proposals
import numpy as np
import pytest
import reference_candidates
import reference_splitting
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.split_and_merge import SplitAndMerge, splitting
from scenes import chain, line_errors, look, niche_scan, random_room, scan_of, wall

from laserfeatures import LaserScan

SIGMA = 0.005
RULES = (splitting.LEAST, splitting.FLAT, splitting.DOUBT)
seeds = st.integers(0, 10**6).map(np.random.default_rng)


@given(seeds, st.integers(2, 30))
def test_the_farthest_of_a_piece_is_that_of_its_chord(rng, count):
    points = kernels.weighed(niche_scan(rng)[0], SIGMA)
    a = int(rng.integers(0, len(points.x) - count))
    expected = reference_splitting.farthest(points, a, a + count)
    assert kernels_proposals.farthest(points, a, a + count) == expected


@given(seeds, st.sampled_from([0.003, 0.02]))
def test_a_piece_is_split_as_its_twin_does(rng, sigma):
    points = kernels.weighed(niche_scan(rng)[0], sigma)
    start, end = np.sort(rng.choice(len(points.x), 2, replace=False))
    expected = reference_splitting.split(points, int(start), int(end), RULES)
    reference_candidates.assert_same(kernels_proposals.split(points, start, end), expected)


@given(seeds, st.sampled_from([0.003, 0.02]))
def test_lines_are_proposed_as_the_twin_does(rng, sigma):
    points = kernels.weighed(niche_scan(rng)[0], sigma)
    expected = reference_splitting.propose(points, RULES)
    reference_candidates.assert_same(kernels_proposals.pieces(points), expected)


def test_pieces_that_share_all_their_ends_fit_in_the_table():
    # An arc so bent that each piece has three returns, the fewest there may be.
    radius, off, count = 5.0, math.sqrt(3) * SIGMA, 65
    scan = LaserScan.uniform([radius] * count, 0.0, math.sqrt(2 * off / radius))
    found = kernels_proposals.pieces(kernels.weighed(scan, SIGMA))
    np.testing.assert_array_equal(found[:, 3], np.arange(0, 64, 2))
    np.testing.assert_array_equal(found[:, 4], np.arange(3, 67, 2))


def test_a_full_turn_that_ends_in_the_point_where_it_began_is_split():
    # The first beam comes again as the last one: the chord of both has no direction.
    square = chain((2, 0), (2, 2), (-2, 2), (-2, -2), (2, -2), (2, 0))
    scan = scan_of(*square, view=2 * math.pi, beams=721)
    points = kernels.weighed(LaserScan(angles=scan.angles - 1e-9, ranges=scan.ranges), SIGMA)
    at = points._replace(x=np.append(points.x, points.x[0]), y=np.append(points.y, points.y[0]))
    n = len(points.x)
    assert kernels_proposals.farthest(at, 0, n) == n // 2
    assert len(SplitAndMerge()(scan).lines) == 4


def test_each_point_of_a_clean_room_is_on_one_wall():
    # But for those that err by more than three standard deviations. Where a piece is split, the
    # points of both walls at the corner too.
    lost = beside = total = 0
    for seed in range(20):
        world, pose = random_room(np.random.default_rng(seed))
        walls = list(world.walls[:5])  # without the pillar
        scan, hit = look(walls, sigma=0.003, seed=seed, beams=361, view=5.0, pose=pose)
        found = SplitAndMerge()(scan).points.sum(axis=0)
        beams = np.bincount(hit[scan.beams], minlength=5)
        assert (beams[beams > 0] >= 4).all()
        assert found.max() == 1
        corner = np.flatnonzero(np.diff(hit))
        missed = np.flatnonzero(scan.valid & (found == 0))
        lost += missed.size
        beside += (abs(missed[:, None] - corner) <= 1).sum()
        total += scan.valid.sum()
    assert lost < 0.003 * total
    assert beside <= 1


def test_lines_are_measured_alike_at_the_wrap_of_theta_and_elsewhere():
    # The pieces beside a door, one a hair below theta = pi and one a hair above 0, are one line.
    for seed in range(20):
        walls = [wall(0.0, 2.0, -1.5, -0.4), wall(0.0, 2.0, 0.4, 1.5)]
        plain = scan_of(*walls, sigma=SIGMA, seed=seed)
        found = SplitAndMerge()(plain)
        assert found.line.tolist() == [0, 0]
        turned = LaserScan(angles=plain.angles + 0.4, ranges=plain.ranges)
        error = line_errors(
            (found.lines.theta[0] + 0.4, found.lines.d[0]),
            (SplitAndMerge()(turned).lines.theta[0], SplitAndMerge()(turned).lines.d[0]),
        )
        np.testing.assert_allclose(error, 0, atol=1e-9)


@pytest.mark.parametrize("behind", [0.3, -0.3, 1.5])
def test_walls_one_behind_the_other_are_separated(behind):
    scan, hit = look(
        [[(2, -1.5), (2, 0)], [(2 + behind, 0), (2 + behind, 1.5)]], sigma=SIGMA, beams=181
    )
    found = SplitAndMerge()(scan)
    assert len(found) == 2
    for k in range(2):
        np.testing.assert_array_equal(found.points[k], hit == k)


@pytest.mark.parametrize("reach", [5.0, 12.0])
def test_a_wall_stays_whole_where_the_beams_graze_it(reach):
    # The last steps are wider than max_gap, and than a step between two surfaces elsewhere.
    scan = scan_of([(0.2, 1.0), (reach, 1.0)], sigma=SIGMA, beams=181)
    found = SplitAndMerge()(scan)
    assert len(found) == 1
    assert found.support[0] == len(scan.points)
    assert np.linalg.norm(np.diff(scan.points[:2], axis=0)) > 0.3


@pytest.mark.parametrize("off", [-1.5, -0.3, -0.05, 0.05, 0.3, 3.0])
@pytest.mark.parametrize("spikes", [[90], [60, 90, 120], [88, 90]])
def test_lone_spikes_do_not_split_a_wall(off, spikes):
    clean = scan_of(wall(0.1, 2.0, -1.5, 1.5), sigma=0.003, beams=181)
    ranges = clean.ranges.copy()
    ranges[spikes] += off
    found = SplitAndMerge()(replace(clean, ranges=ranges))
    on_wall = clean.valid.copy()
    on_wall[spikes] = False
    assert len(found) == 1
    np.testing.assert_array_equal(found.points[0], on_wall)


def test_a_step_of_two_points_is_no_spike():
    scan = scan_of(*chain((2, -1.5), (2, 0), (2.1, 0), (2.1, 1.5)), sigma=0.002, beams=181)
    assert len(SplitAndMerge()(scan)) == 2


def test_a_wall_of_fewer_than_min_points_is_not_found():
    scan = scan_of(wall(0.0, 2.0, -0.2, 0.2))
    count = len(scan.points)
    assert len(SplitAndMerge(min_points=count)(scan)) == 1
    assert len(SplitAndMerge(min_points=count + 1)(scan)) == 0


def test_noise_that_is_given_scales_the_covariances():
    scan = scan_of(wall(0.3, 2.0, -1, 1), sigma=SIGMA)
    one, two = (SplitAndMerge(range_sigma=s)(scan).lines.covariance for s in (0.006, 0.012))
    np.testing.assert_allclose(two, 4 * one, rtol=1e-3)  # d errs to second order, too
