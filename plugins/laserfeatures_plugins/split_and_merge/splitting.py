"""The kernels: the scan broken where it jumps, the pieces split where they bend."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.engine import helper, kernel, leaf
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.sequence import Sequence, as_sequence
from laserfeatures.engine.sums import line_through, running_sums

LEAST = 3  # points of a piece
FLAT = 2.0  # chi squared of a piece for each degree of freedom, and
DOUBT = 6.0  # standard deviations of that besides, at the most


@kernel
def propose(table: FloatArray) -> FloatArray:
    """Return the lines of the pieces of a scan, (COLUMNS, K)."""
    points = as_sequence(table)
    n = points.x.size
    sums = running_sums(points)
    lines = np.empty((COLUMNS, n // (LEAST - 1) + 1))
    count = start = 0
    for i in range(1, n + 1):
        if i == n or points.jump[i] > 0.0:
            count = split(points, sums, start, i - 1, lines, count)
            start = i
    return lines[:, :count].copy()


@helper
def split(
    points: Sequence, sums: FloatArray, start: int, end: int, lines: FloatArray, count: int
) -> int:
    """Split the points start..end at the farthest from their chord until each piece is straight.

    Adds the pieces' lines to the table and returns their number.
    """
    waiting = np.empty((end - start + 2, 2), np.int64)
    waiting[0, 0] = start
    waiting[0, 1] = end
    left = 1
    while left > 0:
        left -= 1
        a = waiting[left, 0]
        b = waiting[left, 1]
        while b - a + 1 >= LEAST:
            c, s, d, chi2 = line_through(sums, a, b + 1)
            freedom = b - a - 1.0
            if chi2 < FLAT * freedom + DOUBT * math.sqrt(2.0 * freedom):
                lines[0, count] = c
                lines[1, count] = s
                lines[2, count] = d
                lines[3, count] = a
                lines[4, count] = b + 1
                count += 1
                break
            corner = farthest(points, a, b)
            waiting[left, 0] = corner
            waiting[left, 1] = b
            left += 1
            b = corner
    return count


@leaf
def farthest(points: Sequence, a: int, b: int) -> int:
    """Return which point between a and b is farthest from the chord of both."""
    x = points.x[a]
    y = points.y[a]
    ux = points.x[b] - x
    uy = points.y[b] - y
    most = -1.0
    place = (a + b) // 2
    if ux == 0.0 and uy == 0.0:  # a full turn that ends where it began
        return place
    for i in range(a + 1, b):
        off = abs((points.x[i] - x) * uy - (points.y[i] - y) * ux)
        if off > most:
            most = off
            place = i
    return place
