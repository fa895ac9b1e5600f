"""What one scan gives the filter to measure."""

from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features
from laserfeatures.slam.association import worth
from laserfeatures.slam.kinds import CORNER, WALL, Kind

LEAST_WORTH = 1.0  # that a pairing must be able to score
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


def observations_of(
    features: Features, *, corners: bool, walls: bool, roughness: float
) -> list[Observations]:
    """Return the corners and walls of a scan as measurements; not those too vague to recognise.

    Parameters
    ----------
    features : Features
        What an extractor has found.
    corners, walls : bool
        Which kinds are wanted.
    roughness : float
        How far real walls and corners are off lines and points [m], beyond the sensor's noise that
        the extractor knows; a wall's angle is off by that at either end.
    """
    scale = TWICE if corners and walls else 1.0
    found: list[Observations] = []
    if corners:
        seen = features.corners
        both_ends = np.repeat(seen.positions[:, None], 2, axis=1)
        noise = scale * (seen.covariance + roughness**2 * np.eye(2))
        found.append(Observations(CORNER, seen.positions, noise, both_ends))
    if walls:
        lines, segments = features.lines, features.segments
        values = np.stack([lines.theta, lines.d], axis=1)
        extents = np.array(
            [_ends(segments.endpoints[segments.line == i]) for i in range(len(lines))]
        ).reshape(-1, 2, 2)
        noise = scale * (lines.covariance + _rough(lines.theta, extents, roughness))
        found.append(Observations(WALL, values, noise, extents))
    return [_recognisable(seen) for seen in found]


def _rough(theta: FloatArray, extents: FloatArray, roughness: float) -> FloatArray:
    """Return the covariance (L, 2, 2) of theta and d of walls that are so rough."""
    length = np.linalg.norm(extents[:, 1] - extents[:, 0], axis=1)
    tilt = 2 * (roughness / np.maximum(length, 1e-9)) ** 2
    along = np.stack([-np.sin(theta), np.cos(theta)], axis=1)
    arm = (extents.mean(axis=1) * along).sum(axis=1)  # it tilts about its middle
    noise = np.empty((len(theta), 2, 2))
    noise[:, 0, 0] = tilt
    noise[:, 0, 1] = noise[:, 1, 0] = arm * tilt
    noise[:, 1, 1] = roughness**2 + arm**2 * tilt
    return noise


def _recognisable(seen: Observations) -> Observations:
    good = worth(seen.noise) > LEAST_WORTH
    return Observations(seen.kind, seen.values[good], seen.noise[good], seen.extents[good])


def _ends(pieces: FloatArray) -> FloatArray:
    """Return both ends of all the pieces (S, 2, 2) of a line together, (2, 2)."""
    points = pieces.reshape(-1, 2)
    along = pieces[0, 1] - pieces[0, 0]
    place = points @ along
    return points[[int(np.argmin(place)), int(np.argmax(place))]]
