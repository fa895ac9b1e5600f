"""Lines cut into segments where their points leave a gap."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.geometry.compiled import kernel

Segments = tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]

MAX_GROWTH = 4.0  # of the way between points of a wall from one beam to the next


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
    ends = np.empty(member.size + 1, np.int64)  # a segment is member[ends[j] : ends[j + 1]]
    count = 0
    c = s = before = way = 0.0
    for m in range(member.size):
        i = member[m]
        new = m == 0 or line[m] != line[m - 1]
        if new:
            c = math.cos(theta[line[m]])
            s = math.sin(theta[line[m]])
        else:
            h = member[m - 1]
            way = abs((y[i] - y[h]) * c - (x[i] - x[h]) * s)
            apart = beam[i] - beam[h]
            if way > max_gap:  # few are: only they need the way beside them
                spacing = before
                if m + 1 < member.size and line[m + 1] == line[m]:
                    j = member[m + 1]
                    after = abs((y[j] - y[i]) * c - (x[j] - x[i]) * s) / (beam[j] - beam[i])
                    spacing = min(before, after)  # the one on the nearer side is the smaller
                new = is_gap(apart, way, spacing, max_missed, max_gap, max_growth)
            before = way / apart
        if new:
            before = math.inf
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
