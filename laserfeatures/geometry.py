"""Compiled geometry that the stages and the plugins share: points, line fits, segment cuts.

All functions are numba kernels: arrays and scalars in, arrays and scalars out, no checks. Points
are given as x (P,), y (P,) [m] in beam order with `beam` (P,), the index of each point's beam.
A fit is a tuple (theta, d, var_theta, cov_theta_d, var_d), the last three for a unit noise.
"""

import math

import numpy as np
from numba import njit

from laserfeatures.arrays import BoolArray, FloatArray, IntArray

# Division by zero gives inf or nan, as in NumPy: Python's check would double the code. What Python
# calls is a kernel and compiled once for all runs. What only kernels call is a helper: a part of
# them, which compiles in half the time without the wrapper that Python would need. So Python must
# not call it: that would end the interpreter.
kernel = njit(cache=True, error_model="numpy")
helper = njit(  # type: ignore[call-overload] # options that the stubs of numba leave out
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True
)

Fit = tuple[float, float, float, float, float]
Segments = tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]

# A range error moves a point along its beam, so its distance from a line errs by cos(incidence).
# Other errors (beam width and angle, roughness) do not vanish at grazing incidence: this adds them
# as a share of the range variance.
INCIDENCE_FLOOR = 0.02


@kernel
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


@kernel
def fit_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float) -> Fit:
    """Fit a line to the points `members` by weighted total least squares.

    The weights are the inverse variances of the points' distances from the line for a range noise
    of 1 m at the incidence angles that `theta`, a first guess, implies; the line is the minor axis
    of the weighted scatter. The covariance follows to first order; it is for that noise too, so
    that a noise sigma multiplies it by sigma squared.
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
    var_theta = 1.0 / spread
    return theta, mx * c + my * s, var_theta, centre * var_theta, 1.0 / w + centre**2 * var_theta


@kernel
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
    to beam changes smoothly from the `spacing` beside it, however wide it gets at grazing
    incidence.
    """
    return metres_apart > max_gap and (
        beams_apart > max_missed + 1 or metres_apart > max_growth * beams_apart * spacing
    )


@kernel
def cut_segments(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    beams: int,
    theta: FloatArray,
    d: FloatArray,
    line: IntArray,
    member: IntArray,
    max_missed: int,
    max_gap: float,
    max_growth: float,
) -> Segments:
    """Cut lines into segments where their points leave a gap.

    Parameters
    ----------
    beams : int
        Number of beams of the scan.
    theta, d : (L,) arrays
        The lines.
    line, member : (M,) int arrays
        Point ``member[m]`` lies on line ``line[m]``; by line, then in beam order.
    max_missed, max_gap, max_growth : int, float, float
        A gap is wider than `max_gap` [m], and has more than `max_missed` beams off the line or is
        more than `max_growth` times as wide for each beam as the step before it.

    Returns
    -------
    line (S,), endpoints (S, 2, 2), support (S,), rms (S,), points (S, beams) : arrays
        As in `LineSegments`.
    """
    steps = np.empty(member.size + 1)  # way from the point before to this one, for each beam
    steps[member.size] = math.inf
    c = s = 0.0
    for m in range(member.size):
        steps[m] = math.inf
        if m == 0 or line[m] != line[m - 1]:
            c = math.cos(theta[line[m]])
            s = math.sin(theta[line[m]])
        else:
            i = member[m]
            j = member[m - 1]
            steps[m] = abs((y[i] - y[j]) * c - (x[i] - x[j]) * s) / (beam[i] - beam[j])
    ends = np.empty(member.size + 1, np.int64)  # a segment is member[ends[j] : ends[j + 1]]
    count = 0
    before = math.inf
    for m in range(member.size):
        new = True
        if steps[m] < math.inf:
            missed = beam[member[m]] - beam[member[m - 1]]
            spacing = min(before, steps[m + 1])  # the one on the nearer side is the smaller
            new = is_gap(missed, steps[m] * missed, spacing, max_missed, max_gap, max_growth)
        before = math.inf if new else steps[m]
        if new:
            ends[count] = m
            count += 1
    ends[count] = member.size
    of_line = np.empty(count, np.int64)
    endpoints = np.empty((count, 2, 2))
    support = np.empty(count)
    rms = np.empty(count)
    points = np.zeros((count, beams), np.bool_)
    for j in range(count):
        k = line[ends[j]]
        c = math.cos(theta[k])
        s = math.sin(theta[k])
        square = 0.0
        for m in range(ends[j], ends[j + 1]):
            i = member[m]
            error = x[i] * c + y[i] * s - d[k]
            square += error * error
            points[j, beam[i]] = True
        of_line[j] = k
        support[j] = ends[j + 1] - ends[j]
        rms[j] = math.sqrt(square / support[j])
        for end in range(2):
            i = member[ends[j + end] - end]
            error = x[i] * c + y[i] * s - d[k]
            endpoints[j, end, 0] = x[i] - error * c
            endpoints[j, end, 1] = y[i] - error * s
    return of_line, endpoints, support, rms, points
