"""Lines cut into segments, and the stage as a whole."""

import math

import kernels
import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import TURN, look, needs_compiler, random_room, scan_of

from laserfeatures import LaserScan, get_extractor
from laserfeatures.engine import WallDetector, segments
from laserfeatures.engine.explain import prepare

seeds = st.integers(0, 2**32 - 1)
gaps = st.tuples(st.integers(0, 4), st.floats(0.0, 0.5), st.sampled_from([2.0, 4.0, math.inf]))


@given(seeds, gaps, st.booleans())
def test_lines_are_cut_where_a_loop_cuts_them(seed, rules, ring):
    rng = np.random.default_rng(seed)
    count, total = int(rng.integers(1, 60)), 80
    beams = np.sort(rng.choice(total, count, replace=False))
    if ring:
        beams += int(rng.integers(0, total))
    points = np.stack([np.full(count, 2.0), np.cumsum(rng.exponential(0.1, count))], axis=1)
    points += rng.normal(0, 0.01, (count, 2))
    lines = np.array([(0.0, 2.0), (0.02, 1.98), (math.pi / 2, 1.0)])
    members = rng.random((3, count)) < 0.7
    line, ends, support, rms, held = kernels.cut_segments(
        points, beams, beams % total, total, lines, members, *rules
    )
    expected = reference.cut_segments(points, beams, lines, members, *rules)
    assert line.tolist() == [k for k, *_ in expected]
    for j, (_, both, of, off) in enumerate(expected):
        np.testing.assert_allclose(ends[j], both, atol=1e-12)
        assert np.flatnonzero(held[j]).tolist() == sorted(of % total)
        assert support[j] == len(of)
        assert rms[j] == pytest.approx(off, abs=1e-12)


@pytest.mark.parametrize(
    ("apart", "metres", "spacing", "gap"),
    [
        (1, 0.2, 0.01, False),  # not wide
        (1, 0.3, 0.07, True),  # jumps
        (1, 0.3, 0.08, False),
        (4, 0.3, 0.02, False),
        (5, 0.3, 0.02, True),  # misses four
        (5, 0.2, 0.02, False),
        (1, 9.0, math.inf, False),
    ],
)
def test_a_gap_is_wide_and_misses_beams_or_jumps(apart, metres, spacing, gap):
    assert kernels.is_gap(apart, metres, spacing, 3, 0.25, segments.MAX_GROWTH) == gap


def test_no_points_have_no_segments():
    found = kernels.cut_segments(
        np.empty((0, 2)), np.empty(0, np.int64), np.empty(0, np.int64), 5, np.empty((0, 2)),
        np.empty((0, 0), bool), 3, 0.25, 4.0,
    )  # fmt: skip
    assert [len(each) for each in found] == [0] * 5


def test_the_noise_is_estimated_where_none_is_told():
    scan = scan_of(*[[(2, -1.5), (2, 1.2)], [(2, 1.2), (-0.5, 1.2)]], sigma=0.005)
    seen = (scan.directions, scan.ranges, (0.0, 30.0), scan.ring)
    _, estimated = prepare(*seen, -1.0, 0.0, 0.003, -1.0)
    assert estimated[0] == pytest.approx(0.005, rel=0.3)
    assert estimated[2] == 0.003
    assert prepare(*seen, 0.02, 0.01, 0.0, 0.0)[1] == (0.02, 0.01, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_room_seen_in_a_mirror_has_the_walls_of_the_mirror(seed):
    world, pose = random_room(np.random.default_rng(seed))
    scan, _ = look(world, sigma=0.005, seed=seed, beams=360, view=TURN * 0.8, pose=pose)
    other = LaserScan(angles=-scan.angles[::-1], ranges=scan.ranges[::-1], range_max=30.0)
    lines, mirrored = (WallDetector()(each).lines for each in (scan, other))
    foot = np.stack([lines.d * np.cos(lines.theta), -lines.d * np.sin(lines.theta)], axis=1)
    there = mirrored.d * np.stack([np.cos(mirrored.theta), np.sin(mirrored.theta)])
    assert len(lines) == len(mirrored)
    for point, support in zip(foot, lines.support, strict=True):
        off = np.hypot(*(there.T - point).T)
        assert off.min() < 0.005
        assert abs(mirrored.support[off.argmin()] - support) <= 2


@pytest.mark.parametrize("seed", range(6))
def test_each_wall_of_a_room_is_found_with_the_errors_it_is_said_to_have(seed):
    world, pose = random_room(np.random.default_rng(seed + 20))
    scan, hit = look(world, sigma=0.005, seed=seed, beams=720, view=TURN * 719 / 720, pose=pose)
    found = WallDetector()(scan)
    for k, held in zip(found.line, found.points, strict=True):
        numbers, counts = np.unique(hit[held], return_counts=True)
        assert counts.max() >= 0.9 * held.sum()
        start, end = np.asarray(world.walls)[numbers[counts.argmax()]]
        turn = pose.theta
        way = (end - start) / np.linalg.norm(end - start)
        normal = np.array([-way[1], way[0]])
        d = normal @ (start - (pose.x, pose.y))
        theta = math.atan2(normal[1], normal[0]) - turn
        flip = math.floor(theta / math.pi) % 2
        off = theta - found.lines.theta[k]
        error = np.array([off - math.pi * round(off / math.pi), (-d if flip else d)])
        error[1] -= found.lines.d[k]
        if abs(found.lines.theta[k] - theta % math.pi) > 3:  # at the wrap
            continue
        assert error @ np.linalg.solve(found.lines.covariance[k], error) < 25


@needs_compiler
@pytest.mark.parametrize("options", [{}, {"preset": "paper", "max_peaks": 200}])
def test_more_beams_of_segments_than_memory_should_hold_are_refused(options):
    beams, each = 120_000, 20  # short walls, each at a distance of its own
    steps = np.repeat(np.random.default_rng(1).uniform(2.0, 10.0, beams // each), each)
    scan = LaserScan(angles=np.linspace(-3.0, 3.0, beams), ranges=steps)
    with pytest.raises(ValueError, match=r"at most 5e\+08 beams over all segments, got \d+ segm"):
        get_extractor("direct_hough", **options)(scan)
