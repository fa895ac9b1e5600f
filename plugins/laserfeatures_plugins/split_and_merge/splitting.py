"""The kernels: the scan broken where it jumps, the pieces split where they bend."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import Fit, helper, inlined, kernel
from laserfeatures.geometry.fit import fit_unweighted
from laserfeatures.geometry.growth import SIGMAS, gate_of
from laserfeatures.geometry.noise import MIN_SIGMA
from laserfeatures.geometry.settle import Found, free_points, settle
from laserfeatures.geometry.walls import FREE, Cut, is_wall, keep_wall

ENOUGH = 15  # degrees of freedom from which they do
SURE = 3.0  # gates that a point is off the chord by where no fit to the piece will do
TRIMMED = 6  # points from which a piece is fitted without those that it shares
SPIKE = 0.5  # of a point's distance from the chord that both its neighbours' stay under


@kernel
def extract(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    grazing: tuple[float, float],
    jump: float,
    radius: float,
    cut: Cut,
) -> Found:
    """Return what `line_segments` takes; `sigma` 0 stands for unknown."""
    x, y, beam, owner, noise = free_points(directions, ranges, limits, sigma, jump, radius)
    walls, seen = search(x, y, beam, owner, noise, grazing, cut)
    return settle(x, y, beam, ranges.size, owner, walls, sigma or seen, gate_of(noise), True, cut)


@inlined
def search(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    sigma: float,
    grazing: tuple[float, float],
    cut: Cut,
) -> tuple[FloatArray, float]:
    """Split each chain of points into walls; fill `owner`. Returns them and the noise they show."""
    least = cut[0] - 1  # one more may come when points are shared out
    walls = np.empty((x.size // (least - 1) + 1, 6))  # pieces share their ends
    chain = np.empty(x.size, np.int64)
    count = 0
    squares = np.zeros(2)
    gate = gate_of(sigma)
    start = 0
    while start < x.size:
        size, start = next_chain(x, y, beam, owner, start, sigma, grazing, cut[1], chain)
        if size >= least:
            count = split(x, y, chain[:size], owner, sigma, gate, cut[0], walls, count, squares)
    if squares[1] >= ENOUGH:
        sigma = min(max(math.sqrt(squares[0] / squares[1]), MIN_SIGMA), 2.0 * sigma)
    return walls[:count], sigma


@helper
def next_chain(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    start: int,
    sigma: float,
    grazing: tuple[float, float],
    max_missed: int,
    chain: IntArray,
) -> tuple[int, int]:
    """Put the points from `start` on into `chain` up to a break; return how many and what follows.

    Up to `max_missed` beams that lead away from both sides are left out.
    """
    while start < x.size and owner[start] != FREE:
        start += 1
    if start == x.size:
        return 0, start
    chain[0] = last = start
    size = 1
    i = start + 1
    while i < x.size:
        j = i
        while j < x.size and not (owner[j] == FREE and linked(x, y, last, j, sigma, grazing)):
            j += 1
            if j < x.size and beam[j] - beam[last] > max_missed + 1:
                j = x.size
        if j == x.size:
            break
        chain[size] = last = j
        size += 1
        i = j + 1
    return size, i


@helper
def linked(
    x: FloatArray, y: FloatArray, i: int, j: int, sigma: float, grazing: tuple[float, float]
) -> bool:
    """Tell whether point j may lie on the surface that point i is on.

    It may where a wall through i that the beams meet at an angle of `grazing` (its cosine and sine)
    or more, the noise added, gives no larger step (Borges and Aldon 2004).
    """
    square = x[i] * x[i] + y[i] * y[i]
    cross = x[i] * y[j] - y[i] * x[j]
    dot = x[i] * x[j] + y[i] * y[j]
    # The law of sines: step = r sin(turn) / sin(grazing - turn), with sin and cos of the turn
    # taken times r and the other range.
    below = grazing[1] * dot - grazing[0] * cross
    if below <= 0.0:
        return True
    step = (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2
    if step * below * below <= square * cross * cross:  # without the noise and the division
        return True
    most = math.sqrt(square) * cross / below + SIGMAS * sigma
    return bool(step <= most * most)


@helper
def split(
    x: FloatArray,
    y: FloatArray,
    chain: IntArray,
    owner: IntArray,
    sigma: float,
    gate: float,
    min_points: int,
    walls: FloatArray,
    count: int,
    squares: FloatArray,
) -> int:
    """Split a chain at the point farthest from its chord until each piece is a wall.

    Adds the walls to the table and returns their number; `squares` sums up their noise and its
    degrees of freedom. A lone point that sticks out is left out of its piece.
    """
    least = min_points - 1
    first = np.empty(chain.size + 1, np.int64)  # the pieces that are still to be looked at
    last = np.empty(chain.size + 1, np.int64)
    first[0] = 0
    end = chain.size - 1
    last[0] = end
    waiting = 1
    while waiting > 0:
        waiting -= 1
        a = first[waiting]
        b = last[waiting]
        while b - a + 1 >= least:
            corner, off = farthest(x, y, chain, a, b)
            if off > gate and is_spike(x, y, chain, a, b, corner, off):
                for m in range(corner, b):  # the end stays for the piece that starts there
                    chain[m] = chain[m + 1]
                end -= b == end
                b -= 1
                continue
            if off <= SURE * gate:
                # A point that two pieces share may be the other one's: it must not turn this one.
                trim = b - a + 1 >= TRIMMED
                inner = chain[a + (trim and a > 0) : b + 1 - (trim and b < end)]
                fit = fit_unweighted(x, y, inner)
                flat, variance, worst = is_wall(x, y, inner, fit, sigma)
                if worst <= gate:
                    if flat:
                        take(owner, chain[a : b + 1], walls, count, fit)
                        count += 1
                        squares[0] += variance * (inner.size - 2)
                        squares[1] += inner.size - 2
                    break
            first[waiting] = corner
            last[waiting] = b
            waiting += 1
            b = corner
    return count


@helper
def take(owner: IntArray, piece: IntArray, walls: FloatArray, wall: int, fit: Fit) -> None:
    """Make the points of a piece a wall's; a corner that two pieces share is the later one's."""
    for i in piece:
        if owner[i] >= 0:
            walls[owner[i], 5] -= 1
        owner[i] = wall
    keep_wall(walls[wall], fit, piece.size)


@helper
def farthest(x: FloatArray, y: FloatArray, chain: IntArray, a: int, b: int) -> tuple[int, float]:
    """Return the place in a chain that is farthest from the chord from a to b, and how far [m]."""
    i = chain[a]
    ux = x[chain[b]] - x[i]
    uy = y[chain[b]] - y[i]
    length = math.sqrt(ux * ux + uy * uy)
    if length == 0.0:  # a full turn that ends where it began
        return (a + b) // 2, 0.0
    most = -1.0
    place = a
    for m in range(a + 1, b):
        off = abs((x[chain[m]] - x[i]) * uy - (y[chain[m]] - y[i]) * ux)
        if off > most:
            most = off
            place = m
    return place, most / length


@helper
def is_spike(
    x: FloatArray, y: FloatArray, chain: IntArray, a: int, b: int, m: int, off: float
) -> bool:
    """Tell whether a place sticks out of a chain alone: both its neighbours are near the chord."""
    i = chain[a]
    ux = x[chain[b]] - x[i]
    uy = y[chain[b]] - y[i]
    length = math.sqrt(ux * ux + uy * uy)
    for k in (chain[m - 1], chain[m + 1]):
        if abs((x[k] - x[i]) * uy - (y[k] - y[i]) * ux) > SPIKE * off * length:
            return False
    return True
