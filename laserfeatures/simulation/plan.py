"""Plans: a world, and the drive that a robot makes through it."""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from laserfeatures.arrays import FloatArray, Record, read_only
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import World


@dataclass(frozen=True, eq=False, kw_only=True)
class Drive(Record):
    """Where a robot drives, and how it scans on the way.

    Parameters
    ----------
    waypoints : (K, 2) array
        The points that it passes, in order [m]; it starts at the first and faces the second.
    scanner : Scanner
        The rangefinder that it carries.
    seed : int
        Seed of all randomness of the drive.
    speed : float
        Speed on a straight [m/s].
    scan_rate : float
        Scans a second [Hz].

    Raises
    ------
    ValueError
        If there are fewer than two way-points or two in a row are one, or a number makes no sense.
    """

    waypoints: FloatArray
    scanner: Scanner = field(default_factory=Scanner)
    seed: int = 0
    speed: float = 0.4
    scan_rate: float = 5.0

    def __post_init__(self) -> None:
        """Check the way-points and numbers."""
        waypoints = read_only(self.waypoints, "waypoints", (None, 2))
        self._set(waypoints=waypoints)
        if len(waypoints) < 2:
            raise ValueError(f"waypoints must be at least 2, got {len(waypoints)}")
        for i, point in enumerate(waypoints):
            if not np.isfinite(point).all():
                raise ValueError(f"way-point {i} must be finite, got {point.tolist()}")
            if i and not math.dist(waypoints[i - 1], point) > 0:
                raise ValueError(
                    f"way-points {i - 1} and {i} must differ, got {point.tolist()} twice"
                )
        if not self.seed >= 0:
            raise ValueError(f"seed must be >= 0, got {self.seed}")
        if not 0 < self.speed < math.inf:
            raise ValueError(f"speed must be > 0 m/s, got {self.speed}")
        if not 0 < self.scan_rate < math.inf:
            raise ValueError(f"scan_rate must be > 0 Hz, got {self.scan_rate}")


@dataclass(frozen=True, eq=False, kw_only=True)
class Plan:
    """A world, and the drive through it if there is one.

    Parameters
    ----------
    world : World
        The floor plan.
    drive : Drive or None
        What a robot does in it.
    path : Path or None
        The file that it was read from.

    Raises
    ------
    ValueError
        If a way-point lies on a surface, or inside a box or pole.
    """

    world: World
    drive: Drive | None = None
    path: Path | None = None

    def __post_init__(self) -> None:
        """Check that the robot can be where it is to drive."""
        for i, (x, y) in enumerate(() if self.drive is None else self.drive.waypoints):
            self.world.check_pose(Pose2D(x, y, 0.0), f"way-point {i}")
