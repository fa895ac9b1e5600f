"""Compiled geometry that the stages and the plugins share: points, line fits, segment cuts.

All functions are numba kernels: arrays and scalars in, arrays and scalars out, no checks. Points
are given as x (P,), y (P,) [m] in beam order with `beam` (P,), the index of each point's beam.
A fit is a tuple (theta, d, var_theta, cov_theta_d, var_d).
"""

import math

import numpy as np
from numba import njit

from laserfeatures.arrays import BoolArray, FloatArray, IntArray

Fit = tuple[float, float, float, float, float]
Segments = tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]

# A range error moves a point along its beam, so its distance from a line errs by cos(incidence).
# Other errors (beam width and angle, roughness) do not vanish at grazing incidence: this adds them
# as a share of the range variance.
INCIDENCE_FLOOR = 0.02
JUMP = 8.0  # growth of the spacing of points along a wall, from one beam to the next, at the most


@njit(cache=True)
def returns(
    directions: FloatArray, ranges: FloatArray, range_min: float, range_max: float
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return (x, y, beam) of the valid returns, as `LaserScan.points` and `LaserScan.beams`."""
    n = ranges.size
    x = np.empty(n)
    y = np.empty(n)
    beam = np.empty(n, np.int64)
    count = 0
    for i in range(n):
        r = ranges[i]
        if range_min <= r < range_max and 0.0 < r < math.inf:
            x[count] = r * directions[i, 0]
            y[count] = r * directions[i, 1]
            beam[count] = i
            count += 1
    return x[:count], y[:count], beam[:count]


@njit(cache=True)
def fit_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float, sigma: float) -> Fit:
    """Fit a line to the points `members` by weighted total least squares.

    The weights are the inverse variances of the points' distances from the line for a range noise
    `sigma` at the incidence angles that `theta`, a first guess, implies. The line's covariance
    follows from them to first order.
    """
    c = math.cos(theta)
    s = math.sin(theta)
    w = wx = wy = wxx = wxy = wyy = 0.0
    for i in members:
        along = x[i] * c + y[i] * s
        weight = 1.0 / (along * along / (x[i] * x[i] + y[i] * y[i]) + INCIDENCE_FLOOR)
        w += weight
        wx += weight * x[i]
        wy += weight * y[i]
        wxx += weight * x[i] * x[i]
        wxy += weight * x[i] * y[i]
        wyy += weight * y[i] * y[i]
    return solve_line(w, wx, wy, wxx, wxy, wyy, sigma)


@njit(cache=True)
def solve_line(
    w: float, wx: float, wy: float, wxx: float, wxy: float, wyy: float, sigma: float
) -> Fit:
    """Return the fit whose weighted sums are given: the minor axis of the points' scatter."""
    mx = wx / w
    my = wy / w
    sxx = wxx - wx * mx
    sxy = wxy - wx * my
    syy = wyy - wy * my
    theta = 0.5 * math.atan2(-2.0 * sxy, syy - sxx)
    if theta < 0.0:
        theta += math.pi
    if theta >= math.pi:
        theta = 0.0
    c = math.cos(theta)
    s = math.sin(theta)
    centre = my * c - mx * s
    spread = max(sxx * s * s - 2.0 * sxy * s * c + syy * c * c, 1e-12)
    var_theta = sigma * sigma / spread
    var_d = sigma * sigma / w + centre * centre * var_theta
    return theta, mx * c + my * s, var_theta, centre * var_theta, var_d


@njit(cache=True)
def is_gap(
    beams_apart: int,
    metres_apart: float,
    spacing: float,
    max_missed: int,
    max_gap: float,
    max_growth: float,
) -> bool:
    """Tell whether the way between two successive points of a line is a gap in its surface.

    It is where it is wide and either misses several beams or jumps: along a wall the way from beam
    to beam changes smoothly from the `spacing` before, however wide it gets at grazing incidence.
    """
    return metres_apart > max_gap and (
        beams_apart > max_missed + 1 or metres_apart > max_growth * beams_apart * spacing
    )


@njit(cache=True)
def cut_segments(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    beams: int,
    theta: FloatArray,
    d: FloatArray,
    members: BoolArray,
    max_missed: int,
    max_gap: float,
    max_growth: float,
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Cut lines into segments where their points leave a gap.

    Parameters
    ----------
    beams : int
        Number of beams of the scan.
    theta, d : (L,) arrays
        The lines.
    members : (L, P) bool array
        Which points lie on each line.
    max_missed, max_gap, max_growth : int, float, float
        A gap is wider than `max_gap` [m], and has more than `max_missed` beams off the line or is
        more than `max_growth` times as wide for each beam as the step before it.

    Returns
    -------
    line (S,), endpoints (S, 2, 2), support (S,), rms (S,), points (S, beams) : arrays
        As in `LineSegments`.
    """
    n = x.size
    first = np.empty(members.size, np.int64)
    line = np.empty(members.size, np.int64)
    last = np.empty(members.size, np.int64)
    count = 0
    for k in range(theta.size):
        c = math.cos(theta[k])
        s = math.sin(theta[k])
        before = -1
        spacing = 0.0
        for i in range(n):
            if not members[k, i]:
                continue
            apart = 0.0
            missed = 0
            if before >= 0:
                missed = beam[i] - beam[before]
                apart = abs((y[i] - y[before]) * c - (x[i] - x[before]) * s)
            if before < 0 or is_gap(missed, apart, spacing, max_missed, max_gap, max_growth):
                spacing = math.inf
                line[count] = k
                first[count] = i
                count += 1
            else:
                spacing = apart / missed
            last[count - 1] = i
            before = i
    endpoints = np.empty((count, 2, 2))
    support = np.zeros(count)
    rms = np.zeros(count)
    points = np.zeros((count, beams), np.bool_)
    for j in range(count):
        k = line[j]
        c = math.cos(theta[k])
        s = math.sin(theta[k])
        for i in range(first[j], last[j] + 1):
            if members[k, i]:
                error = x[i] * c + y[i] * s - d[k]
                support[j] += 1.0
                rms[j] += error * error
                points[j, beam[i]] = True
        rms[j] = math.sqrt(rms[j] / support[j])
        for end, i in enumerate((first[j], last[j])):
            error = x[i] * c + y[i] * s - d[k]
            endpoints[j, end, 0] = x[i] - error * c
            endpoints[j, end, 1] = y[i] - error * s
    return line[:count].copy(), endpoints, support, rms, points
