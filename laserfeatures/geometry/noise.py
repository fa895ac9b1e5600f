"""The noise of a scan's ranges."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.geometry.compiled import helper

MIN_SIGMA = 0.002  # [m]; no scanner that this is for measures better
MAX_SIGMA = 0.1  # [m]; with more noise than that there are no walls to be found
CHORDS = 50  # fewer mistake a crowded room for noise, more take time and gain little
BASELINE = 0.1  # [m]
NORMAL = 0.6745  # median of the absolute value of a normal variable, in standard deviations


@helper
def estimate_sigma(x: FloatArray, y: FloatArray) -> float:
    """Estimate the range noise [m] from how far points lie off the chord of their neighbours.

    About `CHORDS` of them are looked at, or all. The neighbours are taken `BASELINE` metres away,
    since the noise of nearby beams is often filtered by the sensor. The median takes no notice of
    corners, edges and outliers while most chords lie on walls.
    """
    stride = max(1, x.size // CHORDS)
    noise = np.empty(x.size)
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
            noise[count] = off / (incidence * math.sqrt(variance))
            count += 1
    if count < 8:
        return 5.0 * MIN_SIGMA
    return min(max(median(noise[:count]) / NORMAL, MIN_SIGMA), MAX_SIGMA)


@helper
def median(values: FloatArray) -> float:
    """Return the upper median, as far as it can matter, to some 30 micrometres.

    By bisection: to count takes no branches, which a sort would have the processor guess.
    """
    low = 0.0
    high = 1.01 * NORMAL * MAX_SIGMA
    for _ in range(12):
        middle = 0.5 * (low + high)
        below = 0
        for value in values:
            below += value <= middle
        if 2 * below > values.size:
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)
