"""How far points are from walls, boxes and poles."""

import numpy as np

from laserfeatures.arrays import FloatArray


def to_walls(walls: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance of points to walls (W, 2, 2) [m], (N, W).

    Parameters
    ----------
    walls : (W, 2, 2) array
        Both ends of each wall [m].
    x, y : (N, 1) array
        The points [m].
    """
    start_x, start_y = walls[:, 0].T
    along_x, along_y = (walls[:, 1] - walls[:, 0]).T
    x, y = x - start_x, y - start_y
    share = (x * along_x + y * along_y) / (along_x**2 + along_y**2)
    share = np.minimum(np.maximum(share, 0.0), 1.0)
    distances: FloatArray = np.hypot(x - share * along_x, y - share * along_y)
    return distances


def to_boxes(boxes: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance of points to boxes (B, 5) [m], negative inside, (N, B)."""
    x, y = x - boxes[:, 0], y - boxes[:, 1]
    c, s = np.cos(boxes[:, 4]), np.sin(boxes[:, 4])
    # A box seen from its own centre and axes is the same in all four quadrants.
    ahead = abs(x * c + y * s) - boxes[:, 2] / 2
    aside = abs(y * c - x * s) - boxes[:, 3] / 2
    outside = np.hypot(np.maximum(ahead, 0.0), np.maximum(aside, 0.0))
    return np.where(outside > 0, outside, np.maximum(ahead, aside))


def to_poles(poles: FloatArray, x: FloatArray, y: FloatArray) -> FloatArray:
    """Return the distance of points to poles (P, 3) [m], negative inside, (N, P)."""
    distances: FloatArray = np.hypot(x - poles[:, 0], y - poles[:, 1]) - poles[:, 2]
    return distances
