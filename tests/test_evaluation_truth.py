"""What is true of a scan: lines that four beams measure, and the corners where they cross."""

import math

import numpy as np
import pytest
import reference_evaluation as twins
from hypothesis import given
from hypothesis import strategies as st
from scenes import ORIGIN, chain, line_errors

from laserfeatures import LaserScan, Pose2D
from laserfeatures.evaluation import Truth, truth_of
from laserfeatures.simulation import Observation, Scanner, World, hallway

seeds = st.integers(0, 10**6).map(np.random.default_rng)
EXACT = Scanner(beams=721, field_of_view=2 * math.pi - 0.01, range_max=50.0, range_sigma=0.0)
L_CORNER = [[(2, -2), (2, 2)], [(2, 2), (-2, 2)]]


def observed(world, surface, pose=ORIGIN):
    """Return the observation of a world of which only the beams' surfaces matter."""
    scan = LaserScan.uniform(np.ones(len(surface)), -1.0, 0.01)
    return Observation(scan=scan, world=world, pose=pose, surface=surface)


def truth_by_beams(world, surface, pose=ORIGIN):
    return truth_of(observed(world, surface, pose))


def look(world, pose=ORIGIN, scanner=EXACT):
    return scanner.observe(world, pose, np.random.default_rng(0))


def four_each(walls):
    return truth_by_beams(World(walls=walls), np.repeat(np.arange(len(walls)), 4))


def random_world(rng):
    """Return walls between points of a grid, many of which meet or are in line, boxes and poles."""
    walls = rng.integers(-4, 5, (rng.integers(0, 8), 2, 2)).astype(float)
    walls = walls[(walls[:, 0] != walls[:, 1]).any(axis=1)]
    boxes = rng.uniform((-4, -4, 0.2, 0.2, -4), (4, 4, 2, 2, 4), (rng.integers(0, 3), 5))
    boxes[:, 4] = rng.choice([0.0, math.pi / 2, 0.3], len(boxes))
    return World(walls=walls, boxes=boxes, poles=rng.uniform(0.1, 1, (rng.integers(0, 3), 3)))


def random_pose(rng):
    return Pose2D(*rng.uniform(-15, 15, 2), rng.uniform(-9, 9))


@given(seeds)
def test_truth_is_that_of_the_slow_twin(rng):
    world, pose = random_world(rng), random_pose(rng)
    surfaces = len(world.sides) + len(world.poles)
    surface = rng.integers(-1, surfaces, rng.integers(0, 60)) if surfaces else np.full(9, -1)
    truth = truth_by_beams(world, surface, pose)
    line, pairs, corners, real = twins.truth(world.sides, surface, pose)
    assert truth.line.tolist() == line
    assert truth.pairs.tolist() == [list(pair) for pair in pairs]
    np.testing.assert_allclose(
        pose.transform(truth.corners), np.reshape(corners, (-1, 2)), atol=1e-9
    )
    assert truth.real.tolist() == real


@given(seeds)
def test_every_beam_of_a_true_line_lies_on_it_and_every_corner_on_both_of_its(rng):
    world, poses = hallway()
    turned = Pose2D(*rng.uniform((0.5, 0.5), (9.0, 1.5)), rng.uniform(-9, 9))
    seen = look(world, rng.choice([turned, poses[-1]]))
    truth = truth_of(seen)
    assert truth.theta.size > 3
    assert len(truth.corners) > 3
    normals = np.stack([np.cos(truth.theta), np.sin(truth.theta)], axis=1)
    points = (seen.scan.ranges[:, None] * seen.scan.directions)[truth.line >= 0]
    on = truth.line[truth.line >= 0]
    np.testing.assert_allclose((points * normals[on]).sum(axis=1), truth.d[on], atol=1e-9)
    for end in truth.pairs.T:
        off = (truth.corners * normals[end]).sum(axis=1) - truth.d[end]
        np.testing.assert_allclose(off, 0, atol=1e-9)


