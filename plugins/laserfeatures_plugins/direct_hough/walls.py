"""Kernels that turn peaks into walls: grow, fit, test, merge, share out the points."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import INCIDENCE_FLOOR, Fit, fit_line, helper, is_gap

Cut = tuple[int, int, float]  # min_points, max_missed, max_gap

FREE = -1  # owner of a point that nothing has explained yet
SIGMAS = 3.0  # an inlier's distance from its line in standard deviations, at the most
MAX_FITS = 6  # refits of one wall; nearly all settle after three
MIN_SIGMA = 0.002  # [m]; no scanner that this is for measures better
MAX_SIGMA = 0.1  # [m]; with more noise than that there are no walls to be found
BASELINE = 0.1  # [m]
MAX_GROWTH = 4.0  # of the way between points of a wall from one beam to the next
FLATNESS = 0.01  # [m]; real walls, and a real sensor's view of them, are no flatter than that
GRAZING = 0.06  # cos(incidence) under which a few points are a jump edge rather than a wall
FLAT_RADIUS = 1.0  # [m]; what bends less is a wall, if no perfect one
CURVED = 4.0  # standard deviations at which a quadratic term is no chance


@helper
def estimate_sigma(x: FloatArray, y: FloatArray) -> float:
    """Estimate the range noise [m] from how far points lie off the chord of their neighbours.

    The neighbours are taken `BASELINE` metres away, since the noise of nearby beams is often
    filtered by the sensor. The median takes no notice of corners, edges and outliers while most
    chords lie on walls.
    """
    stride = max(1, x.size // 50)  # more chords than that cost time and gain nothing
    noise = np.empty(x.size)  # sorted as it is filled
    count = 0
    for i in range(1, x.size - 1, stride):
        a = i - 1
        while a > 0 and (x[i] - x[a]) ** 2 + (y[i] - y[a]) ** 2 < BASELINE * BASELINE:
            a -= 1
        b = i + 1
        while b < x.size - 1 and (x[b] - x[i]) ** 2 + (y[b] - y[i]) ** 2 < BASELINE * BASELINE:
            b += 1
        dx = x[b] - x[a]
        dy = y[b] - y[a]
        square = dx * dx + dy * dy
        if square == 0.0:
            continue
        length = math.sqrt(square)
        off = abs((x[i] - x[a]) * dy - (y[i] - y[a]) * dx) / length
        share = ((x[i] - x[a]) * dx + (y[i] - y[a]) * dy) / square
        incidence = abs(x[i] * dy - y[i] * dx) / (length * math.sqrt(x[i] * x[i] + y[i] * y[i]))
        if incidence > 0.2 and 0.0 < share < 1.0:
            variance = 1.0 + share * share + (1.0 - share) ** 2
            value = off / (incidence * math.sqrt(variance))
            k = count
            while k > 0 and noise[k - 1] > value:
                noise[k] = noise[k - 1]
                k -= 1
            noise[k] = value
            count += 1
    if count < 8:
        return 5.0 * MIN_SIGMA
    return min(max(noise[count // 2] / 0.6745, MIN_SIGMA), MAX_SIGMA)


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
def off_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float, d: float) -> float:
    """Return the root mean square distance of `members` from a line [m]."""
    c = math.cos(theta)
    s = math.sin(theta)
    total = 0.0
    for i in members:
        total += (x[i] * c + y[i] * s - d) ** 2
    return math.sqrt(total / members.size)


@helper
def walk(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    start: int,
    way: int,
    theta: float,
    d: float,
    gate: float,
    max_missed: int,
    max_gap: float,
    spacing: float,
    members: IntArray,
    count: int,
) -> int:
    """Append the free inliers from `start` (not itself) to a gap; return the new count.

    `way` is 1 or -1, along the scan or against it; `spacing` is that of the points before `start`.
    """
    c = math.cos(theta)
    s = math.sin(theta)
    last = start
    along_last = y[start] * c - x[start] * s
    i = start + way
    while 0 <= i < x.size:
        normal = x[i] * c + y[i] * s
        along = y[i] * c - x[i] * s
        apart = abs(beam[i] - beam[last])
        if owner[i] == FREE and abs(normal - d) < gate:
            step = abs(along - along_last)
            if is_gap(apart, step, spacing, max_missed, max_gap, MAX_GROWTH):
                break
            members[count] = i
            count += 1
            last = i
            along_last = along
            spacing = step / apart
        elif apart > max_missed + 1:  # where this beam would have met the line
            along = along * d / normal if normal * d > 0.0 else math.inf
            if abs(along - along_last) > max_gap:
                break
        i += way
    return count


@helper
def grow(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    seed: int,
    theta: float,
    d: float,
    gate: float,
    max_missed: int,
    max_gap: float,
    members: IntArray,
) -> int:
    """Put the run of free inliers around `seed`, itself first, into `members`; return how many."""
    members[0] = seed
    count = 1
    for way in (-1, 1):
        spacing = spacing_beside(x, y, beam, owner, seed, seed - way, theta, d, gate)
        count = walk(
            x, y, beam, owner, seed, way, theta, d, gate, max_missed, max_gap, spacing, members,
            count,
        )  # fmt: skip
    return count


@helper
def spacing_beside(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    i: int,
    j: int,
    theta: float,
    d: float,
    gate: float,
) -> float:
    """Return the way along the line between a point and the next, for each beam, or inf."""
    if not 0 <= j < x.size or owner[j] != FREE:
        return math.inf
    c = math.cos(theta)
    s = math.sin(theta)
    if abs(x[j] * c + y[j] * s - d) >= gate:
        return math.inf
    return abs((y[j] - y[i]) * c - (x[j] - x[i]) * s) / abs(beam[j] - beam[i])


@helper
def is_wall(
    x: FloatArray, y: FloatArray, members: IntArray, fit: Fit, sigma: float
) -> tuple[bool, float]:
    """Tell whether points and their fit are what a flat wall would give; also their noise."""
    theta, d = fit[0], fit[1]
    c = math.cos(theta)
    s = math.sin(theta)
    n = members.size
    centre = 0.0
    for i in members:
        centre += y[i] * c - x[i] * s
    centre /= n
    t2 = t3 = t4 = e0 = e1 = e2 = ee = cosine = noise = 0.0
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
        incidence = abs(normal) / math.sqrt(x[i] * x[i] + y[i] * y[i])
        cosine += incidence
        noise += incidence * incidence + INCIDENCE_FLOOR
    residual = ee / max(n - 2, 1)
    if residual > max(2.0 * sigma, FLATNESS) ** 2 or (cosine < GRAZING * n and n < 12):
        return False, 0.0
    # The quadratic term that is left once constant and slope are taken out of along^2.
    skew = t3 / t2
    quadratic = t4 - skew * t3 - t2 * t2 / n
    if quadratic > 0.0:
        bend = (e2 - skew * e1 - t2 * e0 / n) / quadratic
        if abs(bend) * math.sqrt(quadratic) > CURVED * sigma and abs(bend) > 0.5 / FLAT_RADIUS:
            return False, 0.0
    return True, residual * n / noise


@helper
def find_wall(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    seed: int,
    theta: float,
    width: float,
    sigma: float,
    cut: Cut,
    members: IntArray,
) -> tuple[int, Fit, float]:
    """Grow and refit a wall from a point and a direction until it settles, and test it.

    At first points within `width` of the line through the seed belong to it, then those within the
    noise bound. Returns the number of points (0 where there is no wall), the fit and the variance
    of the range noise that it shows.
    """
    fit = (theta, x[seed] * math.cos(theta) + y[seed] * math.sin(theta), 0.0, 0.0, 0.0)
    bound = max(SIGMAS * sigma, 1.5 * FLATNESS)
    reach = width + bound
    count = before = before_total = 0
    for _ in range(MAX_FITS):
        count = grow(x, y, beam, owner, seed, fit[0], fit[1], reach, cut[1], cut[2], members)
        if count < cut[0]:
            return 0, fit, 0.0
        total = 0
        for i in members[:count]:
            total += i
        if count == before and total == before_total:
            break  # the same points as before
        before = count
        before_total = total
        fit = fit_line(x, y, members[:count], fit[0])
        reach = bound
        seed = nearest_member(x, y, members[:count], fit[0], fit[1])
    flat, variance = is_wall(x, y, members[:count], fit, sigma)
    return (count if flat else 0), fit, variance


@helper
def nearest_member(x: FloatArray, y: FloatArray, members: IntArray, theta: float, d: float) -> int:
    """Return the point nearest to the line."""
    c = math.cos(theta)
    s = math.sin(theta)
    nearest = members[0]
    least = math.inf
    for i in members:
        error = abs(x[i] * c + y[i] * s - d)
        if error < least:
            least = error
            nearest = i
    return int(nearest)
