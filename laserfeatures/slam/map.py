"""The map that the filter has made, as a user wants it, landmark by landmark."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.slam.landmarks import Landmarks
from laserfeatures.slam.state import State


@dataclass(frozen=True, eq=False, kw_only=True)
class Landmark:
    """A corner or a wall of the map.

    Parameters
    ----------
    kind : "corner" or "wall"
        What it is.
    values : (2,) array
        A corner's x, y [m]; a wall's theta [rad] and d [m] as in d = x cos(theta) + y sin(theta).
    covariance : (2, 2) array
        Of the two.
    ends : (2, 2) array
        Both ends of what was seen of a wall [m]; of a corner, twice the corner.
    sightings : int
        In how many scans it was seen.
    """

    kind: Literal["corner", "wall"]
    values: FloatArray
    covariance: FloatArray
    ends: FloatArray
    sightings: int


def map_of(state: State, landmarks: Landmarks) -> tuple[Landmark, ...]:
    """Return the landmarks, in the order in which they were found."""
    ends, blocks = landmarks.present_ends(state), state.blocks()
    found = []
    for i in range(state.landmarks):
        values, covariance = state.positions[i].copy(), blocks[i]
        if landmarks.is_wall[i]:
            values, covariance = _from_origin(values, covariance, landmarks.anchors[i])
        found.append(
            Landmark(
                kind="wall" if landmarks.is_wall[i] else "corner",
                values=values,
                covariance=covariance,
                ends=ends[i],
                sightings=int(landmarks.hits[i]),
            )
        )
    return tuple(found)


def _from_origin(
    values: FloatArray, covariance: FloatArray, anchor: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return a wall's (theta, d), theta in [0, pi), and their covariance, from (alpha, rho)."""
    alpha, rho = values.tolist()
    c, s = math.cos(alpha), math.sin(alpha)
    d = rho + c * anchor[0] + s * anchor[1]
    change = np.array([[1.0, 0.0], [c * anchor[1] - s * anchor[0], 1.0]])
    halves = math.floor(alpha / math.pi)
    if halves % 2:
        d, change[1] = -d, -change[1]
    return np.array([alpha - math.pi * halves, d]), change @ covariance @ change.T
