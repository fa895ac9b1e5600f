"""The step between two scans, where odometry is wrong."""

import math

import numpy as np
import pytest
from scenes import chain, look, needs_compiler, wall

from laserfeatures import Pose2D
from laserfeatures.poses import compose, relative
from laserfeatures.simulation import World
from laserfeatures.slam.registration import register

ROOM = World(
    walls=World.outline([(0, 0), (7, 0), (7, 5), (3, 5), (3, 4), (0, 4)]).walls,
    boxes=[(5.5, 1.0, 1.2, 0.6, 0.4), (1.0, 3.2, 0.8, 0.5, 0.0)],
    poles=[(4.0, 3.5, 0.15)],
)
START = Pose2D(2.0, 1.8, 0.3)
CORRIDOR = [wall(math.pi / 2, side, -60.0, 60.0) for side in (-1.0, 1.0)]
VAGUE = np.diag([0.3**2, 0.3**2, 0.35**2])
NOISE = 0.005


def step_between(world, pose, step, *, wrong, covariance=VAGUE, beams=361):
    """Return the registered step, its covariance, and its error."""
    view = {"sigma": NOISE, "beams": beams, "view": math.radians(270)}
    before, _ = look(world, pose=pose, seed=1, **view)
    after, _ = look(world, pose=compose(pose, step), seed=2, **view)
    odometry = Pose2D(step.x + wrong[0], step.y + wrong[1], step.theta + wrong[2])
    found, after_covariance = register(before.points, after.points, odometry, covariance)
    off = relative(step, found)
    return found, after_covariance, np.array([off.x, off.y, off.theta])


@pytest.mark.parametrize(
    "wrong",
    [
        (0.0, 0.0, 0.0),
        (0.3, 0.0, math.radians(20)),
        (-0.2, 0.22, -math.radians(20)),
        (0.0, -0.3, math.radians(10)),
    ],
)
@pytest.mark.parametrize("step", [Pose2D(0.2, 0.0, 0.1), Pose2D(0.6, 0.1, -0.7)])
@needs_compiler
def test_a_step_in_a_furnished_room_is_found_again(step, wrong):
    _, covariance, off = step_between(ROOM, START, step, wrong=wrong)
    assert math.hypot(*off[:2]) < 0.02
    assert abs(off[2]) < math.radians(0.4)
    deviations = np.sqrt(np.diag(covariance))
    assert deviations[:2].max() < 0.03
    assert deviations[2] < math.radians(1)
    np.testing.assert_allclose(covariance, covariance.T, atol=1e-15)
    assert off @ np.linalg.inv(covariance) @ off < 20  # 16.3 is 0.999 of chi-square


@pytest.mark.parametrize("far", [1e5, 1e300])
@needs_compiler
def test_a_return_from_very_far_needs_no_memory_and_changes_nothing(far):
    view = {"sigma": NOISE, "view": math.radians(270)}
    before, _ = look(ROOM, pose=START, seed=1, **view)
    after, _ = look(ROOM, pose=compose(START, Pose2D(0.2, 0.0, 0.1)), seed=2, **view)

    def with_far(points):
        return np.concatenate([points, [(far, -far)]])

    odometry = Pose2D(0.4, 0.1, 0.2)
    found, covariance = register(with_far(before.points), with_far(after.points), odometry, VAGUE)
    expected, certainty = register(before.points, after.points, odometry, VAGUE)
    assert found == expected
    np.testing.assert_array_equal(covariance, certainty)


def test_along_a_corridor_the_odometry_is_all_there_is():
    covariance = np.diag([0.2**2, 0.2**2, 0.05**2])
    heading = 0.3
    _, found, off = step_between(
        CORRIDOR,
        Pose2D(0.0, 0.2, heading),
        Pose2D(0.3, 0.0, 0.05),
        wrong=(0.1, -0.05, 0.04),
        covariance=covariance,
        beams=121,
    )
    c, s = math.cos(heading), math.sin(heading)
    along, across = np.array([c, -s]), np.array([s, c])  # of the corridor, in the first scan
    as_odometry = (along @ found[:2, :2] @ along) / (along @ covariance[:2, :2] @ along)
    assert 0.9 < as_odometry < 4  # the points tell nothing; that others fit as well may widen it
    assert across @ found[:2, :2] @ across < 0.03**2
    # Odometry is off by some 10 cm there; of that, what is along the corridor stays.
    turn = 0.05
    in_first = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    error = in_first @ off[:2]
    assert abs(across @ error) < 0.02
    assert abs(off[2]) < math.radians(0.5)
    assert along @ error == pytest.approx(along @ (0.1, -0.05), abs=0.05)


@pytest.mark.parametrize(("first", "second"), [(3, 100), (100, 3), (0, 100), (100, 0), (0, 0)])
def test_with_too_few_points_odometry_is_left_as_it_is(first, second):
    scan, _ = look(ROOM, pose=START, beams=101)
    step = Pose2D(0.1, 0.2, 0.3)
    before, after = scan.points[:first], scan.points[:second]
    assert register(before, after, step, VAGUE) == (step, VAGUE)


def test_without_a_flat_surface_odometry_is_left_as_it_is():
    rng = np.random.default_rng(1)
    before, after = rng.uniform(-5, 5, (2, 60, 2))
    step = Pose2D(0.1, 0.2, 0.3)
    assert register(before, after, step, VAGUE) == (step, VAGUE)


@needs_compiler
def test_odometry_that_is_certain_is_believed():
    """One wall moved by 5 cm: odometry that knows better than 1 mm is not talked out of it."""
    walls = chain((3.0, -3.0), (3.0, 3.0))
    view = {"sigma": NOISE, "beams": 181}
    before, _ = look(walls, seed=1, **view)
    after, _ = look(chain((2.95, -3.0), (2.95, 3.0)), seed=2, **view)
    here = Pose2D(0.0, 0.0, 0.0)
    sure, _ = register(before.points, after.points, here, np.diag([1e-8, 1e-8, 1e-8]))
    vague, _ = register(before.points, after.points, here, VAGUE)
    assert abs(sure.x) < 0.002
    assert vague.x == pytest.approx(0.05, abs=0.01)
