"""From one scan to the next: odometry, made better by laying the scans' points over one another.

A grid is searched around the step that odometry gives (correlative matching); from the best place
there, points are drawn to the lines through the other scan's points, with the odometry as prior.
Where other places fit about as well, their spread goes into the covariance.
"""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.compiled import helper, kernel
from laserfeatures.scan import Pose2D

CELL = 0.05  # [m]
BLUR = 0.1  # [m], of the points in the grid
SEARCHED = 120  # points of the new scan that the search takes
ALIGNED = 400  # points that the alignment takes
TURN_STEP = math.radians(1.5)
SHIFT_STEP = 0.1  # [m]
MOST = 1_000_000  # places that are searched; odometry that needs more is as good alone
FARTHEST = 100.0  # [m] off the sensor, along each axis; a grid of more takes over 128 MB
LEAST_TURN, LEAST_SHIFT = math.radians(20), 0.3  # that are searched at least
ROUNDS = 20
FIRST_REACH, LAST_REACH = 0.5, 0.1  # [m] from a point to its match, at first and in the end
HIT = 0.25  # log-likelihood of a point of the search that lies on another one
TEMPERED = 0.5  # of the odometry's in the search, as its errors have heavy tails
NEAR = 2  # cells of the search around its best that are one with it
SCALE = 0.03  # [m]; residuals beyond count less and less (Cauchy)
INDEPENDENT = 0.05  # of the points, as neighbours have the same errors
SPAN = 2  # neighbours on either side that give a point's normal
LONGEST = 0.6  # [m] that these may be apart


