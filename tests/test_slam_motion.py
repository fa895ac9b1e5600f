"""Odometry's noise grows with the way and with the turn, and nothing else."""

import math

import numpy as np
import pytest

from laserfeatures import Pose2D
from laserfeatures.slam import Motion
from laserfeatures.slam.motion import LEAST

MOTION = Motion(way=0.1, side=0.03, turn_by_way=0.02, turn=0.05)


def deviations(x, y, theta):
    return np.sqrt(np.diag(MOTION.covariance(Pose2D(x, y, theta))))


def test_the_variances_are_those_of_the_docstring():
    np.testing.assert_allclose(deviations(4.0, 0.0, 0.0), [0.1 * 2, 0.03 * 2, 0.02 * 2], rtol=1e-4)
    np.testing.assert_allclose(deviations(0.0, 0.0, -2.0)[2], 0.05 * math.sqrt(2), rtol=1e-4)
    np.testing.assert_allclose(
        deviations(1.0, 0.0, 2.0)[2], math.hypot(0.02, 0.05 * math.sqrt(2)), rtol=1e-4
    )


def test_two_halves_of_a_straight_way_are_as_uncertain_as_the_whole():
    half, whole = (MOTION.covariance(Pose2D(way, 0.0, 0.0)) for way in (1.0, 2.0))
    np.testing.assert_allclose(2 * half[:2, :2], whole[:2, :2], rtol=1e-3)


@pytest.mark.parametrize("heading", [0.3, math.pi / 2, 2.5, -3.0])
def test_along_and_across_turn_with_the_way(heading):
    c, s = math.cos(heading), math.sin(heading)
    covariance = MOTION.covariance(Pose2D(2 * c, 2 * s, 0.1))
    along, across = np.array([c, s]), np.array([-s, c])
    assert along @ covariance[:2, :2] @ along == pytest.approx(2 * 0.1**2, rel=1e-4)
    assert across @ covariance[:2, :2] @ across == pytest.approx(2 * 0.03**2, rel=1e-3)
    assert along @ covariance[:2, :2] @ across == pytest.approx(0.0, abs=1e-12)


def test_a_robot_that_stands_may_have_moved_a_little():
    covariance = MOTION.covariance(Pose2D(0.0, 0.0, 0.0))
    np.testing.assert_allclose(covariance, LEAST**2 * np.eye(3))
    assert np.linalg.eigvalsh(Motion(way=0, side=0, turn_by_way=0, turn=0).covariance(
        Pose2D(1.0, 2.0, 3.0)
    ))[0] > 0  # fmt: skip


@pytest.mark.parametrize("name", ["way", "side", "turn_by_way", "turn"])
@pytest.mark.parametrize("value", [-0.01, math.inf, math.nan])
def test_a_deviation_that_makes_no_sense_is_refused(name, value):
    with pytest.raises(ValueError, match=f"^{name} must be >= 0 and finite, got {value}"):
        Motion(**{name: value})
