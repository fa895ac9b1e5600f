import math

import kernels
import numpy as np
import pytest
import reference_walls
from hypothesis import given
from hypothesis import strategies as st
from scenes import chain, line_errors, look, scan_of

from laserfeatures.geometry import sharing
from laserfeatures.geometry import walls as walls_table

SIGMA = 0.005
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def corner(rng):
    """Return the points of two walls that meet, and the wall of each by truth."""
    walls = chain((2, -1.5), (2, 1 + rng.uniform(-0.5, 0.5)), (0.0, 1.4))
    scan, hit = look(walls, sigma=SIGMA, seed=int(rng.integers(10**6)), beams=181)
    return scan.points, hit[scan.beams]


@given(seeds)
def test_points_at_the_ends_of_walls_go_to_the_nearest_as_their_twin_says(rng):
    points, owner = corner(rng)
    swapped = rng.random(len(points)) < 0.1
    owner = np.where(swapped, rng.integers(-2, 2, len(points)), owner)
    walls = kernels.fitted(points, np.where(owner < 0, 0, owner))
    gate = rng.choice([0.0, 0.015])
    after, changed = kernels.give_to_nearest(points, owner, walls, gate)
    expected = reference_walls.give_to_nearest(
        points, owner, walls[:, :2], sharing.NEIGHBOURHOOD, gate
    )
    np.testing.assert_array_equal(after, expected)
    moved = expected != owner
    touched = {*owner[moved].tolist(), *expected[moved].tolist()}
    assert set(np.flatnonzero(changed)) == touched - {walls_table.FREE}


def test_free_points_beside_a_wall_join_it_if_they_are_near():
    points, truth = corner(np.random.default_rng(2))
    before = truth.copy()
    first = np.flatnonzero(truth == 1)[0]
    before[first : first + 3] = walls_table.FREE
    before[first + 10] = walls_table.FREE
    points = points.copy()
    points[first + 10] += (0.0, -0.1)  # no point of the wall
    table = kernels.fitted(points, before)
    owner, table = kernels.share_points(points, before, table, 4, gate=0.015)
    assert owner[first + 10] == walls_table.FREE
    assert (owner >= 0).sum() == len(points) - 1
    np.testing.assert_array_equal(table[:, 5], np.bincount(owner[owner >= 0]))


def test_all_walls_are_fitted_anew_when_asked():
    points, truth = corner(np.random.default_rng(3))
    rough = kernels.fitted(points, truth)
    rough[:, 0] += 1e-3
    owner, table = kernels.share_points(points, truth, rough, 4, refit=True)
    assert_fitted(table, points, owner)


@given(seeds)
def test_a_wall_that_ran_past_the_corner_gives_the_points_back(rng):
    points, truth = corner(rng)
    before = truth.copy()
    first = np.flatnonzero(truth == 1)[0]
    before[first : first + 4] = 0  # the first wall took four points of the second
    owner, walls = kernels.share_points(points, before, kernels.fitted(points, before), 4)
    normal = np.stack([np.cos(walls[:, 0]), np.sin(walls[:, 0])])
    # Only points within the noise of both walls may be on either.
    off = abs(points @ normal - walls[:, 1])
    assert (off[owner != truth] < 4 * SIGMA).all()
    np.testing.assert_array_equal(walls[:, 5], np.bincount(owner))
    assert_fitted(walls, points, owner)


def assert_fitted(walls, points, owner):
    """Check walls against fits from a theta of their own, which the weights hang on a little."""
    expected = kernels.fitted(points, owner)
    assert abs(line_errors(walls[:, :2], expected[:, :2])).max() < 1e-4
    np.testing.assert_allclose(walls[:, [2, 4, 5]], expected[:, [2, 4, 5]], rtol=0.02)


def test_points_of_settled_walls_stay_where_they_are():
    points, truth = corner(np.random.default_rng(1))
    settled, walls = kernels.share_points(points, truth, kernels.fitted(points, truth), 4)
    owner, again = kernels.share_points(points, settled, walls, 4)
    np.testing.assert_array_equal(owner, settled)
    np.testing.assert_array_equal(again, walls)


def test_a_wall_that_loses_its_points_is_left_with_none():
    scan = scan_of([(2, -1), (2, 1)], sigma=SIGMA)
    before = np.zeros(len(scan.points), np.int64)
    before[50:53] = 1
    walls = kernels.fitted(scan.points, before)
    walls[1, :2] = (0.5, 3.0)  # a line on which none of the points lies
    owner, walls = kernels.share_points(scan.points, before, walls, 4)
    assert (owner == 0).all()
    assert walls[:, 5].tolist() == [len(owner), 0]


def door(gap=0.8, shift=0.0, turn=0.0):
    """Return two walls beside a door, `shift` [m] behind one another, the second turned."""
    c, s = math.cos(turn), math.sin(turn)
    near = [(2, -gap / 2 - 1.5), (2, -gap / 2)]
    far = [(2 + shift, gap / 2), (2 + shift - 1.5 * s, gap / 2 + 1.5 * c)]
    scan, hit = look([near, far], sigma=SIGMA, beams=361)
    return scan.points, hit[scan.beams]


def test_pieces_beside_a_door_become_one_line():
    points, before = door()
    owner, walls = kernels.merge_pieces(points, before, SIGMA)
    assert (owner == 0).all()
    assert walls[:, 5].tolist() == [len(points), 0]
    assert abs(line_errors(walls[0, :2], (0.0, 2.0))).max() < 0.005
    assert_fitted(walls[:1], points, owner)


@pytest.mark.parametrize("scene", [{"shift": 0.08}, {"shift": -0.08}, {"turn": 0.2}])
def test_walls_on_different_lines_stay_apart(scene):
    points, before = door(**scene)
    owner, walls = kernels.merge_pieces(points, before, SIGMA)
    np.testing.assert_array_equal(owner, before)
    assert (walls[:, 5] > 0).all()


def piece(theta, d, along=0.0):
    """Return a well known wall whose points have their middle at `along` its line."""
    return (theta, d, 1e-4, along)


def test_walls_may_be_one_across_the_wrap_of_theta():
    a = piece(1e-3, 2.0)
    assert kernels.may_be_one(a, piece(math.pi - 1e-3, -2.0), SIGMA)
    assert not kernels.may_be_one(a, piece(math.pi - 1e-3, 2.0), SIGMA)


@given(seeds)
def test_walls_may_be_one_if_nearly_parallel_with_a_middle_near_the_other_line(rng):
    theta, d = rng.uniform(0, math.pi), rng.uniform(-3, 3)
    turn, shift, *along = rng.uniform((-0.1, -0.2, -2, -2), (0.1, 0.2, 2, 2))
    turns, other = divmod(theta + turn, math.pi)
    a = piece(theta, d, along[0])
    b = piece(other, (-1) ** turns * (d + shift), (-1) ** turns * along[1])
    middles = [p[1] * normal(p[0]) + p[3] * direction(p[0]) for p in (a, b)]
    off = [abs(middles[0] @ normal(b[0]) - b[1]), abs(middles[1] @ normal(a[0]) - a[1])]
    parallel = abs(turn) <= 4 * SIGMA * math.sqrt(2e-4) + 0.05
    assert kernels.may_be_one(a, b, SIGMA) == (parallel and min(off) < 0.1)
    assert kernels.may_be_one(b, a, SIGMA) == kernels.may_be_one(a, b, SIGMA)


def normal(theta):
    return np.array([math.cos(theta), math.sin(theta)])


def direction(theta):
    return np.array([-math.sin(theta), math.cos(theta)])