def register(
    before: FloatArray, after: FloatArray, step: Pose2D, covariance: FloatArray
) -> tuple[Pose2D, FloatArray]:
    """Return the sensor's step between two scans, and its covariance (3, 3).

    Parameters
    ----------
    before, after : (P, 2), (Q, 2) arrays
        Points of both scans in beam order, in the sensor's frame of each [m]; those very far off
        are left out.
    step : Pose2D
        The step by odometry.
    covariance : (3, 3) array
        Its covariance. Where it is so large that a search would take too long, both are returned
        as they are.

    References
    ----------
    Olson, Real-Time Correlative Scan Matching, ICRA 2009.
    Censi, An ICP Variant Using a Point-to-Line Metric, ICRA 2008.
    """
    before, after = _near(before), _near(after)
    normals, flat = _normals(before)
    deviations = np.sqrt(np.diag(covariance))
    start = np.array([step.x, step.y, step.theta])
    reach = np.array([LEAST_SHIFT, LEAST_SHIFT, LEAST_TURN])
    reach = np.minimum(np.maximum(2.5 * deviations, reach), (math.inf, math.inf, math.pi))
    each = np.array([SHIFT_STEP, SHIFT_STEP, TURN_STEP])
    if flat.sum() < 10 or len(after) < 10 or (2 * reach / each).prod() > MOST:
        return step, covariance
    few = after[:: max(1, len(after) // SEARCHED)]
    low = before.min(axis=0) - 3 * BLUR
    size = np.ceil((before.max(axis=0) + 3 * BLUR - low) / CELL).astype(np.int64)
    grid = _blurred(before, low, size[0], size[1])
    count = np.ceil(reach / each).astype(np.int64)
    scores = _scores(grid, low, few, start, each, count)
    found, others = _best(scores, each, np.diag(covariance))
    some = after[:: max(1, math.ceil(len(after) / ALIGNED))]
    prior = np.asarray(np.linalg.inv(covariance), dtype=np.float64)
    pose, information = _align(before[flat], normals[flat], some, start + found, start, prior)
    return Pose2D(*pose.tolist()), np.linalg.inv(information) + others


def _near(points: FloatArray) -> FloatArray:
    """Return the points that are not too far to be searched for."""
    near = np.abs(points).max(axis=1, initial=0.0) <= FARTHEST
    if near.all():
        return np.ascontiguousarray(points)
    kept = points[near]
    lock(kept)  # as a scan's are: the kernels are compiled for those
    return kept


def _best(
    scores: FloatArray, each: FloatArray, variances: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return where the search fits best (3,), off its middle, and how others spread (3, 3)."""
    axes = [(np.arange(n) - n // 2) * step for n, step in zip(scores.shape, each, strict=True)]
    off = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    likelihood = HIT * scores - TEMPERED / 2 * (off**2 / variances).sum(axis=3)
    best = np.unravel_index(int(likelihood.argmax()), scores.shape)
    weights = np.exp(likelihood - likelihood[best])
    total = weights.sum()
    weights[tuple(slice(max(i - NEAR, 0), i + NEAR + 1) for i in best)] = 0.0
    away = (off - off[best]).reshape(-1, 3)
    spread: FloatArray = (away * weights.reshape(-1, 1)).T @ away / total
    return off[best], spread


def _normals(points: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return each point's unit normal (P, 2), and whether its neighbours are on a line (P,)."""
    count = len(points)
    width = 2 * SPAN + 1
    normals, flat = np.zeros((count, 2)), np.zeros(count, dtype=bool)
    if count < width:
        return normals, flat
    windows = np.lib.stride_tricks.sliding_window_view(points, width, axis=0)
    off = windows - windows.mean(axis=2, keepdims=True)
    spread = off @ off.transpose(0, 2, 1)
    values, vectors = np.linalg.eigh(spread)
    normals[SPAN:-SPAN] = vectors[:, :, 0]
    gap = np.linalg.norm(windows[:, :, -1] - windows[:, :, 0], axis=1)
    flat[SPAN:-SPAN] = (gap < LONGEST) & (values[:, 0] < 0.05 * values[:, 1])
    return normals, flat


@kernel
def _blurred(points: FloatArray, low: FloatArray, wide: int, high: int) -> FloatArray:
    grid = np.zeros((wide, high))
    reach = int(3 * BLUR / CELL)
    for p in range(len(points)):
        x, y = points[p, 0] - low[0], points[p, 1] - low[1]
        row, column = int(x / CELL), int(y / CELL)
        for i in range(max(row - reach, 0), min(row + reach + 1, wide)):
            for j in range(max(column - reach, 0), min(column + reach + 1, high)):
                dx, dy = (i + 0.5) * CELL - x, (j + 0.5) * CELL - y
                grid[i, j] = max(grid[i, j], math.exp(-(dx * dx + dy * dy) / (2 * BLUR * BLUR)))
    return grid


@kernel
def _scores(
    grid: FloatArray,
    low: FloatArray,
    points: FloatArray,
    start: FloatArray,
    each: FloatArray,
    count: IntArray,
) -> FloatArray:
    """Return how many of the points lie on the other scan's, for each step around `start`."""
    scores = np.zeros((2 * count[0] + 1, 2 * count[1] + 1, 2 * count[2] + 1))
    turned = np.empty_like(points)
    for k in range(scores.shape[2]):
        theta = start[2] + (k - count[2]) * each[2]
        c, s = math.cos(theta), math.sin(theta)
        for p in range(len(points)):
            turned[p, 0] = (c * points[p, 0] - s * points[p, 1] - low[0]) / CELL
            turned[p, 1] = (s * points[p, 0] + c * points[p, 1] - low[1]) / CELL
        for i in range(scores.shape[0]):
            x = (start[0] + (i - count[0]) * each[0]) / CELL
            for j in range(scores.shape[1]):
                y = (start[1] + (j - count[1]) * each[1]) / CELL
                for p in range(len(points)):
                    row = math.floor(turned[p, 0] + x)
                    column = math.floor(turned[p, 1] + y)
                    if 0 <= row < grid.shape[0] and 0 <= column < grid.shape[1]:
                        scores[i, j, k] += grid[row, column]
    return scores


@kernel
def _align(
    lines: FloatArray,
    normals: FloatArray,
    points: FloatArray,
    start: FloatArray,
    odometry: FloatArray,
    prior: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the most likely step (3,) and its information (3, 3)."""
    pose = start.copy()
    information = prior.copy()
    reach = FIRST_REACH
    for _ in range(ROUNDS):
        information[:] = prior
        gradient = prior @ (odometry - pose)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        for p in range(len(points)):
            dx, dy = c * points[p, 0] - s * points[p, 1], s * points[p, 0] + c * points[p, 1]
            x, y = dx + pose[0], dy + pose[1]
            i = _nearest(lines, x, y, reach)
            if i < 0:
                continue
            nx, ny = normals[i]
            off = nx * (x - lines[i, 0]) + ny * (y - lines[i, 1])
            weight = INDEPENDENT / (SCALE * SCALE + off * off)
            row = np.array([nx, ny, ny * dx - nx * dy])
            for a in range(3):
                gradient[a] -= weight * off * row[a]
                for b in range(3):
                    information[a, b] += weight * row[a] * row[b]
        step = np.linalg.solve(information, gradient)
        pose += step
        reach = max(LAST_REACH, 0.8 * reach)
        if np.abs(step).max() < 1e-5 and reach == LAST_REACH:
            break
    return pose, information


@helper
def _nearest(points: FloatArray, x: float, y: float, reach: float) -> int:
    best, least = -1, reach * reach
    for i in range(len(points)):
        dx, dy = points[i, 0] - x, points[i, 1] - y
        if dx * dx + dy * dy < least:
            best, least = i, dx * dx + dy * dy
    return best
