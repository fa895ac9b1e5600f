"""Odometry: from one pose to the next, and how uncertain the step is."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.scan import Pose2D

LEAST = 1e-4  # [m] and [rad]; what a robot that stands may have moved unseen


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How wrong the odometry of a wheeled robot is: its variances grow with the way.

    A step of s metres and t radians has the variances ``way^2 s`` along, ``side^2 s`` across and
    ``turn_by_way^2 s + turn^2 t`` of its angle.
    The defaults are for a robot of which nothing is known.

    Parameters
    ----------
    way : float
        Deviation along, after 1 m [m].
    side : float
        Deviation across, after 1 m [m].
    turn_by_way : float
        Deviation of the angle, after 1 m [rad].
    turn : float
        Deviation of the angle, after 1 rad [rad].

    Raises
    ------
    ValueError
        If a deviation is negative or not finite.

    References
    ----------
    Chong and Kleeman, Accurate Odometry and Error Modelling for a Mobile Robot, ICRA 1997: wheels
    whose errors grow as their way does.
    """

    way: float = 0.2
    side: float = 0.1
    turn_by_way: float = 0.1
    turn: float = 0.2

    def __post_init__(self) -> None:
        """Check the deviations."""
        for name in ("way", "side", "turn_by_way", "turn"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be >= 0 and finite, got {getattr(self, name)}")

    def covariance(self, step: Pose2D) -> FloatArray:
        """Return the covariance (3, 3) of a step (x, y, theta) in the frame of the pose before."""
        length, angle = math.hypot(step.x, step.y), abs(step.theta)
        along = self.way**2 * length
        across = self.side**2 * length
        turned = self.turn_by_way**2 * length + self.turn**2 * angle
        heading = math.atan2(step.y, step.x) if length > LEAST else 0.0
        c, s = math.cos(heading), math.sin(heading)
        turn = np.array([[c, -s], [s, c]])
        covariance = np.diag([LEAST**2, LEAST**2, LEAST**2 + turned])
        covariance[:2, :2] += turn @ np.diag([along, across]) @ turn.T
        return covariance
