"""The cheapest explanation of a scan: a sequence of walls, arcs and stray returns (step 4).

Dynamic programming over the returns: the cheapest explanation of the first j ends with a piece that
begins at some i, and what comes before is the cheapest one of the first i (optimal partitioning,
Jackson et al. 2005). Costs are in -2 log likelihood; starts that can no longer win are dropped
(Killick, Fearnhead and Eckley 2012), and those far back in one piece are thinned out.
"""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.compiled import ZERO, helper, inlined, leaf
from laserfeatures.engine.arcs import CONVEX, SHORTEST_ARC, arc_misfit
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.sums import wall_misfit

OBLIQUE = 2.0  # price per log(1 / cos^2 of the incidence): few lines point at the sensor
DOUBT = 9.0
DOUBTFUL = 3.0  # chi squared of a return from which its candidate leaves a doubt
PAD = 8  # returns on either side of a candidate's own that it may explain
RECENT = 8  # returns after which starts are thinned out: each time twice as sparse
BEHIND = 2.0  # that a start in the middle of a piece must save to be kept

STRAY = -1  # labels of returns: what nothing explains,
ARC = -2  # and what is round

AS_STRAY, AS_LINE, AS_WALL, AS_ARC = range(4)


class Limits(NamedTuple):
    """What a wall may be."""

    min_points: int
    max_missed: int
    max_gap: float  # [m]
    max_pole_radius: float  # [m]; 0: nothing is round
    longest: int  # returns of a wall that is no candidate
    roughness_told: bool  # else the walls of the scan tell it


class Candidates(NamedTuple):
    """Lines that a detector proposes, (K,) arrays: cosine and sine of theta, d, and their run."""

    c: FloatArray
    s: FloatArray
    d: FloatArray  # [m]
    first: FloatArray  # the returns first .. last - 1 are on the line, or some of them
    last: FloatArray


@helper
def as_limits(limits: tuple[int, int, float, float, int, bool]) -> Limits:
    """Name what Python passes as a plain tuple: a named one takes it 60 microseconds."""
    return Limits(limits[0], limits[1], limits[2], limits[3], limits[4], limits[5])


COLUMNS = len(Candidates._fields)


@helper
def as_candidates(table: FloatArray) -> Candidates:
    """Name the rows of a table (COLUMNS, K)."""
    return Candidates(table[0], table[1], table[2], table[3], table[4])


@helper
def partition(
    points: Sequence,
    sums: FloatArray,
    lines: Candidates,
    columns: IntArray,
    price: float,
    limits: Limits,
    label: IntArray,
) -> int:
    """Label each return with its wall, `STRAY` or `ARC`; return the number of walls.

    Walls count on from the candidates, whose own numbers may remain without returns.
    """
    n = points.x.size
    cost = np.empty(n + 1)  # of the cheapest explanation of the first j returns
    start = np.empty(n + 1, np.int64)  # where its last piece begins
    kind = np.empty(n + 1, np.int64)  # what that is
    line = np.empty(n + 1, np.int64)  # and on which candidate
    cost[0] = 0.0
    # Taken out of their tuples once: in the loop, that would count references each time.
    jump = points.jump
    first, last, c, s, d = lines.first, lines.last, lines.c, lines.s, lines.d
    x, y, ux, uy = points.x, points.y, points.ux, points.uy
    variance, floor = points.variance, points.floor
    known = first.size
    coming = np.full(n + 1, -1)  # of the candidates that begin at a return, one; and from each
    following = np.empty(known, np.int64)  # the next
    for k in range(known - 1, -1, -1):
        at = min(max(int(first[k]) - PAD, 0), n)
        following[k] = coming[at]
        coming[at] = k
    active = np.empty(known, np.int64)  # the candidates that may explain the return at hand
    through = np.empty(known)  # cost of the cheapest explanation that ends on each
    entered = np.empty(known, np.int64)
    doubt = np.zeros(n + 1)
    starts = np.empty(n + 1, np.int64)
    column = np.full(n + 1, -1)  # where that begins which ends there
    for k in range(columns.shape[1]):
        column[columns[1, k]] = columns[0, k]
    needed = DOUBT if known > 0 else -1.0
    near = alive = 0
    edge = ZERO
    for j in range(1, n + 1):
        i = j - 1
        cost[j] = cost[i] + STRAY_PRICE
        start[j] = i
        kind[j] = AS_STRAY
        k = coming[i]
        while k >= 0:
            active[near] = k
            through[k] = math.inf
            near += 1
            k = following[k]
        near, least = follow_lines(
            i, x[i], y[i], ux[i], uy[i], variance[i], floor[i], c, s, d, last, price, near, active,
            through, entered, cost, start, kind, line,
        )  # fmt: skip
        doubt[j] = doubt[i] + max(least - DOUBTFUL, 0.0)
        starts[alive] = i
        alive += 1
        if j - starts[0] >= limits.min_points and doubt[j] - doubt[starts[0]] >= needed:
            alive = end_wall(sums, jump, limits, starts, alive, doubt, needed, j, cost, start, kind)
        if column[j] >= 0:
            end_arc(points, limits.max_pole_radius, column[j], j, cost, start, kind)
        if j == n or jump[j] > 0.0:
            end_arc(points, limits.max_pole_radius, edge, j, cost, start, kind)
            edge = j
    return trace(start, kind, line, known, label)


