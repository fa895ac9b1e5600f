"""The kernels of `raster_hough` that make candidates out of the lines that OpenCV found."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.engine import helper, kernel
from laserfeatures.engine.candidates import add, grow
from laserfeatures.engine.partition import COLUMNS, STRAY, Limits, as_limits
from laserfeatures.engine.segments import Found, cut_walls
from laserfeatures.engine.sequence import as_sequence
from laserfeatures.engine.walls import WALL, Walls

# What OpenCV found, (rho [pixels], theta) with the most votes first; the place [m] of its first
# pixel; cosine and sine of its rows of theta.
Bounds = tuple[int, int, float, float, int, bool]  # what a wall may be, as `Limits`
Lines = tuple[NDArray[np.float32], tuple[float, float], FloatArray, FloatArray]

LEAST = 4  # points of a wall
SIGMAS = 3.0  # standard deviations of the noise within which a point is an inlier
WINDOW = 3.5  # cells of theta and of d beside a line in which another one repeats it


@kernel
def propose(
    table: FloatArray, lines: Lines, resolution: float, noise: float, bounds: Bounds
) -> FloatArray:
    """Return walls grown from the points near each line, (COLUMNS, K).

    What a wall explains supports no line after it: so the lines beside its own, in theta and,
    across 0 and pi, in -d, find nothing there.
    """
    limits = as_limits(bounds)
    points = as_sequence(table)
    n = points.x.size
    walls = np.empty((COLUMNS, n // LEAST + 1))
    taken = np.zeros(n, np.bool_)
    free = np.arange(n)
    near = np.empty(n, np.int64)
    gate = resolution + SIGMAS * noise
    count = k = 0
    left = keep_free(taken, free)
    while k < lines[0].shape[0] and left >= LEAST and count < walls.shape[1]:
        _, c, s, d = to_metres(lines, k, resolution)
        seed = seed_on(points.x, points.y, points.beam, free[:left], c, s, d, gate, limits, near)
        k += 1
        if seed < 0:
            continue
        d = points.x[seed] * c + points.y[seed] * s
        wall = grow(points, taken, seed, c, s, d, resolution, limits.max_missed)
        if wall.saved > 0.0:
            add(points, taken, wall, walls, count)
            count += 1
            left = keep_free(taken, free[:left])
            k -= 1  # while a line gives walls it may have another
    return walls[:, :count].copy()


@kernel
def bins_on(
    table: FloatArray, beams: int, lines: Lines, resolution: float, noise: float, bounds: Bounds
) -> Found:
    """Return the lines as they are, but for those that repeat one before, cut into segments.

    A line holds the free points near it. Its covariance is that of uniform errors of a cell's size
    in its direction and in its distance in the middle of the points.
    """
    limits = as_limits(bounds)
    points = as_sequence(table)
    n = points.x.size
    walls = np.zeros(n // LEAST + 1, WALL)
    label = np.full(n, STRAY)
    taken = np.zeros(n, np.bool_)
    free = np.arange(n)
    near = np.empty(n, np.int64)
    gate = resolution + SIGMAS * noise
    step = math.pi / lines[2].size
    turn = step**2 / 12.0
    count = 0
    left = keep_free(taken, free)
    for k in range(lines[0].shape[0]):
        theta, c, s, d = to_metres(lines, k, resolution)
        seed = seed_on(points.x, points.y, points.beam, free[:left], c, s, d, gate, limits, near)
        if seed < 0:
            continue
        if repeats(theta, points.x[seed], points.y[seed], walls[:count], step, resolution):
            continue
        wall = walls[count]
        for i in free[:left]:
            if abs(points.x[i] * c + points.y[i] * s - d) < gate:
                label[i] = count
                taken[i] = True
                wall.points += 1
        along = points.y[seed] * c - points.x[seed] * s
        wall.c, wall.s, wall.d = c, s, d
        wall.var_theta = turn
        wall.cov = along * turn
        wall.var_d = resolution**2 / 12.0 + along**2 * turn
        count += 1
        left = keep_free(taken, free[:left])
    return cut_walls(points, label, walls[:count], beams, limits)


@helper
def to_metres(lines: Lines, k: int, resolution: float) -> tuple[float, float, float, float]:
    """Return theta, cos(theta), sin(theta) and d [m] of line k.

    OpenCV counts rho from the centre of the first pixel, so that there is no half pixel to add.
    """
    found, origin, cos, sin = lines
    row = int(found[k, 1] * cos.size / math.pi + 0.5)
    d = float(found[k, 0]) * resolution + origin[0] * cos[row] + origin[1] * sin[row]
    return row * math.pi / cos.size, cos[row], sin[row], d


@helper
def repeats(theta: float, x: float, y: float, walls: Walls, step: float, resolution: float) -> bool:
    """Tell whether a line of points around (x, y) repeats one of `walls`; theta wraps."""
    for k in range(walls.size):
        wall = walls[k]
        turn = abs(math.atan2(wall.s, wall.c) - theta)
        off = abs(x * wall.c + y * wall.s - wall.d)
        if min(turn, math.pi - turn) < WINDOW * step and off < WINDOW * resolution:
            return True
    return False


@helper
def keep_free(taken: BoolArray, free: IntArray) -> int:
    """Move the points of `free` that nothing has explained yet to its front; return how many."""
    count = 0
    for i in free:
        if not taken[i]:
            free[count] = i
            count += 1
    return count


@helper
def seed_on(
    x: FloatArray,
    y: FloatArray,
    beam: FloatArray,
    free: IntArray,
    c: float,
    s: float,
    d: float,
    gate: float,
    limits: Limits,
    near: IntArray,
) -> int:
    """Return the middle point of the longest run of free points near a line, -1 where none is.

    Between two points of a run, at most `max_missed` beams or `max_gap` metres miss
    the line. `near` is filled with the points near the line.
    """
    count = first = 0
    most = LEAST - 1
    seed = -1
    for i in free:
        if abs(x[i] * c + y[i] * s - d) >= gate:
            continue
        if count > 0:
            j = near[count - 1]
            way = abs((y[i] - y[j]) * c - (x[i] - x[j]) * s)
            if beam[i] - beam[j] > limits.max_missed + 1 and way > limits.max_gap:
                first = count
        near[count] = i
        count += 1
        if count - first > most:
            most = count - first
            seed = near[first + most // 2]
    return int(seed)
