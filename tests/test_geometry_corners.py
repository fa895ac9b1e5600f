"""Points at the corner of two walls go to the wall on their side of it."""

import math

import kernels
import kernels_walls
import numpy as np
import pytest
import reference_corners
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.direct_hough import DirectHough
from laserfeatures_plugins.ransac import Ransac
from scenes import chain, line_errors, look, needs_compiler, true_lines

from laserfeatures import Pose2D
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
    for corner in np.flatnonzero(np.diff(owner))[:: rng.integers(1, 4)]:
        first = max(0, corner - rng.integers(0, 4))
        owner[first : corner + rng.integers(0, 4)] = walls_table.FREE
    after, changed = kernels_walls.part_at_corners(points, owner, table, gate)
    rules = (corner_points.BESIDE, corner_points.LEAST_SINE)
    expected = reference_corners.part_at_corners(points, owner, table[:, :2], gate, rules)
    np.testing.assert_array_equal(after, expected)
    moved = expected != owner
    assert {*owner[moved].tolist(), *expected[moved].tolist()} - {walls_table.FREE} <= set(
        np.flatnonzero(changed)
    )


@needs_compiler
@pytest.mark.parametrize(
    "walls",
    [chain((2, -1.5), (2, 1), (1.78, 1)), chain((2, -3), (2, -1), (2.25, -1), (2.25, 2))],
    ids=["at the end of a long wall", "between two"],
)
@pytest.mark.parametrize("detector", [DirectHough, Ransac])
def test_noise_does_not_choose_the_points_of_a_short_wall(walls, detector):
    # Measured: the mean errors of its direction are 3 % and 6 % of their deviation from those of
    # fits to the beams that truly hit it, and 93.7 % to 97.0 % are inside their 95 % ellipse. When
    # each point went to the nearest wall: 12 % and 19 %, and 89.3 % to 95.0 %.
    error, bias, inside = [], [], []
    for seed in range(300):
        # The corner is anywhere between two beams.
        pose = Pose2D(0.0, 0.0, np.random.default_rng(seed).uniform(0, math.pi / 360))
        scan, hit = look(walls, sigma=SIGMA, seed=seed, pose=pose)
        mine = np.flatnonzero(hit[scan.beams] == 1)
        assert 5 <= len(mine) <= 6
        truth = true_lines(walls, pose)[1]
        lines = detector(range_sigma=SIGMA)(scan).lines
        off = line_errors(np.stack([lines.theta, lines.d], axis=1), truth)
        (k,) = np.flatnonzero((abs(off[:, 0]) < 0.3) & (lines.support < 12))
        best = kernels.fit_line(scan.points, mine, truth[0])
        error.append(off[k, 0])
        bias.append(off[k, 0] - line_errors(best[:2], truth)[0])
        inside.append(off[k] @ np.linalg.solve(lines.covariance[k], off[k]) < -2 * math.log(0.05))
    assert abs(np.mean(bias)) < 0.1 * np.std(error)
    two_sigma = 2 * math.sqrt(0.95 * 0.05 / len(inside))
    assert np.mean(inside) == pytest.approx(0.95, abs=two_sigma)


def test_a_point_far_from_the_wall_on_its_side_stays():
    scan, hit = look(RECESS, beams=181)
    owner = hit[scan.beams]
    first = int(np.flatnonzero(owner == 1)[0])
    table = kernels.fitted(scan.points, owner)
    owner[first - 1] = 1  # what was found last took one point of the first wall
    after, changed = kernels_walls.part_at_corners(scan.points, owner, table, 0.015)
    assert after[first - 1] == 0
    assert np.flatnonzero(changed).tolist() == [0, 1]
    points = scan.points.copy()
    points[first - 1] *= 0.9
    after, changed = kernels_walls.part_at_corners(points, owner, table, 0.015)
    np.testing.assert_array_equal(after, owner)
    assert not changed.any()