@given(seeds)
def test_turning_the_world_and_the_pose_together_changes_nothing(rng):
    world, pose, move = random_world(rng), random_pose(rng), random_pose(rng)
    moved = World(
        walls=move.transform(world.walls).reshape(-1, 2, 2),
        boxes=np.c_[move.transform(world.boxes[:, :2]), world.boxes[:, 2:] + (0, 0, move.theta)],
        poles=np.c_[move.transform(world.poles[:, :2]), world.poles[:, 2:]],
    )
    there = Pose2D(*move.transform([(pose.x, pose.y)])[0], pose.theta + move.theta)
    surface = np.arange(len(world.sides) + len(world.poles)).repeat(4)
    before = truth_by_beams(world, surface, pose)
    after = truth_by_beams(moved, surface, there)
    errors = line_errors(
        np.stack([after.theta, after.d], axis=1), np.stack([before.theta, before.d], axis=1)
    )
    np.testing.assert_allclose(errors, 0, atol=1e-9)
    np.testing.assert_allclose(after.corners, before.corners, atol=1e-8)
    for name in ("line", "pairs", "real"):
        assert getattr(after, name).tolist() == getattr(before, name).tolist()


def test_truth_is_in_the_sensors_frame():
    # From (1, 2), facing up, the wall x = 3 is to the right, the wall y = 6 ahead.
    world = World(walls=[[(3, 0), (3, 6)], [(3, 6), (-3, 6)]])
    truth = truth_by_beams(world, [0] * 4 + [1] * 4, Pose2D(1, 2, math.pi / 2))
    np.testing.assert_allclose(truth.theta, [math.pi / 2, 0], atol=1e-12)
    np.testing.assert_allclose(truth.d, [-2, 4])
    np.testing.assert_allclose(truth.corners, [(4, -2)])
    assert truth.pairs.tolist() == [[0, 1]]


def test_both_sides_of_a_box_in_view_are_lines_that_meet():
    world = World(boxes=[(3, 0, 1, 1, math.pi / 4)])
    truth = truth_of(look(world))
    assert truth.theta.size == 2
    np.testing.assert_allclose(truth.corners, [(3 - math.sqrt(0.5), 0)], atol=1e-12)
    assert truth.real.tolist() == [True]
    # The sides are numbered behind the walls.
    truth = truth_of(look(World(walls=[[(0, -9), (1, -9)]], boxes=world.boxes)))
    assert truth.theta.size == 3
    np.testing.assert_allclose(truth.corners[-1], (3 - math.sqrt(0.5), 0), atol=1e-12)
    assert truth.real.tolist() == [False, False, True]


def test_the_pieces_of_a_wall_on_both_sides_of_a_niche_are_one_line():
    world = World(walls=chain((2, -3), (2, -0.5), (2.5, -0.5), (2.5, 0.5), (2, 0.5), (2, 3)))
    seen = look(world)
    truth = truth_of(seen)
    assert truth.theta.size == 4
    assert set(truth.line[np.isin(seen.surface, [0, 4])]) == {0}
    assert sorted(map(tuple, truth.corners.round(9).tolist())) == [
        (2, -0.5), (2, 0.5), (2.5, -0.5), (2.5, 0.5)
    ]  # fmt: skip
    assert truth.real.all()


@pytest.mark.parametrize(
    ("surface", "lines"),
    [
        ([0] * 4, 1),
        ([0] * 3, 0),
        ([0, 0, 1, 1], 1),  # both on one line
        ([0, 0, 2, 2], 0),
        ([0, 1, 0, 2, 2, 1, 2, 2], 2),
        ([0, -1, 0, -1, 0, -1], 0),  # three that measure it, three that show nothing true
    ],
)
def test_a_true_line_has_four_beams_at_least(surface, lines):
    world = World(walls=[[(2, 0), (2, 1)], [(2, 2), (2, 3)], [(2, 3), (0, 3)]])
    truth = truth_by_beams(world, surface)
    assert truth.theta.size == lines
    assert truth.line.max() == lines - 1
    if not lines:
        assert (truth.line == -1).all()


def test_poles_have_no_lines():
    world = World(walls=L_CORNER, poles=[(1, 0, 0.3), (0, -1, 0.3)])
    seen = look(world)
    assert {2, 3} <= set(seen.surface)
    truth = truth_of(seen)
    assert truth.theta.size == 2
    assert (truth.line[seen.surface >= 2] == -1).all()
    assert (truth.line[(seen.surface >= 0) & (seen.surface < 2)] >= 0).all()


def test_a_beam_that_shows_no_surface_is_on_no_line():
    surface = np.array([0] * 5 + [-1] + [1] * 5)
    truth = truth_by_beams(World(walls=L_CORNER), surface)
    assert truth.line.tolist() == surface.tolist()


