"""The kernels of `raster_hough` that make walls out of the lines that OpenCV found."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import helper, inlined, kernel
from laserfeatures.geometry.growth import find_wall, gate_of
from laserfeatures.geometry.noise import MIN_SIGMA
from laserfeatures.geometry.segments import MAX_GROWTH, cut_segments
from laserfeatures.geometry.settle import Found, pack, settle
from laserfeatures.geometry.walls import FREE, Cut, keep_wall, lines_of
from laserfeatures_plugins.raster.outline import Returns

# What OpenCV found, (rho [pixels], theta) with the most votes first; the place [m] of its first
# pixel; cosine and sine of its rows of theta.
Lines = tuple[NDArray[np.float32], tuple[float, float], FloatArray, FloatArray]

ENOUGH = 15  # degrees of freedom from which the walls tell the noise better than the triples
WINDOW = 3.5  # cells of theta and of d beside a line in which another one repeats it


@kernel
def walls_on(
    returns: Returns, beams: int, lines: Lines, resolution: float, known: bool, cut: Cut
) -> Found:
    """Return the walls on some lines, each refitted to the points along it.

    `known` says whether the noise is given rather than estimated.
    """
    x, y, beam, owner, noise = returns
    walls, noise = search(x, y, beam, owner, noise, known, lines, resolution, cut)
    return settle(x, y, beam, beams, owner, walls, noise, 0.0, False, cut)


@inlined
def search(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    sigma: float,
    known: bool,
    lines: Lines,
    resolution: float,
    cut: Cut,
) -> tuple[FloatArray, float]:
    """Grow walls from the points near each line; fill `owner`. Returns them and their noise.

    What a wall explains supports no line after it: so the lines beside its own, in theta and,
    across 0 and pi, in -d, find nothing there.
    """
    walls = np.empty((x.size // cut[0] + 1, 6))
    free = np.arange(x.size)
    near = np.empty(x.size, np.int64)
    most_noise = 2.0 * sigma
    squares = freedom = 0.0
    count = k = 0
    left = keep_free(owner, free)
    while k < lines[0].shape[0] and left >= cut[0]:
        gate = resolution + gate_of(sigma)
        theta, c, s, d = to_metres(lines, k, resolution)
        seed = seed_on(x, y, beam, free[:left], c, s, d, gate, cut, near)
        n = 0
        if seed >= 0:
            n, fit, variance = find_wall(
                x, y, beam, owner, seed, theta, resolution, sigma, cut, near
            )
        if n == 0:
            k += 1  # to the next line; while a line gives walls it may have another
            continue
        for i in near[:n]:
            owner[i] = count
        keep_wall(walls[count], fit, n)
        count += 1
        left = keep_free(owner, free[:left])
        if n >= 10 and not known:
            squares += variance * (n - 2)
            freedom += n - 2
            if freedom >= ENOUGH:
                sigma = min(max(math.sqrt(squares / freedom), MIN_SIGMA), most_noise)
    return walls[:count], sigma


@kernel
def bins_on(returns: Returns, beams: int, lines: Lines, resolution: float, cut: Cut) -> Found:
    """Return the lines as they are, but for those that repeat one before, cut into segments."""
    x, y, beam, owner, noise = returns
    walls, line, member = bins(x, y, beam, owner, noise, lines, resolution, cut)
    theta, d, support, covariance = lines_of(walls, cut[0], 1.0)
    segments = cut_segments(x, y, beam, beams, theta, d, line, member, cut[1], cut[2], MAX_GROWTH)
    return pack(theta, d, support, covariance, segments)


@helper
def bins(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    sigma: float,
    lines: Lines,
    resolution: float,
    cut: Cut,
) -> tuple[FloatArray, IntArray, IntArray]:
    """Return the lines that repeat none before, and the line and number of each of their points.

    A line holds the free points near it. Its covariance is that of uniform errors of a cell's size
    in its direction and in its distance in the middle of the points.
    """
    walls = np.empty((x.size // cut[0] + 1, 6))
    free = np.arange(x.size)
    near = np.empty(x.size, np.int64)
    line = np.empty(x.size, np.int64)
    member = np.empty(x.size, np.int64)
    gate = resolution + gate_of(sigma)
    step = math.pi / lines[2].size
    count = total = 0
    left = keep_free(owner, free)
    for k in range(lines[0].shape[0]):
        theta, c, s, d = to_metres(lines, k, resolution)
        seed = seed_on(x, y, beam, free[:left], c, s, d, gate, cut, near)
        if seed < 0 or repeats(theta, x[seed], y[seed], walls[:count], step, resolution):
            continue
        first = total
        for i in free[:left]:
            if abs(x[i] * c + y[i] * s - d) < gate:
                owner[i] = line[total] = count
                member[total] = i
                total += 1
        turn = step**2 / 12.0
        along = y[seed] * c - x[seed] * s
        fit = (theta, d, turn, along * turn, resolution**2 / 12.0 + along**2 * turn)
        keep_wall(walls[count], fit, total - first)
        count += 1
        left = keep_free(owner, free[:left])
    return walls[:count], line[:total], member[:total]


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
def repeats(
    theta: float, x: float, y: float, walls: FloatArray, step: float, resolution: float
) -> bool:
    """Tell whether a line of points around (x, y) repeats one of `walls`; theta wraps."""
    for k in range(walls.shape[0]):
        turn = abs(walls[k, 0] - theta)
        off = abs(x * math.cos(walls[k, 0]) + y * math.sin(walls[k, 0]) - walls[k, 1])
        if min(turn, math.pi - turn) < WINDOW * step and off < WINDOW * resolution:
            return True
    return False


@helper
def keep_free(owner: IntArray, free: IntArray) -> int:
    """Move the points of `free` that nothing has explained yet to its front; return how many."""
    count = 0
    for i in free:
        if owner[i] == FREE:
            free[count] = i
            count += 1
    return count


@helper
def seed_on(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    free: IntArray,
    c: float,
    s: float,
    d: float,
    gate: float,
    cut: Cut,
    near: IntArray,
) -> int:
    """Return the middle point of the longest run of free points near a line, -1 where none is.

    Between two points of a run, fewer beams than `max_missed` or less than `max_gap` metres miss
    the line. `near` is filled with the points near the line.
    """
    count = first = 0
    most = cut[0] - 1
    seed = -1
    for i in free:
        if abs(x[i] * c + y[i] * s - d) >= gate:
            continue
        if count > 0:
            j = near[count - 1]
            way = abs((y[i] - y[j]) * c - (x[i] - x[j]) * s)
            if beam[i] - beam[j] > cut[1] + 1 and way > cut[2]:
                first = count
        near[count] = i
        count += 1
        if count - first > most:
            most = count - first
            seed = near[first + most // 2]
    return int(seed)
