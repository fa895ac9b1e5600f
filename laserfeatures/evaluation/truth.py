"""What is true of a scan: its lines, the beams on each, and its corners."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, Record, read_only
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.evaluation.true_lines import cross, lines_through, merge_collinear
from laserfeatures.simulation import Observation
from laserfeatures.simulation.distances import to_walls

MIN_BEAMS = 4  # that hit a true line
TOUCHES = 1e-3  # [m]; walls that come nearer to each other meet


@dataclass(frozen=True, eq=False, kw_only=True)
class Truth(Record):
    """The true lines and corners of a scan, in the sensor's frame.

    Parameters
    ----------
    theta, d : (L,) arrays
        The true lines [rad, m], as `Lines` counts them.
    line : (N,) int array
        Number of the true line that each beam measures, or -1.
    corners : (K, 2) array
        The true corners [m].
    pairs : (K, 2) int array
        The two true lines of each corner; -1, -1 where no lines are known.
    real : (K,) bool array
        True for a real corner: surfaces on both lines that beams hit meet there.
    lines_known : bool
        False where only the corners are known: lines are not scored.
    """

    theta: FloatArray
    d: FloatArray
    line: IntArray
    corners: FloatArray
    pairs: IntArray
    real: BoolArray
    lines_known: bool = True

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        theta = read_only(self.theta, "theta", (None,))
        corners = read_only(self.corners, "corners", (None, 2))
        k = len(corners)
        self._set(
            theta=theta,
            d=read_only(self.d, "d", theta.shape),
            line=read_only(self.line, "line", (None,), np.int64),
            corners=corners,
            pairs=read_only(self.pairs, "pairs", (k, 2), np.int64),
            real=read_only(self.real, "real", (k,), np.bool_),
        )

    @classmethod
    def of_corners(cls, scan: LaserScan, corners: ArrayLike, real: ArrayLike) -> Self:
        """Make the truth of a scan of which only the corners are known: lines are not scored."""
        corners = read_only(corners, "corners", (None, 2))
        return cls(
            theta=np.empty(0),
            d=np.empty(0),
            line=np.full(len(scan), -1),
            corners=corners,
            pairs=np.full((len(corners), 2), -1),
            real=np.asarray(real, np.bool_),
            lines_known=False,
        )


def truth_of(observation: Observation) -> Truth:
    """Return what is true of a simulated scan.

    A true line is a wall, or the side of a box, that at least four beams measure; those on one line
    are one. The true corners are the crossings of every pair of true lines at 15 degrees or more
    within 20 m of the sensor, real where two surfaces that beams measure meet, virtual otherwise.
    Poles have no lines.

    References
    ----------
    The paper, sections I and II.D.
    """
    ends = in_sensor_frame(observation.world.sides, observation.pose)
    surface = np.where(observation.surface < len(ends), observation.surface, -1)
    theta, d = lines_through(ends)
    first = merge_collinear(theta, d)
    line = np.where(surface >= 0, first[surface], -1) if len(ends) else surface
    kept = np.flatnonzero(np.bincount(line[line >= 0], minlength=len(ends)) >= MIN_BEAMS)
    renumber = np.full(len(ends) + 1, -1)
    renumber[kept] = np.arange(kept.size)
    corners, pairs = cross(theta[kept], d[kept])
    seen = np.unique(surface[surface >= 0])
    pieces = [ends[seen[first[seen] == k]] for k in kept]
    real = [
        _touches(pieces[i], corner) and _touches(pieces[j], corner)
        for (i, j), corner in zip(pairs, corners, strict=True)
    ]
    return Truth(
        theta=theta[kept],
        d=d[kept],
        line=renumber[line],
        corners=corners,
        pairs=pairs,
        real=np.array(real, np.bool_),
    )


def in_sensor_frame(ends: FloatArray, pose: Pose2D) -> FloatArray:
    """Return points (..., 2) of the world's frame as a sensor at `pose` sees them."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    seen: FloatArray = (ends - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    return seen


def _touches(pieces: FloatArray, point: FloatArray) -> bool:
    """Tell whether a point lies on one of the pieces (P, 2, 2) or at its end."""
    return bool(to_walls(pieces, *point.reshape(2, 1, 1)).min() <= TOUCHES)