@pytest.mark.parametrize(
    ("short", "real"), [(0.0, True), (0.0005, True), (0.002, False), (0.5, False), (-0.5, True)]
)
def test_a_corner_is_real_where_walls_meet_and_virtual_where_one_ends_short(short, real):
    truth = four_each([[(2, -2), (2, 2 - short)], [(2, 2), (-2, 2)]])
    np.testing.assert_allclose(truth.corners, [(2, 2)])
    assert truth.real.tolist() == [real]
    turned = four_each([[(2, 2), (-2, 2)], [(2, 2 - short), (2, -2)]])
    assert turned.real.tolist() == [real]


@pytest.mark.parametrize(("start", "real"), [(2.0, True), (1.9, True), (2.1, False)])
def test_a_wall_that_ends_on_anothers_middle_makes_a_real_corner(start, real):
    truth = four_each([[(2, -2), (2, 2)], [(start, 0.5), (5, 0.5)]])
    np.testing.assert_allclose(truth.corners, [(2, 0.5)])
    assert truth.real.tolist() == [real]


@pytest.mark.parametrize(("beams_near", "real"), [(0, False), (1, True)])
def test_a_corner_is_virtual_if_no_beam_measures_the_piece_that_reaches_it(beams_near, real):
    world = World(walls=[[(2, -2), (2, 0)], [(2, 1), (2, 2)], [(2, 2), (-2, 2)]])
    truth = truth_by_beams(world, [0] * 4 + [1] * beams_near + [2] * 4)
    np.testing.assert_allclose(truth.corners, [(2, 2)])
    assert truth.real.tolist() == [real]


def test_a_real_corner_that_a_box_hides_stays_real():
    world = World(walls=L_CORNER, boxes=[(1.2, 1.2, 0.5, 0.5, math.pi / 4)])
    seen = look(world)
    straight = np.argmin(abs(seen.scan.angles - math.pi / 4))
    assert seen.surface[straight] >= 2  # the box, not the corner
    truth = truth_of(seen)
    at = np.hypot(*(truth.corners - (2, 2)).T).argmin()
    np.testing.assert_allclose(truth.corners[at], (2, 2))
    assert truth.real[at]


def test_crossings_of_walls_count_from_the_sensor_not_from_the_worlds_origin():
    far = World(walls=np.add(L_CORNER, (100, 0)))
    surface = [0] * 4 + [1] * 4
    assert len(truth_by_beams(far, surface).corners) == 0
    assert len(truth_by_beams(far, surface, Pose2D(83, 0, 0)).corners) == 1
    assert len(truth_by_beams(far, surface, Pose2D(82, 0, 0)).corners) == 0  # 20.1 m


@pytest.mark.parametrize("world", [World(), World(poles=[(3, 0, 1)]), World(walls=L_CORNER)])
def test_where_no_wall_is_measured_nothing_is_true(world):
    for surface in (np.full(5, -1), np.full(5, -1)[:0]):
        truth = truth_by_beams(world, surface)
        assert truth.theta.size == len(truth.corners) == 0
        assert truth.line.tolist() == [-1] * len(surface)
        assert (truth.corners.shape, truth.pairs.shape) == ((0, 2), (0, 2))
    assert truth.lines_known


def test_of_corners_alone_no_lines_are_known():
    scan = LaserScan.uniform([1.0, 2.0, 3.0], 0.0, 0.1)
    truth = Truth.of_corners(scan, [(1, 2), (3, 4)], [True, False])
    assert truth.corners.tolist() == [[1, 2], [3, 4]]
    assert truth.real.tolist() == [True, False]
    assert truth.line.tolist() == [-1, -1, -1]
    assert truth.pairs.tolist() == [[-1, -1], [-1, -1]]
    assert not truth.lines_known
    assert not truth.corners.flags.writeable


@pytest.mark.parametrize(
    ("corners", "real", "message"),
    [
        ([1.0, 2.0], [True], r"corners must have shape \(n, 2\), got \(2,\)"),
        ([(1, 2)], [True, True], r"real must have shape \(1\), got \(2,\)"),
    ],
)
def test_corners_of_another_shape_are_refused(corners, real, message):
    with pytest.raises(ValueError, match=message):
        Truth.of_corners(LaserScan.uniform([1.0], 0.0, 0.1), corners, real)
