"""What detectors share to propose lines, beside its twins."""

import math

import kernels
import kernels_proposals
import numpy as np
import pytest
import reference_candidates
from hypothesis import given
from hypothesis import strategies as st
from scenes import niche_scan, scan_of, wall

from laserfeatures.engine.prices import PRICE, STRAY_PRICE

seeds = st.integers(0, 10**6).map(np.random.default_rng)
SIGMA = 0.005


def some_line(rng, lines):
    """Return one of some lines, hit or narrowly missed, as (c, s, d)."""
    theta, d = lines[rng.integers(len(lines))] + rng.normal(0, 0.01, 2)
    return math.cos(theta), math.sin(theta), d


def grown(rng, width, max_missed):
    """Return some returns, what is taken of them, and how to grow a candidate there."""
    scan, lines = niche_scan(rng)
    points = kernels.weighed(scan, SIGMA, roughness=rng.choice([0.0, 0.01]))
    taken = rng.random(len(points.x)) < 0.1
    c, s, d = some_line(rng, lines)
    seed = int(abs(points.x * c + points.y * s - d).argmin())
    return points, taken, (points, taken, seed, (c, s, d), width, max_missed)


@given(seeds, st.sampled_from([0.0, 0.02]))
def test_returns_are_on_a_line_as_the_twin_says(rng, width):
    scan, lines = niche_scan(rng)
    points, line = kernels.weighed(scan, SIGMA), some_line(rng, lines)
    found = [kernels_proposals.is_inlier(points, i, line, width) for i in range(len(points.x))]
    assert found == reference_candidates.inliers(points, line, width).tolist()


@given(seeds, st.sampled_from([0.0, 0.02, 0.1]), st.integers(0, 4))
def test_a_candidate_is_grown_as_the_twin_does(rng, width, max_missed):
    _, _, args = grown(rng, width, max_missed)
    found = kernels_proposals.grow(*args)
    line, *run, saved = reference_candidates.grow(*args)
    assert [found.first, found.last] == run
    assert (found.c, found.s, found.d) == pytest.approx(line, rel=1e-6, abs=1e-9)
    assert found.saved == pytest.approx(saved, rel=1e-6, abs=1e-3)


@given(seeds)
def test_a_candidate_takes_what_it_explains(rng):
    points, taken, args = grown(rng, 0.02, 3)
    found = kernels_proposals.grow(*args)
    row, after = kernels_proposals.add(points, taken, found)
    assert row.tolist() == list(found[:5])
    twin = ((found.c, found.s, found.d), found.first, found.last, None)
    assert after.tolist() == reference_candidates.taken_by(points, taken, twin).tolist()


def test_a_wall_saves_the_price_of_its_stray_returns():
    points = kernels.weighed(scan_of(wall(0.3, 2.0, -1.0, 1.0), beams=181), SIGMA)
    n = len(points.x)
    line = math.cos(0.3), math.sin(0.3), 2.0
    found = kernels_proposals.grow(points, np.zeros(n, bool), n // 2, line, 0.02, 3)
    assert (found.first, found.last) == (0, n)
    assert found.saved == pytest.approx(n * STRAY_PRICE - PRICE)


@pytest.mark.parametrize(("missed", "whole"), [(3, True), (4, False)])
def test_more_misses_in_a_row_than_allowed_end_a_candidate(missed, whole):
    scan = scan_of(wall(0.0, 2.0, -1.0, 1.0), beams=181)
    points = kernels.weighed(scan, SIGMA)
    n = len(points.x)
    taken = np.zeros(n, bool)
    taken[n // 2 : n // 2 + missed] = True
    found = kernels_proposals.grow(points, taken, 3, (1.0, 0.0, 2.0), 0.02, 3)
    assert (found.first, found.last) == (0, n if whole else n // 2)


def test_two_returns_are_no_candidate():
    points = kernels.weighed(scan_of(wall(0.0, 2.0, -1.0, 1.0), beams=181), SIGMA)
    taken = np.ones(len(points.x), bool)
    taken[10:12] = False
    found = kernels_proposals.grow(points, taken, 10, (1.0, 0.0, 2.0), 0.02, 3)
    assert found.saved == -PRICE
