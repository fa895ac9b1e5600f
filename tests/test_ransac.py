import math
from dataclasses import replace

import kernels
import kernels_proposals
import numpy as np
import pytest
import reference_candidates
import reference_sampling
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.ransac import Ransac, sampling
from scenes import (
    chain,
    line_errors,
    look,
    nearest_line,
    needs_compiler,
    niche,
    niche_scan,
    random_room,
    scan_of,
    true_lines,
    wall,
)

from laserfeatures import LaserScan, get_extractor

GATE = 0.015
seeds = st.integers(0, 10**6).map(np.random.default_rng)
states = st.integers(1, sampling.MODULUS - 1)
windows = st.sampled_from([0, 1, 5, 12, 400])


def random_pool(rng, points):
    """Return the places of some points, at least three."""
    return np.sort(rng.choice(len(points), rng.integers(3, len(points) + 1), replace=False))


@given(seeds, windows, states)
def test_the_second_point_is_drawn_as_the_twin_says(rng, window, random):
    count = int(rng.integers(2, 30))
    beams = np.sort(rng.choice(4 * count, count, replace=False))
    pool = np.sort(rng.choice(count, rng.integers(2, count + 1), replace=False))
    for first in range(len(pool)):
        second = kernels.partner(beams, pool, first, window, random)
        assert second == reference_sampling.partner(beams, pool, first, window, random)
        assert second != first


@given(seeds)
def test_a_line_goes_through_both_points(rng):
    points = rng.uniform(-5, 5, (2, 2))
    line = kernels.line_through(points, 0, 1)
    np.testing.assert_allclose(line, reference_sampling.line_through(*points), atol=1e-9)
    np.testing.assert_allclose(points @ line[:2], line[2], atol=1e-9)


def test_two_points_in_one_place_give_a_line_without_inliers():
    points = np.array([(1.0, 2.0), (1.0, 2.0), (1.0, 3.0)])
    line = kernels.line_through(points, 0, 1)
    cost, inliers, _ = kernels.score(points, np.arange(3), line, GATE, math.inf)
    assert inliers == 0
    assert cost == pytest.approx(3 * GATE**2)


@given(seeds, st.floats(0.0, 1.2))
def test_a_line_is_scored_as_its_twin_says(rng, share):
    points, _, lines = niche(rng)
    pool = random_pool(rng, points)
    theta, d = lines[rng.integers(len(lines))] + rng.normal(0, 0.01, 2)
    line = math.cos(theta), math.sin(theta), d
    # From a bound that stops the count at once to one that never does.
    worth = share * len(pool) * GATE**2
    cost, inliers, pairs = kernels.score(points, pool, line, GATE, worth)
    expected = reference_sampling.score(points[pool], line, GATE, worth)
    assert (inliers, pairs) == expected[1:]
    assert cost == pytest.approx(expected[0], rel=1e-9)


@given(seeds, windows, states, st.sampled_from([0.5, 0.99, 0.999999]), st.integers(1, 60))
def test_the_best_line_is_that_of_the_twin(rng, window, state, confidence, max_trials):
    points, beams, _ = niche(rng)
    pool = random_pool(rng, points)
    settings = (window, math.log(1 - confidence), max_trials, 0)
    seed, line, inliers, after = kernels.best_line(points, beams, pool, GATE, settings, state)
    best, expected, _ = reference_sampling.best_line(points, beams, pool, GATE, settings, state)
    assert (seed, inliers, after) == (best[0], best[2], expected)
    assert line == pytest.approx(best[1], abs=1e-9)


@given(seeds, windows, states)
def test_of_many_points_some_tell_the_best_line_as_of_the_twin(rng, window, state):
    points = rng.normal((0, 2), (3, 0.01), (rng.integers(250, 600), 2))
    args = points, np.arange(len(points)), np.arange(len(points)), GATE, (window, -5.0, 60, 0)
    seed, line, inliers, after = kernels.best_line(*args, state)
    best, expected, _ = reference_sampling.best_line(*args, state)
    assert (seed, inliers, after) == (best[0], best[2], expected)
    assert line == pytest.approx(best[1], abs=1e-9)


