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
from laserfeatures.engine.arcs import SHORTEST_ARC, arc_misfit
from laserfeatures.compiled import helper
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.sums import wall_misfit

OBLIQUE = 2.0  # price per log(1 / cos^2 of the incidence): few lines point at the sensor
DOUBT = 9.0  # what candidates leave unexplained before other walls are looked for
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


class Candidates(NamedTuple):
    """Lines that a detector proposes, (K,) arrays: cosine and sine of theta, d, and their run."""

    c: FloatArray
    s: FloatArray
    d: FloatArray  # [m]
    first: FloatArray  # the returns first .. last - 1 are on the line, or some of them
    last: FloatArray


COLUMNS = len(Candidates._fields)


@helper
def as_candidates(table: FloatArray) -> Candidates:
    """Name the rows of a table (COLUMNS, K)."""
    return Candidates(table[0], table[1], table[2], table[3], table[4])


class Best(NamedTuple):
    """The cheapest explanation of the first j returns, (P + 1,) arrays."""

    cost: FloatArray
    start: IntArray  # where its last piece begins
    kind: IntArray  # what that is
    line: IntArray  # and on which candidate


@helper
def partition(
    points: Sequence, sums: FloatArray, lines: Candidates, limits: Limits, label: IntArray
) -> int:
    """Label each return with its wall, `STRAY` or `ARC`; return the number of walls.

    Walls count on from the candidates, whose own numbers may remain without returns.
    """
    n = points.x.size
    best = Best(
        np.empty(n + 1), np.empty(n + 1, np.int64), np.empty(n + 1, np.int64),
        np.empty(n + 1, np.int64),
    )  # fmt: skip
    best.cost[0] = 0.0
    known = lines.c.size
    order = np.argsort(lines.first)
    active = np.empty(known, np.int64)  # the candidates that may explain the return at hand
    through = np.empty(known)  # cost of the cheapest explanation that ends on each
    entered = np.empty(known, np.int64)
    doubt = np.zeros(n + 1)
    starts = np.empty(n + 1, np.int64)
    near = coming = alive = edge = 0
    for j in range(1, n + 1):
        i = j - 1
        best.cost[j] = best.cost[i] + STRAY_PRICE
        best.start[j] = i
        best.kind[j] = AS_STRAY
        while coming < known and lines.first[order[coming]] - PAD <= i:
            active[near] = order[coming]
            through[order[coming]] = math.inf
            near += 1
            coming += 1
        near, left = follow_lines(points, lines, active, near, through, entered, i, best)
        doubt[j] = doubt[i] + max(left - DOUBTFUL, 0.0)
        starts[alive] = i
        alive += 1
        needed = DOUBT if known > 0 else -1.0
        alive = end_wall(points, sums, limits, starts, alive, doubt, needed, j, best)
        if j == n or points.jump[j] > 0.0:
            if limits.max_pole_radius > 0.0 and j - edge >= SHORTEST_ARC:
                cost = best.cost[edge] + ARC_PRICE
                if cost < best.cost[j]:
                    cost += arc_misfit(points, edge, j, limits.max_pole_radius)
                if cost < best.cost[j]:
                    best.cost[j] = cost
                    best.start[j] = edge
                    best.kind[j] = AS_ARC
            edge = j
    return trace(best, known, label)


@helper
def follow_lines(
    points: Sequence,
    lines: Candidates,
    active: IntArray,
    near: int,
    through: FloatArray,
    entered: IntArray,
    i: int,
    best: Best,
) -> tuple[int, float]:
    """Take return i along the candidates; return how many go on, and the least chi squared."""
    x = points.x[i]
    y = points.y[i]
    ux = points.ux[i]
    uy = points.uy[i]
    least = STRAY_PRICE
    enter = best.cost[i] + PRICE
    kept = 0
    for a in range(near):
        k = active[a]
        if i >= lines.last[k] + PAD:
            continue
        active[kept] = k
        kept += 1
        off = x * lines.c[k] + y * lines.s[k] - lines.d[k]
        cosine = ux * lines.c[k] + uy * lines.s[k]
        chi2 = off * off / (points.variance[i] * (cosine * cosine + points.floor[i]))
        least = min(least, chi2)
        if enter < through[k]:
            through[k] = enter
            entered[k] = i
        through[k] += min(chi2, STRAY_PRICE)  # an outlier is no end of a wall
        if through[k] < best.cost[i + 1]:
            best.cost[i + 1] = through[k]
            best.start[i + 1] = entered[k]
            best.kind[i + 1] = AS_LINE
            best.line[i + 1] = k
    return kept, least


@helper
def end_wall(
    points: Sequence,
    sums: FloatArray,
    limits: Limits,
    starts: IntArray,
    alive: int,
    doubt: FloatArray,
    needed: float,
    j: int,
    best: Best,
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
        misfit, oblique = wall_misfit(sums, i, j)
        cost = best.cost[i] + misfit
        if cost + PRICE < best.cost[j]:
            whole = cost + PRICE + OBLIQUE * math.log(oblique)
            if whole < best.cost[j]:
                best.cost[j] = whole
                best.start[j] = i
                best.kind[j] = AS_WALL
        if cost >= best.cost[j]:
            continue  # whatever comes, a start at j does better
        if age > RECENT and points.jump[i] == 0.0:
            if cost >= best.cost[j] - BEHIND:
                continue
            step = 1
            while age > RECENT:
                age >>= 1
                step <<= 1
            if a > 1 and i & (step - 1) > 0:
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


@helper
def trace(best: Best, known: int, label: IntArray) -> int:
    """Follow the cheapest explanation back and label the returns; return the number of walls."""
    j = label.size
    count = known
    while j > 0:
        i = best.start[j]
        wall = STRAY
        if best.kind[j] == AS_LINE:
            wall = best.line[j]
        elif best.kind[j] == AS_ARC:
            wall = ARC
        elif best.kind[j] == AS_WALL:
            wall = count
            count += 1
        for m in range(i, j):
            label[m] = wall
        j = i
    return count
