"""Short walls whose ends their neighbours took get them back."""

import math

import kernels
import kernels_walls
import numpy as np
import pytest
import reference
import reference_corners
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.direct_hough import DirectHough
from laserfeatures_plugins.ransac import Ransac
from scenes import chain, look, needs_compiler

from laserfeatures import geometry
from laserfeatures.geometry import segments, short_walls
from laserfeatures.geometry import walls as walls_table

FREE = walls_table.FREE
GAPS = (2, 0.15)  # max_missed, max_gap
STEPS = chain((2, -2), (2, -0.7), (2.2, -0.7), (2.2, 0.6), (2, 0.6), (2, 1.0), (1.8, 1.0), (1.8, 2))
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def judged(points, members, sigma):
    """Return theta, whether members are a short wall, and the variance of their noise."""
    x, y = points[members[-1]] - points[members[0]]
    guess = math.atan2(-x, y)
    mine = points[members]
    weights = reference.weights(mine, guess, geometry.INCIDENCE_FLOOR)
    fit = reference.fit_line(mine, weights, 1.0)
    flat, variance, _ = kernels.is_wall(points, members, fit, sigma)
    quiet = math.sqrt(variance) < short_walls.NOISE * sigma
    known = math.sqrt(fit[2]) * sigma < short_walls.TURN
    return fit[0], flat and quiet and known, variance


@given(seeds, st.integers(3, 6), st.sampled_from([0.002, 0.01]))
def test_short_walls_are_added_as_the_twin_says(rng, min_points, sigma):
    scan, hit = look(STEPS, sigma=sigma, seed=int(rng.integers(10**6)), beams=181)
    keep = rng.random(len(scan.points)) < rng.choice([1.0, 0.8, 0.5])
    points, beams, owner = scan.points[keep], scan.beams[keep], hit[scan.beams[keep]]
    table = np.zeros((len(STEPS), 6))  # only the numbers of points matter
    for _ in range(rng.integers(1, 6)):  # runs that nothing has explained
        first = rng.integers(len(points))
        owner[first : first + rng.integers(1, min_points + 3)] = FREE
    counts = np.bincount(owner[owner >= 0], minlength=len(table))
    cut = (min_points, rng.choice([0, 2]), rng.choice([0.01, 0.03, 0.15]))
    after, walls = kernels_walls.add_short_walls(points, beams, owner, table, sigma, cut)
    rules = (short_walls.FEWEST, segments.MAX_GROWTH, judged)
    expected = reference_corners.add_short_walls(points, beams, owner, counts, sigma, cut, rules)
    np.testing.assert_array_equal(after, expected)
    if len(walls) > len(STEPS):  # from the others, later ones may have taken a point
        members = np.flatnonzero(expected == len(walls) - 1)
        assert walls[-1, 0] == pytest.approx(judged(points, members, sigma)[0], abs=1e-9)


@needs_compiler
@pytest.mark.parametrize("sigma", [0.005, None], ids=["noise known", "unknown"])
@pytest.mark.parametrize("detector", [DirectHough, Ransac])
def test_the_end_of_a_niche_that_four_beams_hit_is_found(detector, sigma):
    # A long wall that was found first took the nearest of the four.
    found = []
    rng = np.random.default_rng(0)
    while len(found) < 100:
        x, y, deep = rng.uniform((1.5, -1.5, 0.2), (2.5, -0.5, 0.4))
        niche = chain((x, -2.5), (x, y), (x + deep, y), (x + deep, 1.5))
        scan, hit = look(niche, sigma=0.005, seed=rng)
        if (hit == 1).sum() != 4:
            continue
        segments = detector(range_sigma=sigma)(scan)
        turn = abs(segments.lines.theta - math.pi / 2) < 0.35
        held = (segments.points & (hit == 1)).sum(axis=1)
        found.append((turn[segments.line] & (held >= 3)).any())
    assert np.mean(found) >= 0.95


def test_a_wall_keeps_the_points_that_it_needs():
    scan, hit = look(chain((2, -2), (2, -0.9), (2.2, -0.9), (2.2, 1.5)))
    owner = hit[scan.beams]
    short = np.flatnonzero(owner == 1)
    owner[short[1:]] = FREE
    owner[short[0]] = 0  # the first wall took a point of the short one
    table = np.zeros((3, 6))
    cut = (4, *GAPS)
    after, _ = kernels_walls.add_short_walls(scan.points, scan.beams, owner, table, 0.005, cut)
    assert (after[short] == 3).all()
    # Now the first wall has not more points than it needs, the other none beside the run.
    few = slice(short[0] - 3, short[-1] + 1)
    points, beams, owner = scan.points[few], scan.beams[few], owner[few]
    after, _ = kernels_walls.add_short_walls(points, beams, owner, table, 0.005, cut)
    np.testing.assert_array_equal(after, owner)
