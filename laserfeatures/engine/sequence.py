"""The returns of a scan in the order in which they are explained (steps 1 and 2)."""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.compiled import ZERO, helper, leaf

OPEN, RING, DOUBLED = range(3)  # a scan's beams end, go round, or go round with the first twice
GRAZING = math.tan(math.radians(80.0))  # a steeper step than a wall met at that is a jump
NOISES = 5.0  # standard deviations of a step that noise may make
FARTHEST = 1e9  # [m]; beyond, squares of squares overflow
MISSED = 4  # beams without a return beyond which the next one jumps, too
OFTEN = 5  # beams that show one and the same range
STEPS = 4.0  # of the ranges' resolution by which a wall differs from a constant
LONE = 2.0  # a stray return is this many times as far from its neighbours as they from each other

# What does not vanish of the range variance where a wall is met at grazing incidence: the width
# and the angle of the beam err, too.
INCIDENCE_FLOOR = 0.02
LIKENESS = 0.1  # of neighbours' errors that quantised ranges and uneven walls show, too
LASTING = 400.0  # variance of errors that last, in those of a range, for a correlation of 1
LONG = 100.0  # returns of a surface over which they do so; over fewer they stray less
STRAYING = 1.7  # to this power of how many


class Noise(NamedTuple):
    """The noise of a scan; the variance of a range r is sigma^2 + (relative r)^2."""

    sigma: float  # standard deviation of a range [m]; negative: not known
    relative: float  # what it grows by with the range [m/m]
    roughness: float  # standard deviation of walls from planes [m]
    correlation: float  # how alike the errors of neighbouring ranges are; 0: independent


class Sequence(NamedTuple):
    """Returns in beam order, those of a ring from a jump on; (P,) arrays, rows of one table."""

    x: FloatArray  # [m]
    y: FloatArray  # [m]
    ux: FloatArray  # unit vector along the beam
    uy: FloatArray
    variance: FloatArray  # of the range [m^2]
    weight: FloatArray  # r^2 / variance
    floor: FloatArray  # variance across a wall that is met at grazing incidence, in range variances
    jump: FloatArray  # 1 where the return does not go on on the surface of the one before
    beam: FloatArray  # number of the beam; in a ring it goes on counting past the last
    source: FloatArray  # number of the beam in the scan
    lasting: FloatArray  # what of the floor stands for errors that last over many returns


ROWS = len(Sequence._fields)


@helper
def as_sequence(table: FloatArray) -> Sequence:
    """Name the rows of a table (ROWS, P)."""
    return Sequence(
        table[0], table[1], table[2], table[3], table[4], table[5], table[6], table[7], table[8],
        table[9], table[10],
    )  # fmt: skip


@helper
def in_order(
    directions: FloatArray, ranges: FloatArray, limits: tuple[float, float], ring: int
) -> FloatArray:
    """Return the table of the valid returns with x, y, ux, uy, beam and source filled in."""
    beams = ranges.size
    valid = np.empty(beams, np.int64)
    count = ZERO
    for i in range(beams):
        if limits[0] <= ranges[i] < limits[1] and 0.0 < ranges[i] < FARTHEST:
            valid[count] = i
            count += 1
    count = without_constant(directions, ranges, valid, count)
    period = beams
    if ring == DOUBLED:
        period = beams - 1
        if count > 1 and valid[0] == 0 and valid[count - 1] == period:
            count -= 1  # the same direction counts once
    start = 0
    if ring != OPEN and count > 0:
        start = seam(directions, ranges, valid[:count])
    table = np.empty((ROWS, count))
    place(as_sequence(table), directions, ranges, valid, start, period)
    return table


@leaf
def place(
    points: Sequence,
    directions: FloatArray,
    ranges: FloatArray,
    valid: IntArray,
    start: int,
    period: int,
) -> None:
    """Fill in the returns, the `valid` ones from place `start` on."""
    count = points.x.size
    for m in range(count):
        at = m + start
        turn = 0
        if at >= count:
            at -= count
            turn = period
        i = valid[at]
        points.x[m] = ranges[i] * directions[i, 0]
        points.y[m] = ranges[i] * directions[i, 1]
        points.ux[m] = directions[i, 0]
        points.uy[m] = directions[i, 1]
        points.beam[m] = i + turn
        points.source[m] = i


@leaf
def without_constant(
    directions: FloatArray, ranges: FloatArray, valid: IntArray, count: int
) -> int:
    """Take the returns of the largest range out of `valid` where that stands for no return.

    It does where it comes so often that no wall could give it: one that is met head on at r is
    farther by r turn^2 / 8 at the ends of a turn. Returns how many are left.
    """
    farthest = before = 0.0
    resolution = math.inf
    for m in range(count):
        r = ranges[valid[m]]
        farthest = max(farthest, r)
        change = abs(r - before)
        if 1e-9 * r < change < resolution:
            resolution = change
        before = r
    constant = 0
    for m in range(count):
        constant += ranges[valid[m]] == farthest
    if constant < OFTEN:
        return count
    step = directions[0, 0] * directions[1, 1] - directions[0, 1] * directions[1, 0]
    if farthest * (constant * step) ** 2 / 8.0 <= STEPS * resolution:
        return count
    left = 0
    for m in range(count):
        valid[left] = valid[m]
        left += ranges[valid[m]] < farthest
    return left


