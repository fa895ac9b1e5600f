"""Walls that are rather one round object, such as a column in a wall (step 5)."""

import numpy as np

from laserfeatures.arrays import IntArray
from laserfeatures.compiled import ZERO, helper, leaf
from laserfeatures.engine.arcs import arc_misfit
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.walls import Walls

FACES = 4  # that a column is taken for, at the most
FEWEST = 12  # returns of a column without a jump on either side: fewer fit any circle,
MOST = 96  # and of what is tried: time
IN_WALL = 1.8  # [rad] of it that must be seen: boxes and edges of real walls look round over less
MARGIN = 20.0  # that a column must save: its faces may be those of a box


@helper
def find_columns(points: Sequence, label: IntArray, walls: Walls, max_radius: float) -> IntArray:
    """Return where columns begin and end, (2, K); the walls that they were lose their points."""
    n = label.size
    found = np.empty((2, walls.size), np.int64)
    count = 0
    begin = ZERO
    while begin < n and max_radius > 0.0:
        k = label[begin]
        if k < 0 or walls[k].first != begin or walls[k].last - begin > MOST:
            begin += 1
            continue
        first, last = column_from(points, label, walls, begin, max_radius)
        if last == first:
            begin += 1
            continue
        found[0, count] = first
        found[1, count] = last
        count += 1
        for i in range(first, last):
            if label[i] >= 0:
                walls[label[i]].points = 0
        begin = last
    return found[:, :count].copy()  # so `settle` is compiled for one layout


@leaf
def column_from(
    points: Sequence, label: IntArray, walls: Walls, begin: int, max_radius: float
) -> tuple[int, int]:
    """Return the first and last return of the column whose first face begins at a return.

    The stray returns beside its faces are taken for its edges. Where there is none, both are equal.
    """
    n = label.size
    end = first = last = begin
    flat = most = 0.0
    for _ in range(FACES):
        k = label[end] if end < n else STRAY
        if k < 0 or walls[k].first != end or walls[k].last - begin > MOST:
            break
        flat += PRICE + walls[k].chi2 + STRAY_PRICE * (walls[k].last - end - walls[k].points)
        end = walls[k].last
        low = begin
        while low > 0 and label[low - 1] == STRAY and points.jump[low] == 0.0:
            low -= 1
        high = end
        while high < n and label[high] == STRAY and points.jump[high] == 0.0:
            high += 1
        saved = flat + STRAY_PRICE * (begin - low + high - end) - ARC_PRICE
        if high - low < FEWEST or saved < high - low + MARGIN:  # a circle would not be much better
            continue
        saved -= arc_misfit(points, low, high, max_radius, IN_WALL)
        if saved > max(most, MARGIN):
            most = saved
            first = low
            last = high
    return first, last
