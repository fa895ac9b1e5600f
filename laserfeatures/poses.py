"""Poses on poses."""

import math

from laserfeatures.scan import Pose2D


def compose(outer: Pose2D, inner: Pose2D) -> Pose2D:
    """Return, in the frame that `outer` is given in, a pose given in the frame of `outer`."""
    ((x, y),) = outer.transform((inner.x, inner.y)).tolist()
    return Pose2D(x, y, wrap(outer.theta + inner.theta))


def relative(outer: Pose2D, pose: Pose2D) -> Pose2D:
    """Return, in the frame of `outer`, a pose given in the frame that `outer` is given in."""
    turn = Pose2D(0.0, 0.0, -outer.theta)
    ((x, y),) = turn.transform((pose.x - outer.x, pose.y - outer.y)).tolist()
    return Pose2D(x, y, wrap(pose.theta - outer.theta))


def wrap(angle: float) -> float:
    """Return an angle [rad] in [-pi, pi]."""
    return math.remainder(angle, math.tau)
