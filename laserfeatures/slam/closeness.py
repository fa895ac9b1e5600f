"""Which corners and walls are near which, by where they were seen."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.scan import Pose2D
from laserfeatures.slam.kinds import CORNER, Kind

TILT = math.radians(15)  # walls
APART = 1.0  # [m] along a wall between what was seen of it and what is seen now


def in_map(pose: Pose2D, ends: FloatArray) -> FloatArray:
    """Return ends (N, 2, 2) seen from a pose, in the frame of the map."""
    return pose.transform(ends).reshape(-1, 2, 2)


def close(ends: FloatArray, others: FloatArray, slack: float, kind: Kind) -> BoolArray:
    """Return which of some things (N, 2, 2) are within `slack` [m] of which others (L, 2, 2)."""
    if kind is CORNER:
        x, y = (ends[:, None, 0] - others[None, :, 0]).transpose(2, 0, 1)
        near: BoolArray = x * x + y * y <= slack * slack
        return near
    along = others[:, 1] - others[:, 0]
    length = np.linalg.norm(along, axis=1)
    along = along / np.maximum(length, 1e-9)[:, None]
    own = ends[:, 1] - ends[:, 0]
    own = own / np.maximum(np.linalg.norm(own, axis=1), 1e-9)[:, None]
    tilt = abs(own[:, None, 0] * along[None, :, 1] - own[:, None, 1] * along[None, :, 0])
    from_start = ends[:, None] - others[None, :, :1]
    place = (from_start * along[None, :, None]).sum(axis=3)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    off = abs((from_start * normal[None, :, None]).sum(axis=3)).mean(axis=2)
    gap = np.maximum(place.min(axis=2) - length, -place.max(axis=2))
    return (tilt <= math.sin(TILT)) & (off <= slack) & (gap <= APART)
