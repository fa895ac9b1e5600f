"""Walls grown along the scan from a point and a direction, and refitted until they settle."""

import math

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper
from laserfeatures.geometry.fit import Fit, fit_line
from laserfeatures.geometry.segments import MAX_GROWTH, is_gap
from laserfeatures.geometry.walls import FLATNESS, FREE, Cut, is_wall

SIGMAS = 3.0  # an inlier's distance from its line in standard deviations, at the most
MAX_FITS = 6  # refits of one wall; nearly all settle after three


@helper
def gate_of(sigma: float) -> float:
    """Return the largest distance of an inlier from its line [m]."""
    return max(SIGMAS * sigma, 1.5 * FLATNESS)


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
    bound = gate_of(sigma)
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
    flat, variance, _ = is_wall(x, y, members[:count], fit, sigma)
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