@given(seeds, windows, st.integers(0, 2**40), st.integers(1, 60), st.integers(0, 4))
def test_lines_are_proposed_as_the_twin_does(rng, window, state, max_trials, max_missed):
    points = kernels.weighed(niche_scan(rng)[0])
    settings = (window, math.log(0.01), max_trials, state)
    rules = (sampling.LEAST, sampling.SIGMAS, sampling.FAILURES, sampling.MODULUS)
    expected = reference_sampling.propose(points, settings, max_missed, rules)
    found = kernels_proposals.sampled(points, settings, max_missed)
    reference_candidates.assert_same(found, expected)


def samples_drawn(settings, *, share=0.5, state=1):
    """Return how many samples are drawn where a share of the points is on one wall."""
    rng = np.random.default_rng(3)
    points = np.stack([np.full(200, 2.0), np.linspace(-2, 2, 200)], axis=1)
    points[:, 0] += rng.normal(0, 0.003, 200)
    false = rng.permutation(200)[: round(200 * (1 - share))]
    points[false] = rng.uniform((-9, -9), (9, 9), (false.size, 2))
    args = (points, np.arange(200), np.arange(200), GATE, settings, state)
    after = kernels.best_line(*args)[3]
    draws = reference_sampling.numbers(state)
    return next(k for k in range(1, 10**4) if (next(draws), next(draws))[1] == after)


@pytest.mark.parametrize("window", [0, 12])
@pytest.mark.parametrize("confidence", [0.9, 0.99, 0.999999])
def test_samples_are_drawn_until_a_good_one_has_come_with_the_confidence(window, confidence):
    # Half of the points are on the wall, so a quarter of the pairs. Not all good samples find all
    # of its points: those that find fewer ask for more.
    due = math.log(1 - confidence) / math.log(1 - 0.25)
    drawn = samples_drawn((window, math.log(1 - confidence), 10**6, 0))
    assert due * 0.9 < drawn < due * 1.6


def test_samples_are_drawn_at_most_so_many_times():
    for most in (1, 2, 7):
        assert samples_drawn((12, math.log(1e-6), most, 0), share=0.2) == most


def test_a_line_that_explains_all_points_ends_the_search():
    assert samples_drawn((0, math.log(1e-9), 1000, 0), share=1.0) < 10


SCENE = chain((2, -2), (2, 0.5), (1.5, 0.5), (1.5, 1.5), (-0.5, 1.5))  # with a pillar


def assert_finds_the_scene(found):
    lines = np.stack([found.lines.theta, found.lines.d], axis=1)
    assert len(lines) == 4
    for truth in true_lines(SCENE):
        assert len(nearest_line(lines, truth, math.radians(1), 0.01)) == 1


def test_a_line_that_is_no_wall_does_not_hide_one_of_fewer_points():
    # Twelve far points on a line are no wall: they are too far apart. Nine near ones are one.
    angles = np.radians(np.arange(-90, 91))
    ranges = np.full(181, math.nan)
    few, wall_beams = slice(30, 141, 10), slice(91, 100)
    ranges[few] = 3.0 / np.cos(angles[few])
    ranges[wall_beams] = 1.5 / np.cos(angles[wall_beams])
    extractor = get_extractor("ransac", window=0, range_sigma=0.005)
    found = extractor(LaserScan(angles=angles, ranges=ranges)).segments
    assert len(found) == 1
    np.testing.assert_array_equal(np.flatnonzero(found.points[0]), np.arange(91, 100))


@pytest.mark.parametrize("seed", [0, 1, 2**31 - 2, 2**40 + 17])
@pytest.mark.parametrize("window", [0, 4, 12, 100])
def test_the_walls_of_an_easy_scene_hang_on_neither_seed_nor_window(seed, window):
    scan = scan_of(*SCENE, sigma=0.004, seed=5)
    assert_finds_the_scene(Ransac(seed=seed, window=window)(scan))


def spoiled(scan, share, seed):
    """Return a scan some of whose beams return from anywhere, and which they are."""
    rng = np.random.default_rng(seed)
    false = rng.random(len(scan)) < share
    return replace(scan, ranges=np.where(false, rng.uniform(0.3, 6.0, len(scan)), scan.ranges))


