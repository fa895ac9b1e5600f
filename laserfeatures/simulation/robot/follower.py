"""The controller that takes the robot along its way-points."""

import math
from dataclasses import dataclass, field

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.poses import wrap

LOOK_AHEAD = 0.3  # [m]
REACHED = 0.05  # [m], left to a way-point where the next takes over
SHARP = math.radians(20)  # off by more than this it stops and turns on the spot
ALIGNED = math.radians(3)  # and drives on when off by less
TURN_GAIN = 2.5  # [1/s]
ACCELERATION = 0.5  # [m/s^2]
TURN_ACCELERATION = 3.0  # [rad/s^2]
CREEP = 0.08  # [m/s], at a sharp corner


@dataclass
class Follower:
    """Follows a polyline: pure pursuit on its legs, a turn on the spot where they bend sharply.

    Parameters
    ----------
    waypoints : (K, 2) array
        The polyline [m].
    speed : float
        On a straight [m/s].
    max_turn_rate : float
        The fastest turn [rad/s].

    References
    ----------
    Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992.
    """

    waypoints: FloatArray
    speed: float
    max_turn_rate: float
    target: int = field(default=1, init=False)
    left: float = field(default=math.inf, init=False)
    _turning: bool = field(default=False, init=False)
    _command: tuple[float, float] = field(default=(0.0, 0.0), init=False)

    @property
    def done(self) -> bool:
        """Whether the last way-point is reached."""
        return self.target == len(self.waypoints)

    def steer(self, pose: Pose2D, seconds: float) -> tuple[float, float]:
        """Return the speed [m/s] and turn rate [rad/s] to hold from `pose` on for some seconds.

        It sets `target`, the way-point ahead, and `left`, a measure of what is left to do until it
        is reached: metres and radians added up.
        """
        to_go = self._distance(pose)
        while to_go < REACHED:
            self.target += 1
            if self.done:
                return 0.0, 0.0
            to_go = self._distance(pose)
        off = self._bearing(pose, to_go)
        self.left = to_go + abs(off)
        self._turning = abs(off) > (ALIGNED if self._turning else SHARP)
        if self._turning:
            wanted = (0.0, TURN_GAIN * off)
        else:
            brake = math.sqrt(CREEP**2 + 2 * ACCELERATION * (to_go - REACHED))
            speed = min(self.speed, brake) if self._sharp_ahead() else self.speed
            wanted = (speed, 2 * speed * math.sin(off) / LOOK_AHEAD)
        turn = min(max(wanted[1], -self.max_turn_rate), self.max_turn_rate)
        self._command = (
            _towards(self._command[0], wanted[0], ACCELERATION * seconds),
            _towards(self._command[1], turn, TURN_ACCELERATION * seconds),
        )
        return self._command

    def _leg(self, target: int) -> tuple[float, float, float, float]:
        """Return a leg's end [m] and direction (a unit vector)."""
        (ax, ay), (bx, by) = self.waypoints[target - 1 : target + 1].tolist()
        length = math.hypot(bx - ax, by - ay)
        return bx, by, (bx - ax) / length, (by - ay) / length

    def _distance(self, pose: Pose2D) -> float:
        """Return how far along the leg its end still is [m]."""
        x, y, along_x, along_y = self._leg(self.target)
        return (x - pose.x) * along_x + (y - pose.y) * along_y

    def _bearing(self, pose: Pose2D, to_go: float) -> float:
        """Return the angle [rad] to the point of the leg's line a little ahead."""
        x, y, along_x, along_y = self._leg(self.target)
        ahead = LOOK_AHEAD - to_go
        dx, dy = x + ahead * along_x - pose.x, y + ahead * along_y - pose.y
        return wrap(math.atan2(dy, dx) - pose.theta)

    def _sharp_ahead(self) -> bool:
        """Return whether the way ends at the next way-point, or bends sharply."""
        if self.target + 1 == len(self.waypoints):
            return True
        _, _, ax, ay = self._leg(self.target)
        _, _, bx, by = self._leg(self.target + 1)
        return ax * bx + ay * by < math.cos(SHARP)


def _towards(now: float, wanted: float, most: float) -> float:
    return now + min(max(wanted - now, -most), most)
