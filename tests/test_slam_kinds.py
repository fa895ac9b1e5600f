"""Corners and walls: what is expected of them, its derivatives, and where they are put."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import line_errors, normalised, true_lines

from laserfeatures import Pose2D
from laserfeatures.slam.kinds import CORNER, WALL

STEP = 1e-6
metres = st.floats(-20.0, 20.0)
angles = st.floats(-math.pi, math.pi)
poses = st.builds(Pose2D, metres, metres, angles)
kinds = st.sampled_from([CORNER, WALL])
ANCHOR = np.array([[1.5, -2.5]])


def expected(kind, numbers):
    """Return what is measured from a pose of a landmark, given as five numbers."""
    return kind.expect(Pose2D(*numbers[:3]), np.array([numbers[3:]]), ANCHOR).values[0]


def differences(function, numbers):
    """Return the derivatives of a function by finite differences."""
    steps = STEP * np.eye(len(numbers))
    return np.stack(
        [(function(numbers + s) - function(numbers - s)) / (2 * STEP) for s in steps], axis=1
    )


@given(kinds, poses, metres, metres)
def test_the_derivatives_are_those_of_the_expected_measurement(kind, pose, first, second):
    numbers = np.array([pose.x, pose.y, pose.theta, first, second])
    found = kind.expect(pose, numbers[None, 3:], ANCHOR)
    numeric = differences(lambda n: expected(kind, n), numbers)
    np.testing.assert_allclose(found.by_pose[0], numeric[:, :3], atol=1e-6)
    np.testing.assert_allclose(found.by_landmark[0], numeric[:, 3:], atol=1e-6)


@given(kinds, poses, angles, metres)
def test_a_landmark_is_put_where_it_would_be_measured_so(kind, pose, first, second):
    measured, noise = np.array([first, second]), np.array([[0.02, 0.005], [0.005, 0.01]])
    placed = kind.place(pose, measured, noise)
    anchors = np.array([(pose.x, pose.y)])
    back = kind.expect(pose, placed.value[None], anchors)
    np.testing.assert_allclose(back.values[0], measured, atol=1e-9)
    # Put there, it has the covariance that measuring it there again would have.
    by_landmark = back.by_landmark[0]
    np.testing.assert_allclose(by_landmark @ placed.noise @ by_landmark.T, noise, atol=1e-12)
    # As the pose moves, the landmark moves so that the measurement stays what it is.
    np.testing.assert_allclose(back.by_pose[0] + by_landmark @ placed.by_pose, 0.0, atol=1e-9)


@given(poses, poses, st.floats(0, math.pi - 1e-6), metres)
def test_a_wall_is_expected_where_the_true_wall_is(first, pose, theta, d):
    """Seen from one pose and put into the map, it is expected from another as geometry has it."""
    ends = first.transform(np.array([(d * math.cos(theta) - t * math.sin(theta),
                                      d * math.sin(theta) + t * math.cos(theta))
                                     for t in (-1.0, 2.0)]))  # fmt: skip
    placed = WALL.place(first, np.array([theta, d]), np.eye(2))
    values = WALL.expect(pose, placed.value[None], np.array([(first.x, first.y)])).values
    error = line_errors(normalised(*values.T), true_lines(ends[None], pose))
    np.testing.assert_allclose(error, 0.0, atol=1e-7)


@given(poses, metres, metres)
def test_a_corner_is_expected_where_it_is(pose, x, y):
    values = CORNER.expect(pose, np.array([(x, y)]), ANCHOR).values
    np.testing.assert_allclose(pose.transform(values), [(x, y)], atol=1e-9)


@given(angles, st.floats(0.1, 20.0), st.integers(-3, 3))
def test_a_wall_told_the_other_way_round_is_the_same(theta, d, halves):
    other = np.array([[theta + halves * math.pi, d if halves % 2 == 0 else -d]])
    expected_d = np.array([[theta + 0.01, d + 0.02]])
    innovation, sign = WALL.innovate(other, expected_d)
    turned = 1.0 if halves % 2 == 0 else -1.0
    np.testing.assert_allclose(sign, turned)
    np.testing.assert_allclose(innovation, [[-0.01, -0.02 * turned]], atol=1e-9)


@pytest.mark.parametrize("theta", [1e-3, math.pi - 1e-3])
def test_a_wall_near_the_end_of_the_angles_is_not_half_a_turn_off(theta):
    measured = np.array([[theta, 2.0]])
    expected_wall = normalised([theta + 0.01], [2.0])  # may have gone over pi, and changed sign
    innovation, sign = WALL.innovate(measured, expected_wall)
    assert innovation[0, 0] == pytest.approx(-0.01)
    assert abs(innovation[0, 1]) < 1e-9
    assert sign[0] == np.sign(expected_wall[0, 1])


def test_corners_are_compared_by_subtraction():
    innovation, sign = CORNER.innovate(np.array([[1.0, 2.0]]), np.array([[0.5, 2.5]]))
    np.testing.assert_array_equal(innovation, [[0.5, -0.5]])
    np.testing.assert_array_equal(sign, [1.0])