def test_the_seed_and_nothing_else_changes_the_draws():
    scan = spoiled(scan_of(*SCENE, sigma=0.004, beams=181), 0.5, 1)

    def proposed(detector):
        return detector.propose(detector.prepared(scan))

    few = {"max_trials": 5, "window": 0, "range_sigma": 0.004}
    found = [proposed(Ransac(seed=seed, **few)) for seed in (0, 0, 1, 2, 3)]
    np.testing.assert_array_equal(found[0], found[1])
    assert len({lines.tobytes() for lines in found}) > 2
    again = Ransac(seed=0, **few)
    again(scan_of(wall(0.0, 2.0, -1, 1)))  # each scan starts anew
    np.testing.assert_array_equal(proposed(again), found[0])


@needs_compiler
def test_more_samples_propose_more_walls_among_false_beams():
    # What was not proposed, the partition finds: of the walls alone nothing can be told.
    def proposed(**parameters):
        hits = []
        rng = np.random.default_rng(0)
        detector = Ransac(window=0, range_sigma=0.005, **parameters)
        for seed in range(30):
            world, pose = random_room(rng)
            clean, hit = look(world, sigma=0.005, seed=seed, pose=pose, beams=181)
            c, s, d = detector.propose(detector.prepared(spoiled(clean, 0.3, seed)))[:3]
            lines = np.stack([np.arctan2(s, c), d], axis=1)
            for k, truth in enumerate(true_lines(world, pose)):
                if (hit == k).sum() >= 15:
                    near = abs(line_errors(lines, truth))
                    hits.append(((near[:, 0] < 0.03) & (near[:, 1] < 0.05)).any())
        return np.mean(hits)

    one, few, many = (proposed(max_trials=n) for n in (1, 10, 200))
    assert one < few < many
    assert proposed(confidence=0.05) < proposed(confidence=0.999999)


def test_false_beams_do_not_hide_a_long_wall():
    for seed in range(10):
        clean = scan_of(wall(0.2, 2.0, -2.0, 2.0), sigma=0.005, seed=seed, beams=181)
        found = Ransac()(spoiled(clean, 0.2, seed))
        longest = found.support.argmax()
        line = found.line[longest]
        error = line_errors((found.lines.theta[line], found.lines.d[line]), (0.2, 2.0))
        assert error == pytest.approx(0, abs=0.01)


def test_a_window_wider_than_the_scan_is_refused_with_the_numbers():
    scan = LaserScan.uniform([2.0] * 20, 0.0, 0.01)
    with pytest.raises(ValueError, match="window is 21 beams, the scan has only 20"):
        Ransac(window=21)(scan)
    Ransac(window=20)(scan)


@pytest.mark.parametrize("beams", [0, 1, 5, 11])
def test_the_default_window_suits_every_scan(beams):
    assert len(Ransac()(LaserScan.uniform([2.0] * beams, 0.0, 0.01))) <= 1


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"window": -1}, "window must be >= 0, got -1"),
        ({"confidence": 0.0}, r"confidence must be in \(0, 1\), got 0\.0"),
        ({"confidence": 1.0}, r"confidence must be in \(0, 1\), got 1\.0"),
        ({"confidence": math.nan}, r"confidence must be in \(0, 1\), got nan"),
        ({"max_trials": 0}, "max_trials must be >= 1, got 0"),
        ({"seed": -1}, "seed must be >= 0, got -1"),
        ({"seed": 2**64}, r"seed must be a whole number under 2\*\*63, got 18446744073709551616"),
        ({"seed": 1.5}, r"seed must be a whole number under 2\*\*63, got 1\.5"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        Ransac(**parameters)


def test_a_wall_of_fewer_than_min_points_is_not_found():
    scan = scan_of(wall(0.0, 2.0, -0.2, 0.2))
    count = len(scan.points)
    assert len(Ransac(min_points=count)(scan)) == 1
    assert len(Ransac(min_points=count + 1)(scan)) == 0


def test_each_point_is_on_one_wall():
    scan = scan_of(*SCENE, sigma=0.005)
    found = Ransac()(scan)
    assert found.points.sum(axis=0).max() == 1
    assert found.points.sum() > 0.97 * len(scan.points)