@inlined
def follow_lines(
    i: int,
    x: float,
    y: float,
    ux: float,
    uy: float,
    variance: float,
    floor: float,
    c: FloatArray,
    s: FloatArray,
    d: FloatArray,
    last: FloatArray,
    price: float,
    near: int,
    active: IntArray,
    through: FloatArray,
    entered: IntArray,
    cost: FloatArray,
    start: IntArray,
    kind: IntArray,
    line: IntArray,
) -> tuple[int, float]:
    """Take return i along the candidates; return how many go on, and the least chi squared."""
    j = i + 1
    least = STRAY_PRICE
    kept = 0
    for a in range(near):
        k = active[a]
        if i >= last[k] + PAD:
            continue
        active[kept] = k
        kept += 1
        off = x * c[k] + y * s[k] - d[k]
        cosine = ux * c[k] + uy * s[k]
        chi2 = off * off / (variance * (cosine * cosine + floor))
        least = min(least, chi2)
        if cost[i] + price < through[k]:
            through[k] = cost[i] + price
            entered[k] = i
        through[k] += min(chi2, STRAY_PRICE)  # an outlier is no end of a wall
        if through[k] < cost[j]:
            cost[j] = through[k]
            start[j] = entered[k]
            kind[j] = AS_LINE
            line[j] = k
    return kept, least


@leaf
def end_arc(
    points: Sequence,
    max_radius: float,
    i: int,
    j: int,
    cost: FloatArray,
    start: IntArray,
    kind: IntArray,
) -> None:
    """Try a round object of the returns i..j-1."""
    if max_radius == 0.0 or j - i < SHORTEST_ARC or cost[i] + ARC_PRICE >= cost[j]:
        return
    whole = cost[i] + ARC_PRICE + arc_misfit(points, i, j, max_radius, CONVEX)
    if whole < cost[j]:
        cost[j] = whole
        start[j] = i
        kind[j] = AS_ARC


@inlined
def end_wall(
    sums: FloatArray,
    jump: FloatArray,
    limits: Limits,
    starts: IntArray,
    alive: int,
    doubt: FloatArray,
    needed: float,
    j: int,
    cost: FloatArray,
    start: IntArray,
    kind: IntArray,
) -> int:
    """Try walls that end before return j; return how many starts remain worth a try."""
    kept = a = 0
    while a < alive:
        i = starts[a]
        age = j - i
        if age < limits.min_points or doubt[j] - doubt[i] < needed:
            break  # so it is with all later starts
        a += 1
        if age > limits.longest:
            continue
        through = cost[i]
        if through + PRICE < cost[j]:  # else no wall from i can win yet, whatever its misfit
            misfit, oblique = wall_misfit(sums, i, j)
            through += misfit
            if through + PRICE < cost[j]:
                whole = through + PRICE + OBLIQUE * math.log(oblique)
                if whole < cost[j]:
                    cost[j] = whole
                    start[j] = i
                    kind[j] = AS_WALL
        if through >= cost[j]:
            continue  # whatever comes, a start at j does better
        if (
            age > RECENT
            and jump[i] == 0.0
            and (through >= cost[j] - BEHIND or (a > 1 and is_thinned_out(i, age)))
        ):
            continue
        starts[kept] = i
        kept += 1
    if kept == a:
        return alive
    while a < alive:
        starts[kept] = starts[a]
        kept += 1
        a += 1
    return kept


@inlined
def is_thinned_out(i: int, age: int) -> bool:
    """Tell whether a start so many returns back goes: each time twice as many do."""
    step = 1
    while age > RECENT:
        age >>= 1
        step <<= 1
    return i & (step - 1) > 0


@leaf
def trace(start: IntArray, kind: IntArray, line: IntArray, known: int, label: IntArray) -> int:
    """Follow the cheapest explanation back and label the returns; return the number of walls."""
    j = label.size
    count = known
    while j > 0:
        i = start[j]
        wall = STRAY
        if kind[j] == AS_LINE:
            wall = line[j]
        elif kind[j] == AS_ARC:
            wall = ARC
        elif kind[j] == AS_WALL:
            wall = count
            count += 1
        for m in range(i, j):
            label[m] = wall
        j = i
    return count
