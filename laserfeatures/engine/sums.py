"""Running sums over the returns, from which any stretch is fitted in a dozen operations.

A wall is met at 1/r = A ux + B uy along the beam (ux, uy), with A = cos theta / d and
B = sin theta / d: linear in both. A range error dr errs by dr / r^2 in 1/r, so that chi squared of
the ranges is the sum of r^2 / sigma^2 (1 - A x - B y)^2, and the best line solves two normal
equations.
"""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.compiled import helper, leaf
from laserfeatures.engine.sequence import Sequence

# Columns of the table, sums over the first j returns: of the weights r^2 / sigma^2, and weighted of
# what the names say; of 1 / sigma^2; and of what does not vanish at grazing incidence.
W, X, Y, XX, XY, YY, INVERSE, FLOOR = range(8)
COLUMNS = 8
SINGULAR = 1e-12  # of the normal equations: the returns are in line with the sensor


@helper
def running_sums(points: Sequence) -> FloatArray:
    """Return the table of sums, (P + 1, COLUMNS); a stretch i..j-1 has row j less row i."""
    sums = np.empty((points.x.size + 1, COLUMNS))
    add_up(points, sums)
    return sums


@leaf
def add_up(points: Sequence, sums: FloatArray) -> None:
    """Fill the table of sums."""
    for column in range(COLUMNS):
        sums[0, column] = 0.0
    for i in range(points.x.size):
        x = points.x[i]
        y = points.y[i]
        w = points.weight[i]
        sums[i + 1, W] = sums[i, W] + w
        sums[i + 1, X] = sums[i, X] + w * x
        sums[i + 1, Y] = sums[i, Y] + w * y
        sums[i + 1, XX] = sums[i, XX] + w * x * x
        sums[i + 1, XY] = sums[i, XY] + w * x * y
        sums[i + 1, YY] = sums[i, YY] + w * y * y
        sums[i + 1, INVERSE] = sums[i, INVERSE] + 1.0 / points.variance[i]
        sums[i + 1, FLOOR] = sums[i, FLOOR] + points.floor[i] / points.variance[i]


@leaf
def wall_misfit(sums: FloatArray, i: int, j: int) -> tuple[float, float]:
    """Return chi squared of the best line through returns i..j-1, and how obliquely it is met.

    That is the mean of 1 / cos^2 of the incidence. Both are inf where there is no line.
    """
    w = sums[j, W] - sums[i, W]
    x = sums[j, X] - sums[i, X]
    y = sums[j, Y] - sums[i, Y]
    xx = sums[j, XX] - sums[i, XX]
    xy = sums[j, XY] - sums[i, XY]
    yy = sums[j, YY] - sums[i, YY]
    det = xx * yy - xy * xy
    if det <= SINGULAR * xx * yy:
        return math.inf, math.inf
    a = x * yy - y * xy  # A and B times det
    b = y * xx - x * xy
    misfit = max(w - (a * x + b * y) / det, 0.0)
    # The cosine of the incidence is d / r, with d^2 = 1 / (A^2 + B^2).
    inverse = sums[j, INVERSE] - sums[i, INVERSE]
    floor = (sums[j, FLOOR] - sums[i, FLOOR]) / inverse
    oblique = (a * a + b * b) * w / (det * det * inverse)
    return misfit / (1.0 + floor * oblique), oblique


@leaf
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


@leaf
def line_through(sums: FloatArray, i: int, j: int) -> tuple[float, float, float, float]:
    """Return c, s, d and chi squared of the line through returns i..j-1."""
    return line_of(
        sums[j, W] - sums[i, W], sums[j, X] - sums[i, X], sums[j, Y] - sums[i, Y],
        sums[j, XX] - sums[i, XX], sums[j, XY] - sums[i, XY], sums[j, YY] - sums[i, YY],
    )  # fmt: skip
