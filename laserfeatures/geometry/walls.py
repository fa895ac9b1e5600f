"""The table of walls that a search fills, and the test of what is one.

Each point has an owner: the number of its wall, `FREE`, or another negative number that sets it
aside. A row of the table is a fit and the wall's number of points.
"""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper, inlined
from laserfeatures.geometry.fit import INCIDENCE_FLOOR, Fit

Cut = tuple[int, int, float]  # min_points of a wall, max_missed and max_gap of its segments

FREE = -1  # owner of a point that nothing has explained yet
ROUND = -2  # owner of a point on a round object
FLATNESS = 0.01  # [m]; real walls, and a real sensor's view of them, are no flatter than that
FEW = 12
GRAZING = 0.06  # cos(incidence) under which so few points are a jump edge rather than a wall
FLAT_RADIUS = 1.0  # [m]; what bends less is a wall, if no perfect one
CURVED = 4.0  # standard deviations at which a quadratic term is no chance
PRIOR = 4.0  # points; fewer residuals alone do not tell the noise


@helper
def gather(owner: IntArray, wall: int, members: IntArray) -> int:
    """Put the points that `wall` owns into `members`; return how many."""
    count = 0
    for i in range(owner.size):
        if owner[i] == wall:
            members[count] = i
            count += 1
    return count


@helper
def keep_wall(row: FloatArray, fit: Fit, points: int) -> None:
    """Write a fit and its number of points into a row of the walls."""
    row[0] = fit[0]
    row[1] = fit[1]
    row[2] = fit[2]
    row[3] = fit[3]
    row[4] = fit[4]
    row[5] = points


@helper
def is_wall(
    x: FloatArray, y: FloatArray, members: IntArray, fit: Fit, sigma: float
) -> tuple[bool, float, float]:
    """Tell whether points and their fit are what a flat wall would give.

    Also returns the variance of their range noise and the largest distance from the line.
    """
    theta, d = fit[0], fit[1]
    c = math.cos(theta)
    s = math.sin(theta)
    n = members.size
    centre = 0.0
    for i in members:
        centre += y[i] * c - x[i] * s
    centre /= n
    t2 = t3 = t4 = e0 = e1 = e2 = ee = cosine = noise = worst = 0.0
    for i in members:
        normal = x[i] * c + y[i] * s
        along = y[i] * c - x[i] * s - centre
        error = normal - d
        square = along * along
        t2 += square
        t3 += square * along
        t4 += square * square
        e0 += error
        e1 += error * along
        e2 += error * square
        ee += error * error
        worst = max(worst, abs(error))
        incidence = normal * normal / (x[i] * x[i] + y[i] * y[i])  # its squared cosine
        if n < FEW:
            cosine += math.sqrt(incidence)
        noise += incidence + INCIDENCE_FLOOR
    residual = ee / max(n - 2, 1)
    if residual > max(2.0 * sigma, FLATNESS) ** 2 or (n < FEW and cosine < GRAZING * n):
        return False, 0.0, worst
    # The quadratic term that is left once constant and slope are taken out of along^2.
    skew = t3 / t2
    quadratic = t4 - skew * t3 - t2 * t2 / n
    if quadratic > 0.0:
        bend = (e2 - skew * e1 - t2 * e0 / n) / quadratic
        if abs(bend) * math.sqrt(quadratic) > CURVED * sigma and abs(bend) > 0.5 / FLAT_RADIUS:
            return False, 0.0, worst
    return True, residual * n / noise, worst


@inlined
def lines_of(
    walls: FloatArray, min_points: int, sigma: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return theta, d, support and covariance of the walls that have enough points."""
    lines = 0
    for k in range(walls.shape[0]):
        lines += walls[k, 5] >= min_points
    theta = np.empty(lines)
    d = np.empty(lines)
    support = np.empty(lines)
    covariance = np.empty((lines, 2, 2))
    new = 0
    for k in range(walls.shape[0]):
        if walls[k, 5] >= min_points:
            theta[new] = walls[k, 0]
            d[new] = walls[k, 1]
            covariance[new, 0, 0] = walls[k, 2] * sigma * sigma
            covariance[new, 0, 1] = covariance[new, 1, 0] = walls[k, 3] * sigma * sigma
            covariance[new, 1, 1] = walls[k, 4] * sigma * sigma
            support[new] = walls[k, 5]
            new += 1
    return theta, d, support, covariance


@inlined
def widen(
    x: FloatArray,
    y: FloatArray,
    line: IntArray,
    member: IntArray,
    theta: FloatArray,
    d: FloatArray,
    covariance: FloatArray,
    sigma: float,
) -> None:
    """Widen the covariances of lines whose points lie farther off than the noise explains.

    By the ratio of both (Birge 1932), where the noise counts as much as `PRIOR` points that it
    explains: a wall that is not flat, a sensor that is worse far away or at dark walls, a point
    that is not on the wall.
    """
    square = np.zeros(theta.size)
    count = np.zeros(theta.size)
    cos = np.cos(theta)
    sin = np.sin(theta)
    for m in range(member.size):
        k = line[m]
        i = member[m]
        normal = x[i] * cos[k] + y[i] * sin[k]
        incidence = normal * normal / (x[i] * x[i] + y[i] * y[i])
        square[k] += (normal - d[k]) ** 2 / (incidence + INCIDENCE_FLOOR)
        count[k] += 1.0
    for k in range(theta.size):
        ratio = (PRIOR + square[k] / (sigma * sigma)) / (PRIOR + count[k] - 2.0)
        if ratio > 1.0:
            for i in range(2):
                for j in range(2):
                    covariance[k, i, j] *= ratio


@helper
def members_of(owner: IntArray, walls: FloatArray, min_points: int) -> tuple[IntArray, IntArray]:
    """Return the lines and the points of all points on walls that have enough of them."""
    place = np.empty(walls.shape[0], np.int64)  # where the next point of each wall goes
    number = np.empty(walls.shape[0], np.int64)
    total = lines = 0
    for k in range(walls.shape[0]):
        place[k] = total
        number[k] = lines
        if walls[k, 5] >= min_points:
            total += int(walls[k, 5])
            lines += 1
    line = np.empty(total, np.int64)
    member = np.empty(total, np.int64)
    for i in range(owner.size):
        k = owner[i]
        if k >= 0 and walls[k, 5] >= min_points:
            line[place[k]] = number[k]
            member[place[k]] = i
            place[k] += 1
    return line, member
