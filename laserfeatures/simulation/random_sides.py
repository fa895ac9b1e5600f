"""Random sides of corridors: straight walls with doors, some of which lead to a room."""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray

THICKNESS = 0.1  # [m], of the wall that a door goes through
MARGIN = 0.3  # [m], from a door to the end of its stretch of wall, at least


class Room(NamedTuple):
    """A room behind a door; lengths along and away from the corridor's side [m]."""

    door: FloatArray  # (2,), the middle of the door, on the corridor's side
    along: FloatArray  # (2,), unit vector along that side
    outward: FloatArray  # (2,), unit vector out of the corridor
    left: float  # from the door's middle to the room's near wall, against `along`
    right: float  # the same the other way
    depth: float


def side(
    rng: np.random.Generator, start: FloatArray, end: FloatArray, *, rooms: float
) -> tuple[list[FloatArray], list[Room]]:
    """Return the corners from `start` on, before `end`, of a side with doors, and the rooms behind.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of randomness.
    start, end : (2,) array
        Where the side begins and ends [m]; the corridor is to the left of the way there.
    rooms : float
        Probability that a door stands open to a room; else it is closed, in a niche.
    """
    length = math.dist(start, end)
    along = (end - start) / length
    outward = np.array([along[1], -along[0]])
    points, found = [start], []
    count = int(length // rng.uniform(2.8, 4.5))
    for k in range(count):
        stretch = length / count
        wide = rng.uniform(0.9, 1.1)
        left = rng.uniform(MARGIN, stretch - MARGIN - wide)
        kind, niche, depth = rng.random(), rng.uniform(0.08, 0.25), rng.uniform(2.5, 4.5)
        if kind > 0.85:
            continue  # a stretch without a door
        door = k * stretch + left
        if kind < 0.85 * rooms:
            near, far = THICKNESS, THICKNESS + depth
            room_start, room_end = k * stretch + THICKNESS / 2, (k + 1) * stretch - THICKNESS / 2
            steps = [
                (door, 0.0), (door, near), (room_start, near), (room_start, far),
                (room_end, far), (room_end, near), (door + wide, near), (door + wide, 0.0),
            ]  # fmt: skip
            middle = door + wide / 2
            centre = start + along * middle
            found.append(
                Room(centre, along, outward, middle - room_start, room_end - middle, depth)
            )
        else:
            steps = [(door, 0.0), (door, niche), (door + wide, niche), (door + wide, 0.0)]
        points += [start + along * a + outward * b for a, b in steps]
    return points, found


def walls_of(points: list[FloatArray]) -> FloatArray:
    """Return the walls of a closed polygon, (n, 2, 2)."""
    corners = np.array(points)
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


def walk(path: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """Return points every `step` along a path (K, 2), (n, 2) [m], and the heading there [rad]."""
    legs = np.diff(path, axis=0)
    lengths = np.hypot(legs[:, 0], legs[:, 1])
    ends = np.cumsum(lengths)
    at = np.arange(0.0, ends[-1], step)
    leg = np.minimum(np.searchsorted(ends, at, side="right"), len(legs) - 1)
    share = (at - (ends - lengths)[leg]) / lengths[leg]
    points = path[leg] + share[:, None] * legs[leg]
    return points, np.arctan2(legs[leg, 1], legs[leg, 0])
