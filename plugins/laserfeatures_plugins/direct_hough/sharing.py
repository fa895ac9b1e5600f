"""Kernels that settle which wall each point belongs to: merge pieces, share corners out."""

import math

import numpy as np
from numba import njit

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import INCIDENCE_FLOOR, fit_line, solve_line
from laserfeatures_plugins.direct_hough.walls import FLATNESS, is_wall

NEIGHBOURHOOD = 4  # points beside the end of a wall that may belong to the next one
ROUNDS = 3  # of sharing points out and refitting


@njit(cache=True)
def off_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float, d: float) -> float:
    """Return the root mean square distance of `members` from a line [m]."""
    c = math.cos(theta)
    s = math.sin(theta)
    total = 0.0
    for i in members:
        total += (x[i] * c + y[i] * s - d) ** 2
    return math.sqrt(total / members.size)


@njit(cache=True)
def may_be_one(a: FloatArray, b: FloatArray, sigma: float) -> bool:
    """Tell whether two walls lie within four standard deviations of one line."""
    turn = b[0] - a[0]
    d = b[1]
    if abs(turn) > 0.5 * math.pi:  # theta wraps: the same line has -d beyond 0 and pi
        turn -= math.copysign(math.pi, turn)
        d = -d
    shift = abs(d - a[1])
    turned = abs(turn) > 4.0 * math.sqrt(a[2] + b[2]) + 0.01
    return not (turned or shift > 4.0 * math.sqrt(a[4] + b[4] + sigma * sigma))


@njit(cache=True)
def merge_pieces(
    x: FloatArray, y: FloatArray, owner: IntArray, walls: FloatArray, sigma: float
) -> None:
    """Join walls that one line explains, in place: the pieces beside a door are one line."""
    bound = max(1.5 * sigma, FLATNESS)
    for a in range(walls.shape[0]):
        for b in range(a + 1, walls.shape[0]):
            if walls[a, 5] == 0 or walls[b, 5] == 0 or not may_be_one(walls[a], walls[b], sigma):
                continue
            mine = np.flatnonzero(owner == a)
            other = np.flatnonzero(owner == b)
            both = np.concatenate((mine, other))
            fit = fit_line(x, y, both, walls[a, 0], sigma)
            if (
                off_line(x, y, mine, fit[0], fit[1]) < bound
                and off_line(x, y, other, fit[0], fit[1]) < bound
                and is_wall(x, y, both, fit, sigma)[0]
            ):
                owner[other] = a
                walls[a, 0], walls[a, 1], walls[a, 2], walls[a, 3], walls[a, 4] = fit
                walls[a, 5] = both.size
                walls[b, 5] = 0


@njit(cache=True)
def share_points(
    x: FloatArray, y: FloatArray, owner: IntArray, walls: FloatArray, min_points: int, sigma: float
) -> None:
    """Give the points at the ends of walls to the nearest wall and refit, in place.

    A wall that loses too many of its points is dropped.
    """
    cos = np.cos(walls[:, 0])
    sin = np.sin(walls[:, 0])
    for sharing in range(ROUNDS):
        if not give_to_nearest(x, y, owner, walls, cos, sin) and sharing > 0:
            break
        sums = np.zeros((walls.shape[0], 7))
        for i in range(x.size):
            k = owner[i]
            if k >= 0:
                normal = x[i] * cos[k] + y[i] * sin[k]
                w = 1.0 / (normal * normal / (x[i] * x[i] + y[i] * y[i]) + INCIDENCE_FLOOR)
                z = sums[k]
                z[0] += w
                z[1] += w * x[i]
                z[2] += w * y[i]
                z[3] += w * x[i] * x[i]
                z[4] += w * x[i] * y[i]
                z[5] += w * y[i] * y[i]
                z[6] += 1.0
        for k in range(walls.shape[0]):
            z = sums[k]
            walls[k, 5] = z[6]
            if z[6] >= min_points:
                fit = solve_line(z[0], z[1], z[2], z[3], z[4], z[5], sigma)
                walls[k, 0], walls[k, 1], walls[k, 2], walls[k, 3], walls[k, 4] = fit
                cos[k] = math.cos(fit[0])
                sin[k] = math.sin(fit[0])


@njit(cache=True)
def give_to_nearest(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
) -> bool:
    """Move each point near the end of its wall to the neighbouring wall if that is nearer."""
    moved = False
    for i in range(x.size):
        own = owner[i]
        low = max(0, i - NEIGHBOURHOOD)
        high = min(x.size - 1, i + NEIGHBOURHOOD)
        if own < 0 or owner[low] == own == owner[high]:
            continue
        least = abs(x[i] * cos[own] + y[i] * sin[own] - walls[own, 1])
        for j in range(low, high + 1):
            k = owner[j]
            if k >= 0 and k != owner[i]:
                error = abs(x[i] * cos[k] + y[i] * sin[k] - walls[k, 1])
                if error < least:
                    least = error
                    owner[i] = k
                    moved = True
    return moved
