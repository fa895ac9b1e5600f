"""The walls of a scan: fitted, merged, parted at their corners (steps 5 and 6)."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import IntArray
from laserfeatures.compiled import ZERO, helper, inlined, leaf
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.prices import STRAY_PRICE
from laserfeatures.engine.sequence import Sequence

WALL = np.dtype((np.record, [
    ("c", "f8"), ("s", "f8"), ("d", "f8"),  # the line x c + y s = d, s >= 0
    ("var_theta", "f8"), ("cov", "f8"), ("var_d", "f8"),  # its covariance,
    ("log_det", "f8"),  # and minus the logarithm of the determinant of that
    ("chi2", "f8"), ("points", "i8"), ("first", "i8"), ("last", "i8"),
    ("w", "f8"), ("x", "f8"), ("y", "f8"), ("xx", "f8"), ("xy", "f8"), ("yy", "f8"),  # as in `sums`
    ("evidence", "f8"),  # [nats]
]))  # fmt: skip
Wall = Any  # a record of `Walls`
Walls = NDArray[Any]  # (K,), of WALL

SURELY_APART = 25.0  # squared standard deviations of a turn,
SAME_TURN = 0.05**2  # and squared radians besides, beyond which walls are not compared
MEETING = 4  # returns between two walls that may meet
LEAST_SINE = math.sin(math.radians(10.0))  # flatter crossings are not known well enough
INLIER = 9.0  # chi squared of a return that may change walls


@inlined
def misfit(points: Sequence, i: int, c: float, s: float, d: float) -> float:
    """Return the chi squared of a return on a line."""
    off = points.x[i] * c + points.y[i] * s - d
    cosine = points.ux[i] * c + points.uy[i] * s
    return off * off / (points.variance[i] * (cosine * cosine + points.floor[i]))


@leaf
def solve(wall: Wall) -> None:
    """Fill in the line that the sums of a wall give, with its covariance to first order."""
    det = wall.xx * wall.yy - wall.xy * wall.xy
    if det <= 1e-12 * wall.xx * wall.yy:  # in line with the sensor
        wall.chi2 = math.inf
        wall.log_det = 0.0
        return
    a = (wall.x * wall.yy - wall.y * wall.xy) / det
    b = (wall.y * wall.xx - wall.x * wall.xy) / det
    wall.chi2 = max(wall.w - a * wall.x - b * wall.y, 0.0)
    if a == 0.0 and b == 0.0:  # returns all round the sensor
        wall.chi2 = math.inf
        wall.log_det = 0.0
        return
    d = 1.0 / math.sqrt(a * a + b * b)
    c = a * d
    s = b * d
    # With (A, B) = (c, s) / d: dtheta = d (c dB - s dA) and dd = -d^2 (c dA + s dB).
    aa = wall.yy / det
    ab = -wall.xy / det
    bb = wall.xx / det
    wall.var_theta = d**2 * (c * c * bb - 2.0 * c * s * ab + s * s * aa)
    wall.cov = -(d**3) * (c * s * (bb - aa) + (c * c - s * s) * ab)
    wall.var_d = d**4 * (c * c * aa + 2.0 * c * s * ab + s * s * bb)
    wall.log_det = math.log(det) - 6.0 * math.log(d)
    if s < 0.0 or (s == 0.0 and c < 0.0):
        c, s, d = -c, -s, -d
        wall.cov = -wall.cov
    wall.c = c
    wall.s = s
    wall.d = d


@inlined
def add_return(points: Sequence, i: int, line: Wall, wall: Wall, weighted: bool) -> None:
    """Add a return to the sums of a wall.

    `weighted`: what does not vanish at grazing incidence counts, at the incidence on a line.
    """
    w = points.weight[i]
    if weighted:
        cosine = points.ux[i] * line.c + points.uy[i] * line.s
        cosine *= cosine
        w *= cosine / (cosine + points.floor[i])
    x = points.x[i]
    y = points.y[i]
    wall.w += w
    wall.x += w * x
    wall.y += w * y
    wall.xx += w * x * x
    wall.xy += w * x * y
    wall.yy += w * y * y
    if wall.points == 0:
        wall.first = i
    wall.points += 1
    wall.last = i + 1


@leaf
def fit_walls(points: Sequence, label: IntArray, walls: Walls, weighted: bool) -> None:
    """Fit every wall to the returns that bear its number, `weighted` at its line so far."""
    for k in range(walls.size):
        wall = walls[k]
        wall.w = wall.x = wall.y = wall.xx = wall.xy = wall.yy = 0.0
        wall.points = wall.last = wall.first = 0
    for i in range(points.x.size):
        k = label[i]
        if k >= 0:
            add_return(points, i, walls[k], walls[k], weighted)
    for k in range(walls.size):
        if walls[k].points > 1:
            solve(walls[k])


@leaf
def combine(into: Wall, one: Wall, other: Wall, sign: float) -> None:
    """Write the sums of one wall and another, or less it, into a third."""
    into.w = one.w + sign * other.w
    into.x = one.x + sign * other.x
    into.y = one.y + sign * other.y
    into.xx = one.xx + sign * other.xx
    into.xy = one.xy + sign * other.xy
    into.yy = one.yy + sign * other.yy
    into.points = one.points + int(sign) * other.points


@helper
def merge_collinear(points: Sequence, label: IntArray, walls: Walls) -> None:
    """Join walls that one line explains at a lower price.

    The price of a line is what is known of it: -log of the determinant of its covariance (Laplace's
    approximation of its evidence), with d in units of the mean range. So short pieces far apart,
    which any line may join by chance, cost more together than long ones.
    """
    scale = 0.0
    for i in range(label.size):
        scale += points.x[i] * points.ux[i] + points.y[i] * points.uy[i]
    one = np.arange(walls.size)
    room = np.zeros(1, WALL)
    price = 2.0 * math.log(max(scale, 1e-300) / max(label.size, 1))
    for a in range(walls.size):
        first = walls[a]
        for b in range(a + 1, walls.size):
            other = walls[b]
            if first.points == 0 or other.points == 0:
                continue
            turn = first.c * other.s - first.s * other.c
            if turn * turn > SURELY_APART * (first.var_theta + other.var_theta) + SAME_TURN:
                continue
            both = room[0]  # taken anew: a record does not keep its array alive
            combine(both, first, other, 1.0)
            solve(both)
            worse = both.chi2 - first.chi2 - other.chi2
            if worse < first.log_det + other.log_det - both.log_det + price:
                both.first = min(first.first, other.first)
                both.last = max(first.last, other.last)
                walls[a] = both
                other.points = 0
                one[b] = a
    for i in range(label.size):
        k = label[i]
        while k >= 0 and one[k] != k:
            k = one[k]
        label[i] = k


@leaf
def part_at_corners(points: Sequence, label: IntArray, walls: Walls) -> int:
    """Part the returns of walls that meet by the bearing of their crossing; return how many change.

    A beam hits the wall on its side of the corner, whatever its range errs by; to give a return to
    the nearer of both would choose the errors that each wall gets, and turn the short ones.
    """
    last = ZERO - 1
    changed = 0
    for i in range(label.size):
        if label[i] < 0:
            continue
        if last >= 0 and label[last] != label[i] and i - last <= MEETING:
            changed += part(points, label, walls, last, i)
        last = i
    return changed


@leaf
def part(points: Sequence, label: IntArray, walls: Walls, last: int, first: int) -> int:
    """Part the returns of two walls, one up to the return `last`, the next from `first` on.

    Returns how many change.
    """
    a = label[last]
    b = label[first]
    one = walls[a]
    other = walls[b]
    det = one.c * other.s - one.s * other.c
    if abs(det) < LEAST_SINE:
        return 0
    x = (one.d * other.s - other.d * one.s) / det
    y = (other.d * one.c - one.d * other.c) / det
    ahead = x * points.x[last] + y * points.y[last] > 0.0
    if not ahead or x * points.x[first] + y * points.y[first] <= 0.0:
        return 0
    changed = 0
    i = first - 1
    while i >= 0 and (label[i] == a or label[i] == STRAY) and x * points.uy[i] > y * points.ux[i]:
        if misfit(points, i, other.c, other.s, other.d) < INLIER:
            label[i] = b
            changed += 1
        i -= 1
    i = last + 1
    while i < label.size and (label[i] == b or label[i] == STRAY):
        if x * points.uy[i] >= y * points.ux[i]:
            break
        if misfit(points, i, one.c, one.s, one.d) < INLIER:
            label[i] = a
            changed += 1
        i += 1
    return changed


@leaf
def free_outliers(points: Sequence, label: IntArray, walls: Walls, known: int) -> None:
    """Take the returns from the first `known` walls that cost less as stray ones."""
    for i in range(label.size):
        if 0 <= label[i] < known:
            wall = walls[label[i]]
            if misfit(points, i, wall.c, wall.s, wall.d) > STRAY_PRICE:
                label[i] = STRAY


@helper
def prune(label: IntArray, walls: Walls, min_points: int) -> int:
    """Free the returns of walls that have too few, number the others anew; return how many."""
    number = np.full(walls.size, STRAY)
    count = 0
    for k in range(walls.size):
        if walls[k].points >= min_points and walls[k].chi2 < math.inf:
            walls[count] = walls[k]
            number[k] = count
            count += 1
    for i in range(label.size):
        if label[i] >= 0:
            label[i] = number[label[i]]
    return count
