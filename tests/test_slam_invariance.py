"""What no measurement can tell stays untold: a motion of the map's whole frame."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slam_reference import moved_frame

from laserfeatures import Pose2D
from laserfeatures.slam.invariance import carried_over
from laserfeatures.slam.kinds import CORNER, WALL
from laserfeatures.slam.state import State

TRUE_POSE = Pose2D(0.3, -0.2, 0.4)
HEADING = math.radians(20)  # how uncertain the map's heading is
SIGHTINGS = 200


@given(st.integers(0, 2**31), st.integers(0, 6))
def test_a_motion_of_the_frame_is_the_same_motion_after_a_correction(seed, landmarks):
    """As the numbers of the state before have it, carried over, and as those after have it."""
    rng = np.random.default_rng(seed)
    is_wall = rng.random(landmarks) < 0.5
    anchors = rng.normal(0.0, 5.0, (landmarks, 2))
    before = rng.normal(0.0, 3.0, 3 + 2 * landmarks)
    after = before + rng.normal(0.0, 0.5, before.size)
    motion, pivot = rng.normal(size=3), rng.normal(0.0, 5.0, 2)
    error = moved_frame(before, is_wall, anchors, pivot, motion)
    change = carried_over(before, after, is_wall, anchors)
    np.testing.assert_allclose(
        error + change @ error[:3], moved_frame(after, is_wall, anchors, pivot, motion), atol=1e-9
    )


def test_an_error_of_one_landmark_alone_is_left_as_it_is():
    change = carried_over(np.zeros(7), np.ones(7), np.array([False, True]), np.ones((2, 2)))
    assert change.shape == (7, 3)  # of the pose's errors only
    np.testing.assert_array_equal(change[2], 0.0)  # the heading's own


def plain(before, *_):
    return np.zeros((len(before), 3))


def standing(kind, carried):
    """Return the covariance of the pose before and after a robot that stands has looked long."""
    rng = np.random.default_rng(1)
    noise = np.diag([0.2**2, 0.2**2]) if kind is CORNER else np.diag([0.05**2, 0.2**2])
    true = {
        CORNER: [(3.0, 1.0), (2.0, -2.0), (-1.0, 3.0)],
        WALL: [(0.2, 3.0), (1.5, 2.0), (2.8, -4.0)],
    }[kind]
    state = State(TRUE_POSE)
    state.move(Pose2D(0.0, 0.0, 0.0), np.diag([0.5**2, 0.5**2, HEADING**2]))
    prior = state.covariance.copy()
    for measured in true:
        placed = kind.place(state.pose, np.array(measured) + rng.normal(0, np.sqrt(np.diag(noise))),
                            noise)  # fmt: skip
        state.add(placed.value, placed.by_pose, placed.noise)
    anchors = np.tile((TRUE_POSE.x, TRUE_POSE.y), (3, 1))
    is_wall = np.full(3, kind is WALL)
    for number in range(SIGHTINGS):
        i = number % 3
        expected = kind.expect(state.pose, state.positions[i : i + 1], anchors[i : i + 1])
        measured = np.array([true[i]]) + rng.normal(0, np.sqrt(np.diag(noise)))
        innovation, sign = kind.innovate(measured, expected.values)
        jacobian = np.concatenate([expected.by_pose[0], expected.by_landmark[0]], axis=1)
        jacobian[1] *= sign[0]
        state.correct(
            np.array([0, 1, 2, 3 + 2 * i, 4 + 2 * i]),
            jacobian,
            innovation[0],
            noise,
            lambda a, b: carried(a, b, is_wall, anchors),
        )
    return prior, state.covariance[:3, :3]


@pytest.mark.parametrize("kind", [CORNER, WALL], ids=["corners", "walls"])
def test_a_robot_that_stands_learns_nothing_of_where_the_frame_is(kind):
    prior, posterior = standing(kind, carried_over)
    assert posterior[2, 2] == pytest.approx(HEADING**2, rel=1e-6)
    assert np.linalg.eigvalsh(posterior - prior)[0] > -1e-6 * prior.max()


def test_a_plain_filter_would_think_that_it_does():
    """So that the test above is of something."""
    _, posterior = standing(CORNER, plain)
    assert posterior[2, 2] < 0.8 * HEADING**2
