"""From ranges to points."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import kernel


@kernel
def returns(
    directions: FloatArray, ranges: FloatArray, range_min: float, range_max: float
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return (x, y, beam) of the valid returns, as `LaserScan.points` and `LaserScan.beams`."""
    n = ranges.size
    x = np.empty(n)
    y = np.empty(n)
    beam = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        r = ranges[i]
        if range_min <= r < range_max and 0.0 < r < math.inf:
            x[count] = r * directions[i, 0]
            y[count] = r * directions[i, 1]
            beam[count] = i
            count += 1
    return x[:count], y[:count], beam[:count]
