"""Which of the two poses of a CARMEN record is which.

The first pose is the laser's, the second the robot's by odometry. In a log as it was recorded they
are one rigid body: where the laser sits on the robot. In a log that a SLAM program has corrected
the first one is corrected; the second is raw odometry in some (as `laserfeatures simulate` writes
them), and in others the same pose once more (all that GMapping wrote).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from laserfeatures.data import Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.poses import compose, relative
from laserfeatures.sources.beams import numbers
from laserfeatures.sources.log import Log
from laserfeatures.sources.readings import Reading

MOUNTING = b"robot_frontlaser_offset"
RIGID = (0.02, math.radians(1))  # [m], [rad]; poses that differ by less are one body
FARTHEST = 1.0  # [m] from the axle that a laser may sit


@dataclass
class CarmenPoses:
    """Tells, record by record, what a log's poses are, and picks the ones that were asked for.

    Parameters
    ----------
    log : Log
        What it was asked for; its `poses` are kept up to date.
    """

    log: Log
    _corrected: bool = field(default=False, init=False)
    _raw: bool = field(default=False, init=False)
    _mounting: Pose2D | None = field(default=None, init=False)
    _first: Pose2D | None = field(default=None, init=False)

    def corrected(self) -> None:
        """Take note that a SLAM program has written the log."""
        self._corrected = True
        self.log.poses = "odometry" if self._raw and self._asked else "corrected"

    @property
    def _asked(self) -> bool:
        return self.log.wanted == "odometry"

    def param(self, line: bytes) -> None:
        """Take in a record PARAM; one of them says how far the laser is ahead of the axle.

        Raises
        ------
        ValueError
            If that is not a number.
        """
        tokens = line.split()
        if len(tokens) > 2 and tokens[1] == MOUNTING:
            ahead = float(numbers([tokens[2]], f"PARAM {MOUNTING.decode()} in m")[0])
            self._mounting = Pose2D(ahead, 0.0, 0.0)

    def chosen(self, readings: Iterator[Reading]) -> Iterator[Reading]:
        """Yield readings with the poses that the log is asked for.

        Raises
        ------
        SourceError
            If raw odometry is asked for and the log has corrected poses in both places.
        """
        held: list[Reading] = []
        for reading in readings:
            mounting = self._look(reading)
            if not self._asked:
                yield reading
                continue
            pose = reading.odometry or reading.pose
            held.append(reading._replace(pose=pose and compose(pose, mounting)))
            if self._raw or not self._corrected:
                yield from held
                held = []
        if held:
            raise SourceError(
                f"{self.log.path}: expected a log with raw odometry, got one with corrected "
                "poses only"
            )

    def _look(self, reading: Reading) -> Pose2D:
        """Take in a reading's poses; return where the laser sits on the robot."""
        if reading.odometry is None or reading.pose is None:
            return Pose2D(0.0, 0.0, 0.0)
        between = relative(reading.odometry, reading.pose)
        if self._first is None:
            self._first = between
            if self._mounting is None:
                self._mounting = _plausible(between)
        off = relative(self._first, between)
        if math.hypot(off.x, off.y) > RIGID[0] or abs(off.theta) > RIGID[1]:
            self._raw = True
            self.corrected()
        return self._mounting or Pose2D(0.0, 0.0, 0.0)


def _plausible(between: Pose2D) -> Pose2D:
    """Return where a laser seems to sit if that may be, else the axle's middle."""
    straight = abs(between.y) < 1e-3 and abs(between.theta) < 1e-3
    return between if straight and abs(between.x) < FARTHEST else Pose2D(0.0, 0.0, 0.0)
