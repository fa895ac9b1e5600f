import math
from dataclasses import replace

import kernels
import numpy as np
import pytest
import reference_splitting
from hypothesis import assume, given
from hypothesis import strategies as st
from laserfeatures_plugins.split_and_merge import SplitAndMerge, splitting
from scenes import chain, line_errors, look, niche, random_room, scan_of, wall

from laserfeatures import LaserScan
from laserfeatures.geometry import growth, noise

SIGMA = 0.005
GRAZING = math.radians(10)
RULES = (splitting.SURE, splitting.TRIMMED, splitting.SPIKE)
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def link(a, b):
    return reference_splitting.linked(a, b, SIGMA, GRAZING, growth.SIGMAS)


@given(seeds, st.sampled_from([0.0, 0.002, 0.05]))
def test_points_are_linked_as_their_twin_says(rng, sigma):
    angle, turn, grazing = rng.uniform((-math.pi, 0.001, 0.05), (math.pi, 0.1, 0.4))
    seen = grazing * rng.uniform(0.6, 1.6)  # the angle at which the step is seen
    near = rng.uniform(0.1, 20)
    assume(seen > turn)
    far = near * math.sin(seen) / math.sin(seen - turn)
    if rng.random() < 0.5:
        near, far = far, near
    points = np.array([
        [near * math.cos(angle), near * math.sin(angle)],
        [far * math.cos(angle + turn), far * math.sin(angle + turn)],
    ])  # fmt: skip
    expected = reference_splitting.linked(*points, sigma, grazing, growth.SIGMAS)
    assert kernels.linked(points, 0, 1, sigma, grazing) == expected


@given(seeds, st.integers(0, 4))
def test_the_scan_breaks_into_chains_as_the_twin_says(rng, max_missed):
    points, beams, _ = niche(rng)
    free = rng.random(len(points)) < 0.9
    start = 0
    while start < len(points):
        expected = reference_splitting.next_chain(points, beams, free, start, max_missed, link)
        found = kernels.next_chain(points, beams, free, start, SIGMA, GRAZING, max_missed)
        assert found == expected
        start = found[1]


@given(seeds, st.integers(2, 30))
def test_the_farthest_of_a_piece_is_that_of_its_chord(rng, count):
    points = rng.uniform(-2, 2, (40, 2))
    places = np.sort(rng.choice(40, 30, replace=False))
    a = int(rng.integers(0, 31 - count))
    b = a + count - 1
    place, off = kernels.farthest(points, places, a, b)
    if count > 2:
        distances = reference_splitting.off_chord(points, places[a : b + 1])
        assert place == a + 1 + np.argmax(distances[1:-1])
        assert off == pytest.approx(distances.max())
    else:
        assert off <= 0  # nothing is between the ends


@given(seeds, st.integers(3, 20))
def test_spikes_are_told_as_their_twin_does(rng, count):
    along = np.sort(rng.uniform(-1, 1, count))
    points = np.stack([2.0 + rng.normal(0, 0.02, count), along], axis=1)
    m = int(rng.integers(1, count - 1))
    points[m, 0] += rng.uniform(-0.2, 0.2)
    off = reference_splitting.off_chord(points, range(count))[m]
    expected = reference_splitting.is_spike(points, range(count), m, splitting.SPIKE)
    assert kernels.is_spike(points, range(count), 0, count - 1, m, off) == expected


def assert_same_walls(owner, table, expected):
    """Check what a search found against the walls of the twin."""
    np.testing.assert_array_equal(owner, np.where(owner < -1, owner, expected[0]))
    assert len(table) == len(expected[1])
    np.testing.assert_array_equal(table[:, 5], np.bincount(owner[owner >= 0], minlength=len(table)))
    for row, (_, fit, *_) in zip(table, expected[1], strict=True):
        assert abs(line_errors(row[:2], fit[:2])).max() < 1e-9
        np.testing.assert_allclose(row[2:5:2], fit[2::2], rtol=1e-6)


@given(seeds, st.integers(3, 5))
def test_a_chain_is_split_as_its_twin_does(rng, min_points):
    points, _, _ = niche(rng)
    sharp = rng.random(len(points)) < rng.choice([0.0, 0.1])
    points = points + np.where(sharp[:, None], rng.normal(0, 0.03, points.shape), 0.0)
    first, last = np.sort(rng.choice(len(points) + 1, 2, replace=False))
    places = np.arange(first, last)
    places = places[rng.random(places.size) < 0.9]
    gate = kernels.gate_of(SIGMA)
    owner, table, squares = kernels.split(points, places, SIGMA, gate, min_points)
    walls = reference_splitting.split(points, places, SIGMA, gate, min_points, RULES)
    assert_same_walls(owner, table, (reference_splitting.owners(len(points), walls), walls))
    freedom = [len(inner) - 2 for _, _, inner, _ in walls]
    assert squares[1] == sum(freedom)
    due = sum(f * w[3] for f, w in zip(freedom, walls, strict=True))
    assert squares[0] == pytest.approx(due, rel=1e-6, abs=1e-15)


