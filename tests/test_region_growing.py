import math
import time
from dataclasses import replace

import kernels
import kernels_proposals
import numpy as np
import pytest
import reference_candidates
import reference_growing
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.region_growing import RegionGrowing, growing
from scenes import (
    chain,
    line_errors,
    look,
    needs_compiler,
    niche_scan,
    random_room,
    scan_of,
    wall,
)

from laserfeatures import LaserScan, get_extractor

RULES = (growing.SEED, growing.FLAT, growing.PACE)
seeds = st.integers(0, 10**6).map(np.random.default_rng)


@given(seeds, st.integers(0, 4))
def test_a_region_grows_to_its_end_as_its_twin_does(rng, max_missed):
    points = kernels.weighed(niche_scan(rng)[0])
    first = int(rng.integers(len(points.x)))
    found = kernels_proposals.grow_region(points, first, max_missed)
    line, *run, saved = reference_growing.grow_region(points, first, max_missed, *RULES[:2])
    assert [found.first, found.last] == run
    assert found.saved == pytest.approx(saved, rel=1e-6, abs=1e-3)
    if line is not None:
        assert (found.c, found.s, found.d) == pytest.approx(line, rel=1e-6, abs=1e-9)


@given(seeds, st.integers(0, 4), st.sampled_from([0.003, 0.02]))
def test_lines_are_proposed_as_the_twin_does(rng, max_missed, sigma):
    points = kernels.weighed(niche_scan(rng)[0], sigma)
    expected = reference_growing.propose(points, max_missed, *RULES)
    reference_candidates.assert_same(kernels_proposals.regions(points, max_missed), expected)


def spoiled(scan, false, rng):
    """Return a scan some of whose returns are from anywhere, and which beams are true."""
    true = scan.valid.copy()
    true[false] = False
    lost = scan.valid & ~true
    ranges = scan.ranges.copy()
    ranges[lost] = rng.uniform(0.3, 6.0, lost.sum())
    return replace(scan, ranges=ranges), true


@pytest.mark.parametrize(
    "false",
    [[90], [87, 90, 93], [89, 90], [89, 90, 91], slice(4, None, 10), slice(2, None, 5)],
    ids=["one", "three", "two in a row", "three in a row", "every tenth", "every fifth"],
)
@pytest.mark.parametrize("seed", range(5))
def test_false_beams_do_not_end_a_wall(false, seed):
    clean = scan_of(wall(0.2, 2.0, -1.5, 1.5), sigma=0.005, seed=seed, beams=181)
    scan, true = spoiled(clean, false, np.random.default_rng(seed))
    found = RegionGrowing(range_sigma=0.005)(scan)
    assert len(found.lines) == 1
    longest = found.points[found.support.argmax()]  # a false point on the line is none of its own
    assert (longest & true).sum() > 0.9 * true.sum()
    error = line_errors((found.lines.theta[0], found.lines.d[0]), (0.2, 2.0))
    assert error == pytest.approx(0, abs=0.01)


def test_more_missed_beams_than_allowed_end_a_segment_but_not_its_line():
    scan = scan_of(wall(0.0, 2.0, -1.0, 1.0), sigma=0.003, beams=181)
    ranges = scan.ranges.copy()
    ranges[86:94] = math.nan  # eight beams, 28 cm of the wall
    holed = replace(scan, ranges=ranges)
    assert RegionGrowing(max_missed=7)(holed).line.tolist() == [0, 0]
    assert RegionGrowing(max_missed=8)(holed).line.tolist() == [0]


