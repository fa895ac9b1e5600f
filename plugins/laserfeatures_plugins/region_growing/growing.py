"""The kernel: walls grown from neighbouring points, in the order of the scan."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.engine import kernel, leaf
from laserfeatures.engine.candidates import Candidate, add, is_inlier
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.prices import PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence, as_sequence
from laserfeatures.engine.sums import line_of

SEED = 4  # points that a line must explain to be grown
FLAT = 9.0  # their chi squared, at the most
PACE = 16  # returns of a region in vain for one more that is passed over: else time is quadratic


@kernel
def propose(table: FloatArray, max_missed: int) -> FloatArray:
    """Return the lines grown along a scan, (COLUMNS, K)."""
    points = as_sequence(table)
    n = points.x.size
    lines = np.empty((COLUMNS, n // (SEED - 1) + 1))
    taken = np.zeros(n, np.bool_)
    count = i = 0
    while i <= n - SEED and count < lines.shape[1]:
        found = grow_region(points, i, max_missed)
        if found.saved > 0.0:
            add(points, taken, found, lines, count)
            count += 1
            i = found.last - 1  # the corner may be the next wall's, too
        else:
            i += 1 + (found.last - i) // PACE
    return lines[:, :count].copy()


@leaf
def grow_region(points: Sequence, first: int, max_missed: int) -> Candidate:
    """Grow a line forwards from a point and its followers.

    The line follows from running sums whenever half as many points have come again. More than
    `max_missed` points off it in a row end the region.
    """
    w = sx = sy = sxx = sxy = syy = chi2 = 0.0
    c = s = d = 0.0
    count = missed = 0
    refit = SEED
    i = last = first
    while i < points.x.size and missed <= max_missed:
        if count < SEED:
            if i > first and points.jump[i] > 0.0:
                break
        elif not is_inlier(points, i, c, s, d, 0.0):
            missed += 1
            i += 1
            continue
        x = points.x[i]
        y = points.y[i]
        weight = points.weight[i]
        w += weight
        sx += weight * x
        sy += weight * y
        sxx += weight * x * x
        sxy += weight * x * y
        syy += weight * y * y
        count += 1
        missed = 0
        i += 1
        last = i
        if count == refit:
            c, s, d, chi2 = line_of(w, sx, sy, sxx, sxy, syy)
            if count == SEED and not chi2 < FLAT:
                break
            refit += 1 + refit // 2
    if count < SEED or not chi2 < math.inf:
        return Candidate(c, s, d, first, last, -PRICE)
    c, s, d, chi2 = line_of(w, sx, sy, sxx, sxy, syy)
    return Candidate(c, s, d, first, last, count * STRAY_PRICE - chi2 - PRICE)
