"""The noise of a scan's ranges."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.geometry.compiled import helper

MIN_SIGMA = 0.002  # [m]; no scanner that this is for measures better
MAX_SIGMA = 0.1  # [m]; with more noise than that there are no walls to be found
BASELINE = 0.1  # [m]


@helper
def estimate_sigma(x: FloatArray, y: FloatArray) -> float:
    """Estimate the range noise [m] from how far points lie off the chord of their neighbours.

    The neighbours are taken `BASELINE` metres away, since the noise of nearby beams is often
    filtered by the sensor. The median takes no notice of corners, edges and outliers while most
    chords lie on walls.
    """
    stride = max(1, x.size // 50)  # more chords than that cost time and gain nothing
    noise = np.empty(x.size)  # sorted as it is filled
    count = 0
    for i in range(1, x.size - 1, stride):
        a = i - 1
        while a > 0 and (x[i] - x[a]) ** 2 + (y[i] - y[a]) ** 2 < BASELINE * BASELINE:
            a -= 1
        b = i + 1
        while b < x.size - 1 and (x[b] - x[i]) ** 2 + (y[b] - y[i]) ** 2 < BASELINE * BASELINE:
            b += 1
        dx = x[b] - x[a]
        dy = y[b] - y[a]
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        length = math.sqrt(square)
        off = abs((x[i] - x[a]) * dy - (y[i] - y[a]) * dx) / length
        share = ((x[i] - x[a]) * dx + (y[i] - y[a]) * dy) / square
        incidence = abs(x[i] * dy - y[i] * dx) / (length * math.sqrt(x[i] * x[i] + y[i] * y[i]))
        if incidence > 0.2 and 0.0 < share < 1.0:
            variance = 1.0 + share * share + (1.0 - share) ** 2
            value = off / (incidence * math.sqrt(variance))
            k = count
            while k > 0 and noise[k - 1] > value:
                noise[k] = noise[k - 1]
                k -= 1
            noise[k] = value
            count += 1
    if count < 8:
        return 5.0 * MIN_SIGMA
    return min(max(noise[count // 2] / 0.6745, MIN_SIGMA), MAX_SIGMA)