@needs_compiler
@pytest.mark.parametrize(
    "parameters",
    [
        {"range_sigma": 0.005},
        {},
    ],
    ids=["noise known", "default"],
)
def test_long_walls_are_found_where_every_fifth_beam_is_false(parameters):
    # Measured: all walls that 15 true beams hit. By default `direct_hough` finds all too, `ransac`
    # and `split_and_merge` 99 %.
    rng = np.random.default_rng(0)
    found = []
    for seed in range(60):
        world, pose = random_room(rng)
        clean, hit = look(world, sigma=0.005, seed=seed, beams=181, pose=pose)
        scan, true = spoiled(clean, slice(seed % 5, None, 5), rng)
        segments = RegionGrowing(**parameters)(scan)
        for k in range(len(world.walls)):
            mine = (hit == k) & true
            if mine.sum() >= 15:
                found.append(2 * (segments.points & mine).sum(axis=1).max(initial=0) > mine.sum())
    assert len(found) > 150
    assert np.mean(found) > 0.97


@pytest.mark.parametrize("far", [2.0, 80.0, 1000.0])
def test_running_sums_are_as_good_far_from_the_sensor(far):
    scan = scan_of(
        [(far - 0.15, -0.5), (far + 0.15, 0.5)], beams=100, view=0.9 / far, range_max=2e3
    )
    points = kernels.weighed(scan)
    assert len(points.x) > 80
    found = kernels_proposals.grow_region(points, 0, 3)
    assert (found.first, found.last) == (0, len(points.x))
    truth = math.atan2(-0.3, 1.0), far / math.hypot(1.0, 0.3)
    errors = line_errors((math.atan2(found.s, found.c), found.d), truth)
    np.testing.assert_allclose(errors, 0, atol=1e-6)


def test_a_room_of_long_ranges_is_all_walls():
    corners = [(80, -60), (80, 70), (-50, 70), (-50, -60), (80, -60)]
    scan = scan_of(*chain(*corners), sigma=0.01, view=2 * math.pi, beams=1081, range_max=200.0)
    assert len(RegionGrowing()(scan).lines) == 4


@pytest.mark.parametrize("seed", range(5))
def test_each_point_of_a_clean_room_is_on_one_wall(seed):
    world, pose = random_room(np.random.default_rng(seed))
    scan, _ = look(world, sigma=0.003, seed=seed, beams=720, view=6.274, pose=pose)
    found = RegionGrowing()(scan)
    assert found.points.sum(axis=0).max() == 1
    assert found.points.sum() > 0.99 * len(scan.points)


def test_a_wall_of_fewer_than_min_points_is_not_found():
    scan = scan_of(wall(0.0, 2.0, -0.2, 0.2))
    count = len(scan.points)
    assert len(RegionGrowing(min_points=count)(scan)) == 1
    assert len(RegionGrowing(min_points=count + 1)(scan)) == 0


def test_noise_that_is_given_scales_the_covariances():
    scan = scan_of(wall(0.3, 2.0, -1, 1), sigma=0.005)
    one, two = (RegionGrowing(range_sigma=s)(scan).lines.covariance for s in (0.006, 0.012))
    np.testing.assert_allclose(two, 4 * one, rtol=1e-3)  # d errs to second order, too


def test_a_beam_that_one_outlier_parts_from_the_next_is_a_seed_too():
    # Every other beam is false: each seed's next point is no partner, the one after it is.
    clean = scan_of(wall(0.0, 2.0, -1.0, 1.0), sigma=0.003, beams=181)
    scan, true = spoiled(clean, slice(1, None, 2), np.random.default_rng(1))
    found = RegionGrowing(range_sigma=0.003)(scan)
    assert (found.points & true).sum(axis=1).max() == true.sum()


@needs_compiler
def test_time_grows_as_the_beams_do_where_no_region_pays():
    def seconds(beams):
        ranges = np.random.default_rng(0).uniform(0.5, 20.0, beams)
        scan = LaserScan(angles=np.linspace(-3.1, 3.1, beams), ranges=ranges)
        start = time.perf_counter()
        get_extractor("region_growing")(scan)
        return time.perf_counter() - start

    seconds(1000)  # compiled
    assert seconds(100_000) < 100 * max(seconds(10_000), 0.005)  # was 9.5 s, and 0.1 s
