"""The corners and walls that a robot has truly passed: what a map of them is held against."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, Record, read_only
from laserfeatures.evaluation import truth_of
from laserfeatures.evaluation.true_lines import lines_through, merge_collinear
from laserfeatures.evaluation.truth import MIN_BEAMS
from laserfeatures.simulation import Observation

SAME = 6  # decimals of a metre to which the true corners of two scans must agree to be one


@dataclass(frozen=True, eq=False, kw_only=True)
class TrueMap(Record):
    """True corners and walls, in the world's frame.

    Parameters
    ----------
    corners : (K, 2) array
        Crossings of two true lines that one scan measured both [m].
    real : (K,) bool array
        Whether surfaces that were measured meet there; at a virtual corner they would.
    walls : (W, 2, 2) array
        Both ends of each line of walls and sides of boxes that were measured [m]. Surfaces on one
        line are one wall, from the first to the last.
    """

    corners: FloatArray
    real: BoolArray
    walls: FloatArray

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        corners = read_only(self.corners, "corners", (None, 2))
        self._set(
            corners=corners,
            real=read_only(self.real, "real", (len(corners),), np.bool_),
            walls=read_only(self.walls, "walls", (None, 2, 2)),
        )


def true_map(observations: Sequence[Observation]) -> TrueMap:
    """Return what some scans of one world have truly shown.

    The corners are those of each scan, as `truth_of` has them, put together; a wall is one that at
    least four beams of a scan measured.

    Raises
    ------
    ValueError
        If there is no scan.
    """
    if not observations:
        raise ValueError("a true map is of at least one scan, got none")
    truths = [truth_of(observation) for observation in observations]
    seen = [o.pose.transform(t.corners) for o, t in zip(observations, truths, strict=True)]
    corners, which = np.unique(np.concatenate(seen).round(SAME), axis=0, return_inverse=True)
    real = np.zeros(len(corners), dtype=bool)
    np.logical_or.at(real, which.ravel(), np.concatenate([truth.real for truth in truths]))
    return TrueMap(corners=corners, real=real, walls=_walls(observations))


def _walls(observations: Sequence[Observation]) -> FloatArray:
    sides = observations[0].world.sides
    measured = np.zeros(len(sides), dtype=bool)
    for observation in observations:
        surface = observation.surface
        on_sides = surface[(surface >= 0) & (surface < len(sides))]
        measured |= np.bincount(on_sides, minlength=len(sides)) >= MIN_BEAMS
    pieces = sides[measured]
    line = merge_collinear(*lines_through(pieces))
    walls = [_span(pieces[line == i].reshape(-1, 2)) for i in np.unique(line)]
    return np.array(walls).reshape(-1, 2, 2)


def _span(points: FloatArray) -> FloatArray:
    """Return the first and the last of points (P, 2) of one line."""
    along = points @ (points[1] - points[0])
    return points[[int(along.argmin()), int(along.argmax())]]