@given(seeds, st.integers(3, 5))
def test_walls_are_searched_for_as_the_twin_does(rng, min_points):
    points, beams, _ = niche(rng)
    some = slice(0, rng.integers(2, len(points)))
    points, beams = points[some], beams[some]
    free = rng.random(len(points)) < 0.95
    cut = (min_points, 2, 0.15)
    owner, table, seen = kernels.split_walls(points, beams, free, SIGMA, GRAZING, cut)
    rules = (kernels.gate_of(SIGMA), RULES, splitting.ENOUGH, noise.MIN_SIGMA)
    walls, sigma = reference_splitting.search(points, beams, free, SIGMA, cut, link, rules)
    assert_same_walls(owner, table, (reference_splitting.owners(len(points), walls), walls))
    assert seen == pytest.approx(sigma, rel=1e-6)


def test_walls_that_share_all_their_ends_fit_in_the_table():
    # An arc so bent that each piece has three points, the fewest of a wall that may get a fourth.
    radius, bulge, count = 5.0, 0.009, 65
    angle = np.arange(count) * math.sqrt(2 * bulge / radius)
    points = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    owner, table, _ = kernels.split_walls(
        points, np.arange(count), np.ones(count, bool), SIGMA, GRAZING, (4, 2, 0.15)
    )
    assert len(table) == 32
    assert (np.bincount(owner) == table[:, 5]).all()


def test_a_full_turn_that_ends_in_the_point_where_it_began_is_split():
    # Both end beams give one point: the chain's chord has no direction.
    square = [(2, 0), (2, 2), (0, 2), (-2, 2), (-2, 0), (-2, -2), (0, -2), (2, -2), (2, 0)]
    corners = np.array(square, float)
    share = np.arange(160) / 20
    points = np.concatenate([
        [corners[int(s)] + (s % 1) * (corners[int(s) + 1] - corners[int(s)]) for s in share],
        corners[:1],
    ])  # fmt: skip
    owner, _, _ = kernels.split(points, np.arange(161), SIGMA, kernels.gate_of(SIGMA), 4)
    assert (owner >= 0).all()
    for k in range(4):
        middle = 20 + 40 * k  # of a side, seen from its corners on
        assert len(set(owner[middle + 1 : middle + 20])) == 1


def test_each_point_of_a_clean_room_is_on_one_wall():
    # The points of both walls at a corner too: none is lost where a piece is split.
    for seed in range(20):
        world, pose = random_room(np.random.default_rng(seed))
        walls = list(world.walls[:5])  # without the pillar
        scan, hit = look(walls, sigma=0.003, seed=seed, beams=361, view=5.0, pose=pose)
        found = SplitAndMerge()(scan)
        beams = np.bincount(hit[scan.beams], minlength=5)
        assert (beams[beams > 0] >= 4).all()
        assert (found.points.sum(axis=0) == scan.valid).all()


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


@pytest.mark.parametrize(
    ("reach", "parameters"), [(5.0, {}), (12.0, {"min_incidence": math.radians(4)})]
)
def test_a_wall_stays_whole_where_the_beams_graze_it(reach, parameters):
    # The last steps are wider than max_gap, and than a step between two surfaces elsewhere.
    scan = scan_of([(0.2, 1.0), (reach, 1.0)], sigma=SIGMA, beams=181)
    found = SplitAndMerge(**parameters)(scan)
    assert len(found) == 1
    assert found.support[0] == len(scan.points)
    assert np.linalg.norm(np.diff(scan.points[:2], axis=0)) > 0.3


def test_the_adaptive_break_follows_min_incidence():
    # Two points of one wall are a surface at 8 degrees, and none where 20 are asked for.
    points = scan_of([(0.2, 1.0), (7.0, 1.0)], beams=181).points
    assert kernels.linked(points, 1, 0, 0.0, math.radians(5))
    assert not kernels.linked(points, 1, 0, 0.0, math.radians(20))


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
    np.testing.assert_allclose(two, 4 * one, rtol=1e-9)


@pytest.mark.parametrize("angle", [0.0, math.pi / 2, -0.1, math.nan])
def test_an_incidence_that_is_none_is_refused(angle):
    with pytest.raises(ValueError, match=rf"min_incidence must be in \(0, pi/2\) rad, got {angle}"):
        SplitAndMerge(min_incidence=angle)
