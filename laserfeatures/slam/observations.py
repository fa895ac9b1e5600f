"""What one scan gives the filter to measure."""

from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features
from laserfeatures.slam.kinds import CORNER, WALL, Kind

TWICE = 2.0  # corners are where walls cross: with both, each thing is told twice


@dataclass(frozen=True, eq=False)
class Observations:
    """Measurements of one kind of landmark in one scan.

    Parameters
    ----------
    kind : Kind
        Corners or walls.
    values : (N, 2) array
        The measurements, in the sensor's frame.
    noise : (N, 2, 2) array
        Their covariances.
    extents : (N, 2, 2) array
        Both ends of what was seen of each [m]; of a corner both are the corner.
    """

    kind: Kind
    values: FloatArray
    noise: FloatArray
    extents: FloatArray

    def __len__(self) -> int:
        """Return the number of measurements."""
        return len(self.values)


def observations_of(features: Features, *, corners: bool, walls: bool) -> list[Observations]:
    """Return the corners and walls of a scan as measurements.

    Parameters
    ----------
    features : Features
        What an extractor has found.
    corners, walls : bool
        Which kinds are wanted.
    """
    scale = TWICE if corners and walls else 1.0
    found: list[Observations] = []
    if corners:
        seen = features.corners
        both_ends = np.repeat(seen.positions[:, None], 2, axis=1)
        found.append(Observations(CORNER, seen.positions, scale * seen.covariance, both_ends))
    if walls:
        lines, segments = features.lines, features.segments
        values = np.stack([lines.theta, lines.d], axis=1)
        extents = np.array(
            [_ends(segments.endpoints[segments.line == i]) for i in range(len(lines))]
        )
        found.append(
            Observations(WALL, values, scale * lines.covariance, extents.reshape(-1, 2, 2))
        )
    return found


def _ends(pieces: FloatArray) -> FloatArray:
    """Return both ends of all the pieces (S, 2, 2) of a line together, (2, 2)."""
    points = pieces.reshape(-1, 2)
    along = pieces[0, 1] - pieces[0, 0]
    place = points @ along
    return points[[int(np.argmin(place)), int(np.argmax(place))]]
