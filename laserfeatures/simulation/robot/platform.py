"""What the robot is like, and what its odometry takes it for."""

import math
from dataclasses import dataclass

from laserfeatures.data import Pose2D

LASER = Pose2D(0.06, 0.0, 0.0)  # above the front half of the chassis


@dataclass(frozen=True, kw_only=True)
class Robot:
    """A platform with two driven wheels and a caster behind, of the size of an AmigoBot.

    Its origin is the middle of the axle, on the floor; x points forward. `wheel_radius` and `track`
    are what its odometry reckons with. The wheels that a drive is made with differ from them by
    errors drawn from its seed, and so does the floor under each wheel, patch by patch.

    Parameters
    ----------
    mass : float
        Of all of it [kg].
    wheel_radius : float
        Of the driven wheels [m].
    track : float
        From the middle of one driven wheel to that of the other [m].
    ticks_per_turn : int
        What an encoder counts in a turn of its wheel.
    max_torque : float
        The most that a motor gives, at the wheel [N m].
    max_speed : float
        The fastest that it may drive [m/s].
    max_turn_rate : float
        The fastest that it turns [rad/s].
    laser : Pose2D
        Where the scanner sits on it.
    radius_error : float
        Standard deviation of each wheel's true radius, as a share of it.
    track_error : float
        Standard deviation of the true track, as a share of it.
    unevenness : float
        Standard deviation of a wheel's rolling radius from patch to patch of the floor, as a share.
    friction : (float, float)
        Lowest and highest coefficient of friction of a patch under a wheel.

    Raises
    ------
    ValueError
        If a figure makes no sense.
    """

    mass: float = 3.6
    wheel_radius: float = 0.05
    track: float = 0.254
    ticks_per_turn: int = 39_000
    max_torque: float = 0.5
    max_speed: float = 1.0
    max_turn_rate: float = 1.0
    laser: Pose2D = LASER
    radius_error: float = 0.002
    track_error: float = 0.005
    unevenness: float = 0.005
    friction: tuple[float, float] = (0.1, 0.6)

    def __post_init__(self) -> None:
        """Check the figures."""
        for name, unit in (
            ("mass", "kg"),
            ("wheel_radius", "m"),
            ("track", "m"),
            ("ticks_per_turn", "ticks"),
            ("max_torque", "N m"),
            ("max_speed", "m/s"),
            ("max_turn_rate", "rad/s"),
        ):
            value = getattr(self, name)
            if not 0 < value < math.inf:
                raise ValueError(f"{name} must be > 0 {unit}, got {value!r}")
        for name in ("radius_error", "track_error", "unevenness"):
            value = getattr(self, name)
            if not 0 <= value <= 0.1:
                raise ValueError(f"{name} must be a share of 0 to 0.1, got {value!r}")
        if not 0 < self.friction[0] <= self.friction[1] < math.inf:
            raise ValueError(f"friction must be 0 < lowest <= highest, got {self.friction!r}")
