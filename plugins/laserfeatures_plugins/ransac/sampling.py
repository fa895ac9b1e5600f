"""The kernels: draw two points, score their line, grow a wall from the best, repeat."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import helper, inlined, kernel
from laserfeatures.geometry.growth import find_wall, gate_of
from laserfeatures.geometry.noise import MIN_SIGMA
from laserfeatures.geometry.settle import Found, free_points, settle
from laserfeatures.geometry.walls import FREE, Cut, keep_wall

ENOUGH = 15  # degrees of freedom from which the walls tell it better
FAILURES = 8  # lines in a row that are no walls, after which there are none left
MODULUS = 2**31 - 1  # of the random numbers: Park and Miller (1988), "minimal standard"
MULTIPLIER = 48271

Sampling = tuple[int, float, int, int]  # window, log(1 - confidence), max_trials, seed
Line = tuple[float, float, float]  # cosine and sine of theta, d


@kernel
def extract(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    sampling: Sampling,
    jump: float,
    radius: float,
    cut: Cut,
) -> Found:
    """Return what `line_segments` takes; `sigma` 0 stands for unknown."""
    x, y, beam, owner, noise = free_points(directions, ranges, limits, sigma, jump, radius)
    gate = gate_of(noise)
    walls, noise = search(x, y, beam, owner, noise, sigma > 0.0, sampling, cut)
    return settle(x, y, beam, ranges.size, owner, walls, noise, gate, False, cut)


@inlined
def search(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    sigma: float,
    known: bool,
    sampling: Sampling,
    cut: Cut,
) -> tuple[FloatArray, float]:
    """Find walls one after another; fill `owner`. Returns them and the noise they show.

    A line that is no wall costs its first point the right to be drawn again.
    """
    walls = np.empty((x.size // cut[0] + 1, 6))
    pool = np.empty(x.size, np.int64)
    members = np.empty(x.size, np.int64)
    drawn_in_vain = np.zeros(x.size, np.bool_)
    random = 1 + sampling[3] % (MODULUS - 1)
    most_noise = 2.0 * sigma
    squares = freedom = 0.0
    count = failures = 0
    while failures < FAILURES:
        free = 0
        for i in range(x.size):
            if owner[i] == FREE and not drawn_in_vain[i]:
                pool[free] = i
                free += 1
        if free < cut[0]:
            break
        seed, theta, inliers, random = best_line(
            x, y, beam, pool[:free], gate_of(sigma), sampling, random
        )
        if inliers < cut[0]:
            break
        n, fit, variance = find_wall(x, y, beam, owner, seed, theta, 0.0, sigma, cut, members)
        if n == 0:
            drawn_in_vain[seed] = True
            failures += 1
            continue
        failures = 0
        for i in members[:n]:
            owner[i] = count
        keep_wall(walls[count], fit, n)
        count += 1
        squares += variance * (n - 2)
        freedom += n - 2
        if freedom >= ENOUGH and not known:
            sigma = min(max(math.sqrt(squares / freedom), MIN_SIGMA), most_noise)
    return walls[:count], sigma


@helper
def best_line(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    pool: IntArray,
    gate: float,
    sampling: Sampling,
    random: int,
) -> tuple[int, float, int, int]:
    """Return a point of the best line through two, its theta, its inliers and the random state.

    Lines are scored by MSAC (Torr and Zisserman 2000): the sum of squared distances, none counted
    for more than the gate's. Samples are drawn until a good one has come with the confidence asked.
    """
    window, log_doubt, max_trials, _ = sampling
    worth = 0.0  # the most that a line may cost and be better
    for _ in pool:
        worth += gate * gate
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
        cost, n, pairs = score(x, y, pool, line, gate, worth)
        if cost < worth:
            worth = cost
            best = line
            seed = pool[first]
            inliers = n
            good = pairs / pool.size if window > 0 else (n / pool.size) ** 2
            if good >= 1.0:
                break
            if good > 0.0:
                trials = min(trials, math.ceil(log_doubt / math.log(1.0 - good)))
    return seed, math.atan2(best[1], best[0]), inliers, random


@helper
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


@helper
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


@helper
def score(
    x: FloatArray, y: FloatArray, pool: IntArray, line: Line, gate: float, worth: float
) -> tuple[float, int, int]:
    """Return the cost of a line, its inliers and those of them that follow each other.

    Stops as soon as the cost exceeds `worth`.
    """
    c, s, d = line
    most = gate * gate
    cost = 0.0
    n = pairs = 0
    before = False
    for i in pool:
        off = x[i] * c + y[i] * s - d
        square = off * off
        inlier = square < most
        n += inlier
        pairs += inlier & before
        before = inlier
        cost += min(square, most)
        if cost > worth:
            break
    return cost, n, pairs