@leaf
def seam(directions: FloatArray, ranges: FloatArray, valid: IntArray) -> int:
    """Return where to cut a ring: at the widest jump, or step where nothing jumps.

    It is the same place whatever the first beam is.
    """
    widest = -1.0
    jumps = False
    start = 0
    for m in range(valid.size):
        i = valid[m - 1]
        j = valid[m]
        cross = directions[i, 0] * directions[j, 1] - directions[i, 1] * directions[j, 0]
        dot = directions[i, 0] * directions[j, 0] + directions[i, 1] * directions[j, 1]
        nearer = min(ranges[i], ranges[j])
        jump = abs(ranges[j] - ranges[i]) > GRAZING * nearer * abs(cross)
        if jumps and not jump:
            continue
        square = ranges[i] ** 2 + ranges[j] ** 2 - 2.0 * ranges[i] * ranges[j] * dot
        if square > widest or (jump and not jumps):
            widest = square
            start = m
        jumps |= jump
    return start


@leaf
def weigh(points: Sequence, noise: Noise) -> None:
    """Fill in what follows from the noise: variance, weight, floor and jump."""
    rough = noise.roughness * noise.roughness
    before = math.inf
    for i in range(points.x.size):
        r = points.x[i] * points.ux[i] + points.y[i] * points.uy[i]
        variance = noise.sigma * noise.sigma + noise.relative * noise.relative * r * r
        points.variance[i] = variance
        points.weight[i] = r * r / variance
        points.lasting[i] = 0.0
        points.floor[i] = INCIDENCE_FLOOR + rough / variance
        points.jump[i] = 1.0
        if i > 0:
            cross = points.ux[i - 1] * points.uy[i] - points.uy[i - 1] * points.ux[i]
            step = abs(r - before) - GRAZING * min(r, before) * abs(cross)
            near = step <= 0.0 or step**2 <= NOISES**2 * (variance + points.variance[i - 1])
            if near and points.beam[i] - points.beam[i - 1] <= MISSED:
                points.jump[i] = 0.0
        before = r
    if noise.correlation > LIKENESS:
        strayed = min(run_length(points) / LONG, 1.0) ** STRAYING
        lasting = LASTING * (noise.correlation - LIKENESS) * strayed
        for i in range(points.x.size):
            points.lasting[i] = lasting
            points.floor[i] += lasting


@leaf
def run_length(points: Sequence) -> float:
    """Return how many returns a surface has from jump to jump, in the mean over the returns."""
    total = run = 0.0
    for i in range(points.x.size):
        if points.jump[i] > 0.0:
            total += run * run
            run = 0.0
        run += 1.0
    return (total + run * run) / max(points.x.size, 1)


@helper
def without_lone(table: FloatArray) -> FloatArray:
    """Return the table without returns that stand out alone: no surface can be told from one."""
    kept = move_up(table, as_sequence(table))
    return table[:, :kept].copy() if kept < table.shape[1] else table


@leaf
def move_up(table: FloatArray, points: Sequence) -> int:
    """Move the other returns up to the places of lone ones; return how many are left."""
    n = points.x.size
    kept = min(n, 1)
    for i in range(1, n):
        if i < n - 1 and points.jump[i] > 0.0 and points.jump[i + 1] > 0.0 and is_lone(points, i):
            # The next return goes on from the one before this.
            points.jump[i + 1] = points.jump[i + 1] * step_jumps(points, i - 1, i + 1)
            continue
        if kept < i:
            for row in range(ROWS):
                table[row, kept] = table[row, i]
        kept += 1
    return kept


@leaf
def is_lone(points: Sequence, i: int) -> bool:
    """Tell whether a return stands out between its neighbours, which are near each other."""
    before = (points.x[i] - points.x[i - 1]) ** 2 + (points.y[i] - points.y[i - 1]) ** 2
    after = (points.x[i] - points.x[i + 1]) ** 2 + (points.y[i] - points.y[i + 1]) ** 2
    over = (points.x[i + 1] - points.x[i - 1]) ** 2 + (points.y[i + 1] - points.y[i - 1]) ** 2
    return bool(min(before, after) > LONE * LONE * over)


@leaf
def step_jumps(points: Sequence, i: int, j: int) -> float:
    """Return 1 where the step from return i to j is a jump, 0 where it is none."""
    r = points.x[i] * points.ux[i] + points.y[i] * points.uy[i]
    s = points.x[j] * points.ux[j] + points.y[j] * points.uy[j]
    cross = points.ux[i] * points.uy[j] - points.uy[i] * points.ux[j]
    step = abs(s - r) - GRAZING * min(r, s) * abs(cross)
    near = step <= 0.0 or step**2 <= NOISES**2 * (points.variance[i] + points.variance[j])
    return 0.0 if near and points.beam[j] - points.beam[i] <= MISSED else 1.0


@helper
def turned(table: FloatArray, start: int, period: int) -> FloatArray:
    """Return the table of a ring begun at another return."""
    n = table.shape[1]
    out = np.empty((ROWS, n))
    for row in range(ROWS):
        for i in range(n):
            out[row, i] = table[row, (i + start) % n]
    points = as_sequence(out)
    for i in range(n - start, n):
        points.beam[i] += period
    points.jump[n - start] = step_jumps(points, n - start - 1, n - start)
    points.jump[0] = 1.0
    return out
