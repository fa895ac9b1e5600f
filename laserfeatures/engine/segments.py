"""Lines cut into segments where their points leave a gap (step 8)."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.compiled import helper, kernel, leaf
from laserfeatures.data import LineSegments
from laserfeatures.engine.partition import Limits
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.walls import Walls

Segments = tuple[IntArray, FloatArray, FloatArray, FloatArray, BoolArray]

# The numbers of lines and segments in one array, the line of each segment, and which beams it
# holds. Handing an array to Python takes half a microsecond, a view of it less.
Found = tuple[FloatArray, IntArray, BoolArray]

MAX_SIZE = 500_000_000  # segments times beams [bytes]; as much again once they are filtered
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
    source: IntArray,
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
    beam, source : (P,) int arrays
        Number of each point's beam, in a ring counted on past the last, and in the scan.
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
        As in `LineSegments`; points is (0, beams) where it would be too large (see `check_size`).
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
    fits = count * beams <= MAX_SIZE
    points = np.zeros((count if fits else 0, beams), np.bool_)
    for j in range(count if fits else 0):
        k = line[ends[j]]
        c = math.cos(theta[k])
        s = math.sin(theta[k])
        square = 0.0
        for m in range(ends[j], ends[j + 1]):
            i = member[m]
            error = x[i] * c + y[i] * s - d[k]
            square += error * error
            points[j, source[i]] = True
        of_line[j] = k
        support[j] = ends[j + 1] - ends[j]
        rms[j] = math.sqrt(square / support[j])
        for end in range(2):
            i = member[ends[j + end] - end]
            error = x[i] * c + y[i] * s - d[k]
            endpoints[j, end, 0] = x[i] - error * c
            endpoints[j, end, 1] = y[i] - error * s
    return of_line, endpoints, support, rms, points


@helper
def cut_walls(points: Sequence, label: IntArray, walls: Walls, beams: int, limits: Limits) -> Found:
    """Cut walls into segments; return what `line_segments` takes."""
    count = walls.size
    place = np.empty(count, np.int64)  # where the next return of each wall goes
    theta = np.empty(count)
    d = np.empty(count)
    total = 0
    for k in range(count):
        place[k] = total
        total += walls[k].points
        wall = walls[k]
        theta[k] = math.atan2(wall.s, wall.c)
        if theta[k] >= math.pi:  # s is next to nothing: it is 0 then
            theta[k] = 0.0
            wall.d = -wall.d
            wall.cov = -wall.cov
        d[k] = wall.d
    line = np.empty(total, np.int64)
    member = np.empty(total, np.int64)
    beam = np.empty(label.size, np.int64)
    source = np.empty(label.size, np.int64)
    by_wall(points, label, place, line, member, beam, source)
    segments = cut_segments(
        points.x, points.y, beam, source, beams, theta, d, line, member, limits.max_missed,
        limits.max_gap, MAX_GROWTH,
    )  # fmt: skip
    return pack(theta, walls, segments)


@leaf
def by_wall(
    points: Sequence,
    label: IntArray,
    place: IntArray,
    line: IntArray,
    member: IntArray,
    beam: IntArray,
    source: IntArray,
) -> None:
    """Sort the returns by walls, in beam order: each has a `place` for its first."""
    for i in range(label.size):
        beam[i] = int(points.beam[i])
        source[i] = int(points.source[i])
        k = label[i]
        if k >= 0:
            line[place[k]] = k
            member[place[k]] = i
            place[k] += 1


@helper
def pack(theta: FloatArray, walls: Walls, segments: Segments) -> Found:
    """Put the numbers of lines and segments into one array, as `LineSegments.pack` does."""
    line, endpoints, support, rms, beams = segments
    lines = walls.size
    count = line.size
    numbers = np.empty(8 * lines + 6 * count)
    for k in range(lines):
        wall = walls[k]
        numbers[k] = theta[k]
        numbers[lines + k] = wall.d
        numbers[2 * lines + k] = wall.points
        numbers[3 * lines + k] = wall.evidence
        at = 4 * lines + 4 * k
        numbers[at] = wall.var_theta
        numbers[at + 1] = numbers[at + 2] = wall.cov
        numbers[at + 3] = wall.var_d
    for j in range(count):
        at = 8 * lines + j
        numbers[at] = support[j]
        numbers[at + count] = rms[j]
        at += 2 * count + 3 * j
        numbers[at] = endpoints[j, 0, 0]
        numbers[at + 1] = endpoints[j, 0, 1]
        numbers[at + 2] = endpoints[j, 1, 0]
        numbers[at + 3] = endpoints[j, 1, 1]
    return numbers, line, beams


def check_size(line: IntArray, points: BoolArray) -> None:
    """Check that the beams of all segments had room in memory.

    Raises
    ------
    ValueError
        If they had not.
    """
    if len(points) < len(line):
        raise ValueError(
            f"expected at most {MAX_SIZE:.0e} beams over all segments, got {len(line)} segments of "
            f"{points.shape[1]} beams: are the ranges noise?"
        )


def line_segments(found: Found) -> LineSegments:
    """Return what a kernel found as `LineSegments`.

    Raises
    ------
    ValueError
        If it was too much for memory.
    """
    numbers, line, beams = found
    check_size(line, beams)
    lock(numbers, line, beams)
    return LineSegments.packed(numbers, line=line, points=beams)
