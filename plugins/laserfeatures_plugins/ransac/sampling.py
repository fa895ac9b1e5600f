"""The kernels: draw two points, score their line, grow a wall from the best, repeat."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.engine import kernel, leaf
from laserfeatures.engine.candidates import add, grow
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.sequence import as_sequence

LEAST = 4  # points of a wall
SIGMAS = 3.0  # standard deviations of the noise within which a point is an inlier
SCORED = 128  # points that a line is scored by, about: every k-th of those on no wall
FAILURES = 8  # lines in a row that are no walls, after which there are none left
MODULUS = 2**31 - 1  # of the random numbers: Park and Miller (1988), "minimal standard"
MULTIPLIER = 48271

Sampling = tuple[int, float, int, int]  # window, log(1 - confidence), max_trials, seed
Line = tuple[float, float, float]  # cosine and sine of theta, d


@kernel
def propose(table: FloatArray, sampling: Sampling, max_missed: int) -> FloatArray:
    """Return the lines found one after another, (COLUMNS, K).

    A line that is no wall costs its first point the right to be drawn again.
    """
    points = as_sequence(table)
    n = points.x.size
    lines = np.empty((COLUMNS, n // LEAST + 1))
    taken = np.zeros(n, np.bool_)
    drawn_in_vain = np.zeros(n, np.bool_)
    pool = np.empty(n, np.int64)
    beam = np.empty(n, np.int64)
    sample = np.empty((2, n))
    noise = 0.0
    for i in range(n):
        beam[i] = int(points.beam[i])
        noise += points.variance[i]
    gate = SIGMAS * math.sqrt(noise / max(n, 1))
    random = 1 + sampling[3] % (MODULUS - 1)
    count = failures = 0
    while failures < FAILURES and count < lines.shape[1]:
        free = 0
        for i in range(n):
            if not taken[i] and not drawn_in_vain[i]:
                pool[free] = i
                free += 1
        if free < LEAST:
            break
        seed, line, inliers, random = best_line(
            points.x, points.y, beam, pool[:free], sample, gate, sampling, random
        )
        if inliers < LEAST:
            break
        wall = grow(points, taken, seed, line[0], line[1], line[2], gate, max_missed)
        if wall.saved > 0.0:
            add(points, taken, wall, lines, count)
            count += 1
            failures = 0
        else:
            failures += 1
        drawn_in_vain[seed] = True
    return lines[:, :count].copy()


@leaf
def best_line(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    pool: IntArray,
    sample: FloatArray,
    gate: float,
    sampling: Sampling,
    random: int,
) -> tuple[int, Line, int, int]:
    """Return a point of the best line through two, that line, its inliers and the random state.

    Lines are scored by MSAC (Torr and Zisserman 2000): the sum of squared distances, none counted
    for more than the gate's. Samples are drawn until a good one has come with the confidence asked.
    `sample` is room for the points that they are scored by.
    """
    window, log_doubt, max_trials, _ = sampling
    every = max(pool.size // SCORED, 1)
    size = 0
    worth = 0.0  # the most that a line may cost and be better
    for a in range(0, pool.size, every):
        sample[0, size] = x[pool[a]]
        sample[1, size] = y[pool[a]]
        worth += gate * gate
        size += 1
    best = (1.0, 0.0, 0.0)
    seed = -1
    inliers = 0
    trials = max_trials
    trial = 0
    while trial < trials:
        trial += 1
        random = random * MULTIPLIER % MODULUS
        first = random % pool.size
        random = random * MULTIPLIER % MODULUS
        second = partner(beam, pool, first, window, random)
        line = line_through(x, y, pool[first], pool[second])
        cost, n, pairs = score(sample, size, line, gate, worth)
        if cost < worth:
            worth = cost
            best = line
            seed = pool[first]
            inliers = n * every
            good = pairs / size if window > 0 else (n / size) ** 2
            if good >= 1.0:
                break
            if good > 0.0:
                trials = min(trials, math.ceil(log_doubt / math.log(1.0 - good)))
    return seed, best, inliers, random


@leaf
def partner(beam: IntArray, pool: IntArray, first: int, window: int, random: int) -> int:
    """Return another place in the pool: within `window` beams of `first`, or anywhere if it is 0.

    Where no other is so near, it is the next one.
    """
    low = first
    high = first
    if window > 0:
        here = beam[pool[first]]
        while low > 0 and here - beam[pool[low - 1]] <= window:
            low -= 1
        while high < pool.size - 1 and beam[pool[high + 1]] - here <= window:
            high += 1
        if low == high:
            return first - 1 if first > 0 else first + 1
    else:
        low = 0
        high = pool.size - 1
    second = low + random % (high - low)
    return second + (second >= first)


@leaf
def line_through(x: FloatArray, y: FloatArray, i: int, j: int) -> Line:
    """Return cosine and sine of theta, and d, of the line through two points."""
    dx = x[j] - x[i]
    dy = y[j] - y[i]
    length = math.sqrt(dx * dx + dy * dy)
    if length == 0.0:
        return 1.0, 0.0, math.inf
    c = -dy / length
    s = dx / length
    return c, s, x[i] * c + y[i] * s


@leaf
def score(
    sample: FloatArray, size: int, line: Line, gate: float, worth: float
) -> tuple[float, int, int]:
    """Return the cost of a line, its inliers and those of them that follow each other.

    Stops as soon as the cost exceeds `worth`.
    """
    c, s, d = line
    most = gate * gate
    cost = 0.0
    n = pairs = 0
    before = False
    for i in range(size):
        off = sample[0, i] * c + sample[1, i] * s - d
        square = off * off
        inlier = square < most
        n += inlier
        pairs += inlier & before
        before = inlier
        cost += min(square, most)
        if cost > worth:
            break
    return cost, n, pairs
