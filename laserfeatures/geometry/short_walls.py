"""Walls so short that what their neighbours took of them is what they lack."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper
from laserfeatures.geometry.fit import Fit, fit_line
from laserfeatures.geometry.segments import MAX_GROWTH, is_gap
from laserfeatures.geometry.walls import FREE, Cut, gather, is_wall, keep_wall

FEWEST = 2  # free points of a wall; the others are its neighbours' ends
NOISE = 1.5  # of the residuals, in standard deviations: so few points of anything are nearly flat
TURN = 0.1  # [rad]; standard deviation of the direction from which it says nothing


@helper
def add_short_walls(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    walls: FloatArray,
    sigma: float,
    cut: Cut,
) -> FloatArray:
    """Return the walls and those that runs of free points make with the points beside them.

    A long wall that is found first takes the nearest point of a short one behind a corner, which
    then lacks a point of the fewest that a wall may have. Here it gets one back from either side,
    whichever fits it best, where the long wall can spare it. `owner` follows.
    """
    last = -1
    for first in range(x.size):
        if first <= last or owner[first] != FREE:
            continue
        last = first
        while last + 1 < x.size and owner[last + 1] == FREE:
            last += 1
        if not FEWEST <= last - first + 1 < cut[0] + FEWEST:
            continue
        low, high, fit = best_wall(x, y, beam, owner, walls, first, last, sigma, cut)
        if low > high:
            continue
        more = np.empty((walls.shape[0] + 1, 6))
        more[:-1] = walls
        walls = more
        keep_wall(walls[-1], fit, high - low + 1)
        for i in range(low, high + 1):
            giver = owner[i]
            owner[i] = walls.shape[0] - 1
            if giver >= 0:
                refit(x, y, owner, walls, giver)
    return walls


@helper
def best_wall(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    walls: FloatArray,
    first: int,
    last: int,
    sigma: float,
    cut: Cut,
) -> tuple[int, int, Fit]:
    """Return the first and last point, and the fit, of the best wall of a run of free points.

    One more point on either side may belong to it. The last is before the first where none is a
    wall.
    """
    fit = best = (0.0, 0.0, 0.0, 0.0, 0.0)
    best_low, best_high = 0, -1
    least = (NOISE * sigma) ** 2
    before = first > 0 and spares(owner[first - 1], walls, cut[0])
    after = last + 1 < x.size and spares(owner[last + 1], walls, cut[0])
    for low in range(first - before, first + 1):
        for high in range(last, last + 1 + after):
            if high - low + 1 < cut[0]:
                continue
            if (
                low < first
                and high > last
                and not spares_two(owner[low], owner[high], walls, cut[0])
            ):
                continue
            members = np.arange(low, high + 1)
            guess = math.atan2(x[low] - x[high], y[high] - y[low])
            fit = fit_line(x, y, members, guess)
            if broken(x, y, beam, low, high, fit[0], cut):
                continue
            flat, variance, _ = is_wall(x, y, members, fit, sigma)
            if flat and variance < least and fit[2] * sigma * sigma < TURN * TURN:
                least = variance
                best_low, best_high, best = low, high, fit
    return best_low, best_high, best


@helper
def spares(own: int, walls: FloatArray, min_points: int) -> bool:
    """Tell whether a wall can lose a point."""
    return bool(own >= 0 and walls[own, 5] > min_points)


@helper
def spares_two(one: int, other: int, walls: FloatArray, min_points: int) -> bool:
    """Tell whether walls that can lose a point each can do so if they are the same."""
    return bool(one != other or walls[one, 5] > min_points + 1)


@helper
def refit(x: FloatArray, y: FloatArray, owner: IntArray, walls: FloatArray, wall: int) -> None:
    """Fit a wall to the points that it still has."""
    members = np.empty(x.size, np.int64)
    count = gather(owner, wall, members)
    keep_wall(walls[wall], fit_line(x, y, members[:count], walls[wall, 0]), count)


@helper
def broken(
    x: FloatArray, y: FloatArray, beam: IntArray, low: int, high: int, theta: float, cut: Cut
) -> bool:
    """Tell whether there is a gap between successive points."""
    c = math.cos(theta)
    s = math.sin(theta)
    spacing = math.inf
    for i in range(low + 1, high + 1):
        apart = beam[i] - beam[i - 1]
        spacing = min(spacing, abs((y[i] - y[i - 1]) * c - (x[i] - x[i - 1]) * s) / apart)
    for i in range(low + 1, high + 1):
        apart = beam[i] - beam[i - 1]
        step = abs((y[i] - y[i - 1]) * c - (x[i] - x[i - 1]) * s)
        if apart > cut[1] + 1 or is_gap(apart, step, spacing, cut[1], cut[2], MAX_GROWTH):
            return True
    return False
