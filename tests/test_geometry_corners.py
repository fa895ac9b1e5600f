"""Points at the corner of two walls go to the wall on their side of it."""

import math

import kernels
import kernels_walls
import numpy as np
import reference_corners
from hypothesis import given
from hypothesis import strategies as st
from scenes import chain, look

from laserfeatures.geometry import corner_points
from laserfeatures.geometry import walls as walls_table

SIGMA = 0.005
RECESS = chain((2, -2), (2, -1), (2.3, -1), (2.3, 1), (2, 1), (2, 2), (0.4, 1.8))
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


@given(seeds, st.sampled_from([0.015, 0.06]), st.sampled_from([0.005, 0.03]))
def test_points_at_corners_are_parted_as_the_twin_says(rng, gate, sigma):
    scan, hit = look(RECESS, sigma=sigma, seed=int(rng.integers(10**6)), beams=181)
    # Turned anyhow: the bearings may wrap at a corner.
    points, owner = turned(scan.points, rng.uniform(-math.pi, math.pi)), hit[scan.beams]
    table = kernels.fitted(points, owner)
    owner = np.roll(owner, rng.integers(-4, 5))  # all walls end beside their corners
    others = rng.integers(walls_table.ROUND, len(RECESS), len(owner))
    owner = np.where(rng.random(len(owner)) < 0.1, others, owner)
    after, changed = kernels_walls.part_at_corners(points, owner, table, gate)
    rules = (corner_points.BESIDE, corner_points.LEAST_SINE)
    expected = reference_corners.part_at_corners(points, owner, table[:, :2], gate, rules)
    np.testing.assert_array_equal(after, expected)
    moved = expected != owner
    assert {*owner[moved].tolist(), *expected[moved].tolist()} - {walls_table.FREE} <= set(
        np.flatnonzero(changed)
    )
