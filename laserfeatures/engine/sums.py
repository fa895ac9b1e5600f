"""Running sums over the returns, from which any stretch is fitted in a dozen operations.

A wall is met at 1/r = A ux + B uy along the beam (ux, uy), with (A, B) = (cos theta, sin theta) / d:
linear in A and B. A range error dr errs by dr / r^2 in 1/r, so that chi squared of the ranges is
the sum of r^2 / sigma^2 (1 - A x - B y)^2, and the least-squares line solves two normal equations.
"""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.compiled import helper
from laserfeatures.engine.sequence import Sequence

# Columns of the table, sums over the first j returns: of the weights r^2 / sigma^2, and weighted of
# what the names say; of 1 / sigma^2; and of what does not vanish at grazing incidence.
W, X, Y, XX, XY, YY, INVERSE, FLOOR = range(8)
COLUMNS = 8
SINGULAR = 1e-12  # of the normal equations: the returns are in line with the sensor


@helper
def running_sums(points: Sequence) -> FloatArray:
    """Return the table of sums, (P + 1, COLUMNS); a stretch i..j-1 has row j less row i."""
    n = points.x.size
    sums = np.empty((n + 1, COLUMNS))
    sums[0] = 0.0
    for i in range(n):
        x = points.x[i]
        y = points.y[i]
        w = points.weight[i]
        now = sums[i]
        after = sums[i + 1]
        after[W] = now[W] + w
        after[X] = now[X] + w * x
        after[Y] = now[Y] + w * y
        after[XX] = now[XX] + w * x * x
        after[XY] = now[XY] + w * x * y
        after[YY] = now[YY] + w * y * y
        after[INVERSE] = now[INVERSE] + 1.0 / points.variance[i]
        after[FLOOR] = now[FLOOR] + points.floor[i] / points.variance[i]
    return sums


@helper
def wall_misfit(sums: FloatArray, i: int, j: int) -> tuple[float, float]:
    """Return chi squared of the best line through returns i..j-1, and how obliquely it is met.

    That is the inverse of the mean squared cosine of the incidence. Both are inf where there is no line.
    """
    low = sums[i]
    high = sums[j]
    w = high[W] - low[W]
    x = high[X] - low[X]
    y = high[Y] - low[Y]
    xx = high[XX] - low[XX]
    xy = high[XY] - low[XY]
    yy = high[YY] - low[YY]
    det = xx * yy - xy * xy
    if det <= SINGULAR * xx * yy:
        return math.inf, math.inf
    a = x * yy - y * xy  # A and B times det
    b = y * xx - x * xy
    misfit = max(w - (a * x + b * y) / det, 0.0)
    # The mean squared cosine of the incidence is d^2 mean(1/r^2), with d^2 = 1 / (A^2 + B^2).
    inverse = high[INVERSE] - low[INVERSE]
    floor = (high[FLOOR] - low[FLOOR]) / inverse
    oblique = (a * a + b * b) * w / (det * det * inverse)
    return misfit / (1.0 + floor * oblique), oblique


@helper
def line_of(
    w: float, x: float, y: float, xx: float, xy: float, yy: float
) -> tuple[float, float, float, float]:
    """Return c, s, d and chi squared of the line that weighted sums give; chi squared may be inf.

    d is positive: (c, s) points from the sensor to the line.
    """
    det = xx * yy - xy * xy
    if det <= SINGULAR * xx * yy:
        return 1.0, 0.0, 0.0, math.inf
    a = (x * yy - y * xy) / det
    b = (y * xx - x * xy) / det
    d = 1.0 / math.sqrt(a * a + b * b)
    return a * d, b * d, d, max(w - a * x - b * y, 0.0)


@helper
def line_through(sums: FloatArray, i: int, j: int) -> tuple[float, float, float, float]:
    """Return c, s, d and chi squared of the line through returns i..j-1."""
    low = sums[i]
    high = sums[j]
    return line_of(
        high[W] - low[W], high[X] - low[X], high[Y] - low[Y], high[XX] - low[XX],
        high[XY] - low[XY], high[YY] - low[YY],
    )  # fmt: skip
