"""The two kinds of landmarks: how they are seen from a pose, and where they are if they are seen.

Both are measured as the extractor gives them, in the sensor's frame: a corner as (x, y), a wall as
(theta, d). A corner's x and y there depend linearly on its position and the pose's, but for the
heading; its range and bearing would not.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.scan import Pose2D


@dataclass(frozen=True, eq=False)
class Expected:
    """What would be measured of some landmarks, and how it depends on pose and landmark.

    Parameters
    ----------
    values : (L, 2) array
        The measurements.
    by_pose : (L, 2, 3) array
        Their derivatives by the pose.
    by_landmark : (L, 2, 2) array
        Their derivatives by the landmark's numbers.
    """

    values: FloatArray
    by_pose: FloatArray
    by_landmark: FloatArray


@dataclass(frozen=True, eq=False)
class Placed:
    """A landmark where it was seen, and how that depends on the pose; its covariance besides."""

    value: FloatArray
    by_pose: FloatArray
    noise: FloatArray


@dataclass(frozen=True)
class Kind:
    """A kind of landmarks.

    Parameters
    ----------
    name : str
        Corner or wall.
    expect : callable
        From pose, numbers (L, 2) and anchors (L, 2) to `Expected`.
    innovate : callable
        From what was measured (N, 2) and what was expected (N, 2) to the innovations (N, 2), and
        the sign (N,) of the second number of what was expected.
    place : callable
        From pose, measurement (2,) and its covariance to `Placed`; the anchor is the pose.
    """

    name: str
    expect: Callable[[Pose2D, FloatArray, FloatArray], Expected]
    innovate: Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]
    place: Callable[[Pose2D, FloatArray, FloatArray], Placed]


def _rotation(theta: float) -> FloatArray:
    c, s = math.cos(theta), math.sin(theta)
    return np.array([[c, -s], [s, c]])


def _expect_corners(pose: Pose2D, positions: FloatArray, _: FloatArray) -> Expected:
    back = _rotation(pose.theta).T
    values = (positions - (pose.x, pose.y)) @ back.T
    count = len(positions)
    by_pose = np.empty((count, 2, 3))
    by_pose[:, :, :2] = -back
    by_pose[:, 0, 2], by_pose[:, 1, 2] = values[:, 1], -values[:, 0]
    return Expected(values, by_pose, np.broadcast_to(back, (count, 2, 2)))


def _innovate_corners(measured: FloatArray, expected: FloatArray) -> tuple[FloatArray, FloatArray]:
    return measured - expected, np.ones(len(measured))


def _place_corner(pose: Pose2D, measured: FloatArray, noise: FloatArray) -> Placed:
    turn = _rotation(pose.theta)
    x, y = turn @ measured
    by_pose = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
    return Placed(np.array([pose.x + x, pose.y + y]), by_pose, turn @ noise @ turn.T)


def _expect_walls(pose: Pose2D, walls: FloatArray, anchors: FloatArray) -> Expected:
    alpha, rho = walls.T
    normal = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
    away = (pose.x, pose.y) - anchors
    values = np.stack([alpha - pose.theta, rho - (normal * away).sum(axis=1)], axis=1)
    by_pose = np.zeros((len(walls), 2, 3))
    by_pose[:, 0, 2] = -1.0
    by_pose[:, 1, :2] = -normal
    by_landmark = np.zeros((len(walls), 2, 2))
    by_landmark[:, 0, 0] = by_landmark[:, 1, 1] = 1.0
    by_landmark[:, 1, 0] = normal[:, 1] * away[:, 0] - normal[:, 0] * away[:, 1]
    return Expected(values, by_pose, by_landmark)


def _innovate_walls(measured: FloatArray, expected: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Compare lines that are the same for (theta, d) and (theta + pi, -d)."""
    halves = np.rint((measured[:, 0] - expected[:, 0]) / math.pi)
    sign = 1.0 - 2.0 * (halves % 2)
    angle = measured[:, 0] - expected[:, 0] - math.pi * halves
    return np.stack([angle, measured[:, 1] - sign * expected[:, 1]], axis=1), sign


def _place_wall(pose: Pose2D, measured: FloatArray, noise: FloatArray) -> Placed:
    alpha = measured[0] + pose.theta
    by_pose = np.array([[0.0, 0.0, 1.0], [math.cos(alpha), math.sin(alpha), 0.0]])
    return Placed(np.array([alpha, measured[1]]), by_pose, noise)


CORNER = Kind("corner", _expect_corners, _innovate_corners, _place_corner)
WALL = Kind("wall", _expect_walls, _innovate_walls, _place_wall)
"""A wall's numbers are alpha and rho = n(alpha) (x - anchor): counted from a point near by, and not
from the map's origin, its two numbers hardly depend on each other."""
