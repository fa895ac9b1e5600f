"""Wheel odometry: from encoder ticks to a pose."""

import math
from dataclasses import dataclass

from laserfeatures.data import Pose2D
from laserfeatures.poses import compose
from laserfeatures.simulation.robot.platform import Robot
from laserfeatures.wheels import arc

Ticks = tuple[int, int]


def encoder_ticks(robot: Robot, angles: tuple[float, float]) -> Ticks:
    """Return what the encoders have counted when both wheels have turned by `angles` [rad]."""
    left, right = (math.floor(angle / math.tau * robot.ticks_per_turn) for angle in angles)
    return left, right


@dataclass
class Odometry:
    """A pose that is carried on by ticks alone.

    Parameters
    ----------
    robot : Robot
        Whose wheels they are; `wheel_radius` and `track` are taken for true.
    pose : Pose2D
        Where it starts, and then where it has come to.
    ticks : (int, int)
        The count that was integrated up to.
    """

    robot: Robot
    pose: Pose2D
    ticks: Ticks = (0, 0)

    def update(self, ticks: Ticks) -> None:
        """Go on to a new count of the left and right encoder.

        The wheels are taken to have turned evenly in between, so that the way is an arc.
        """
        a_tick = math.tau * self.robot.wheel_radius / self.robot.ticks_per_turn
        left, right = ((now - then) * a_tick for now, then in zip(ticks, self.ticks, strict=True))
        self.pose = compose(self.pose, arc(left, right, self.robot.track))
        self.ticks = ticks
