"""A candidate grown along the scan from a return and a direction (step 3, shared by detectors)."""

import math
from typing import NamedTuple

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.compiled import leaf
from laserfeatures.engine.prices import PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.sums import line_of

INLIER = 9.0  # chi squared of a return on its line, at the most
FITS = 3


class Candidate(NamedTuple):
    """A line, and the returns first..last-1 that it was grown along."""

    c: float
    s: float
    d: float
    first: int
    last: int
    saved: float  # of the cost of stray returns; a wall where it is more than none


@leaf
def is_inlier(points: Sequence, i: int, c: float, s: float, d: float, width: float) -> bool:
    """Tell whether a return is on a line, give or take `width` [m] and the noise."""
    off = max(abs(points.x[i] * c + points.y[i] * s - d) - width, 0.0)
    cosine = points.ux[i] * c + points.uy[i] * s
    return bool(off * off < INLIER * points.variance[i] * (cosine * cosine + points.floor[i]))


@leaf
def grow(
    points: Sequence,
    taken: BoolArray,
    seed: int,
    c: float,
    s: float,
    d: float,
    width: float,
    max_missed: int,
) -> Candidate:
    """Grow a line both ways from return `seed`, refit it, and again.

    At first returns within `width` [m] and their noise belong to it, then those within the noise.
    It ends where more than `max_missed` beams in a row are off it, `taken` or without a return.
    """
    found = Candidate(c, s, d, seed, seed + 1, -PRICE)
    before = -1
    for _ in range(FITS):
        first, last, count, c, s, d, chi2 = fit_around(
            points, taken, seed, found.c, found.s, found.d, width, max_missed
        )
        if count < 3:
            return Candidate(found.c, found.s, found.d, first, last, -PRICE)
        found = Candidate(c, s, d, first, last, count * STRAY_PRICE - chi2 - PRICE)
        if width == 0.0 and count == before:
            break
        before = count
        width = 0.0
    return found


@leaf
def fit_around(
    points: Sequence,
    taken: BoolArray,
    seed: int,
    c: float,
    s: float,
    d: float,
    width: float,
    max_missed: int,
) -> tuple[int, int, int, float, float, float, float]:
    """Return the run of inliers around a return, their number, their line and its chi squared."""
    w = sx = sy = sxx = sxy = syy = 0.0
    count = 0
    ends = (seed, seed)
    for way in (-1, 1):
        i = seed if way < 0 else seed + 1
        end = seed
        while 0 <= i < points.x.size:
            if abs(points.beam[i] - points.beam[end]) > max_missed + 1:
                break
            x = points.x[i]
            y = points.y[i]
            if not taken[i] and is_inlier(points, i, c, s, d, width):
                weight = points.weight[i]
                w += weight
                sx += weight * x
                sy += weight * y
                sxx += weight * x * x
                sxy += weight * x * y
                syy += weight * y * y
                count += 1
                end = i
            i += way
        ends = (end, ends[1]) if way < 0 else (ends[0], end)
    if count < 3:
        return ends[0], ends[1] + 1, 0, c, s, d, 0.0
    c, s, d, chi2 = line_of(w, sx, sy, sxx, sxy, syy)
    return ends[0], ends[1] + 1, count if chi2 < math.inf else 0, c, s, d, chi2


@leaf
def add(
    points: Sequence, taken: BoolArray, found: Candidate, lines: FloatArray, count: int
) -> None:
    """Write a candidate into column `count` of a table, and mark the returns that it explains."""
    lines[0, count] = found.c
    lines[1, count] = found.s
    lines[2, count] = found.d
    lines[3, count] = found.first
    lines[4, count] = found.last
    for i in range(found.first, found.last):
        if is_inlier(points, i, found.c, found.s, found.d, 0.0):
            taken[i] = True
