"""Walls that are two faces, one behind the other: parted where their returns step (step 5)."""

import numpy as np

from laserfeatures.arrays import IntArray
from laserfeatures.compiled import helper
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.walls import WALL, Walls, add_return, combine, solve

STEP_PRICE = 12.0  # that two lines must save; the next explanation decides by its own prices
LEAST = 1.0  # squared height of a step, in noises: walls are not flat to less
PARTS = 3  # of a wall: before, between and after the ends of the largest excursion


@helper
def part_at_steps(points: Sequence, label: IntArray, walls: Walls, min_points: int) -> Walls:
    """Return the walls and, after them, those parted from them; label their returns anew."""
    count = walls.size
    parts = parts_of(points, label, walls, excursions(points, label, walls))
    # A record does not keep the array alive that it is a part of: these are parts of `more`.
    more = np.zeros(2 * count + 2, WALL)
    whole = more[2 * count]
    rest = more[2 * count + 1]
    new = np.full(count, -1)
    total = count
    for k in range(count):
        more[k] = walls[k]
        if walls[k].points < 2 * min_points:
            continue
        combine(whole, parts[k, 0], parts[k, 1], 1.0)
        combine(whole, whole, parts[k, 2], 1.0)
        solve(whole)
        best = STEP_PRICE
        for p in range(PARTS):
            part = parts[k, p]
            combine(rest, whole, part, -1.0)
            if min(part.points, rest.points) < min_points:
                continue
            solve(part)
            solve(rest)
            saved = whole.chi2 - part.chi2 - rest.chi2
            step = LEAST * part.points * rest.points / whole.points
            if saved > max(best, step):
                best = saved
                rest.first = part.last if part.first == walls[k].first else walls[k].first
                rest.last = part.first if part.last == walls[k].last else walls[k].last
                more[k] = rest
                more[total] = part
                new[k] = total
        total += new[k] >= 0
    for i in range(label.size):
        k = label[i]
        if k >= 0 and new[k] >= 0 and more[new[k]].first <= i < more[new[k]].last:
            label[i] = new[k]
    return more[:total]


@helper
def excursions(points: Sequence, label: IntArray, walls: Walls) -> IntArray:
    """Return the returns where the sum of each wall's offsets is at its extremes, (K, 2).

    There its returns step (the cumulative sum of Page 1954).
    """
    count = walls.size
    total = np.zeros(count)
    extremes = np.zeros((count, 2))
    at = np.full((count, 2), -1)
    for i in range(label.size):
        k = label[i]
        if k < 0:
            continue
        cosine = points.ux[i] * walls[k].c + points.uy[i] * walls[k].s
        off = points.x[i] * walls[k].c + points.y[i] * walls[k].s - walls[k].d
        total[k] += off / (points.variance[i] * (cosine * cosine + points.floor[i]))
        if total[k] < extremes[k, 0]:
            extremes[k, 0] = total[k]
            at[k, 0] = i
        elif total[k] > extremes[k, 1]:
            extremes[k, 1] = total[k]
            at[k, 1] = i
    return at


@helper
def parts_of(points: Sequence, label: IntArray, walls: Walls, at: IntArray) -> Walls:
    """Return the sums of each wall's returns before, between and after two of them, (K, PARTS)."""
    parts = np.zeros((walls.size, PARTS), WALL)
    for i in range(label.size):
        k = label[i]
        if k >= 0:
            p = int(i > at[k, 0]) + int(i > at[k, 1])
            add_return(points, i, walls[k], parts[k, p], True)
    return parts
