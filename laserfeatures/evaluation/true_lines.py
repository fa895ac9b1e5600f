"""Lines (theta, d) as truth needs them: of two points, merged where collinear, and crossed."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray

SAME = 1e-6  # [rad] and [m]; walls on one line were drawn on one line
MIN_ANGLE = math.radians(15)  # lines that cross at less have no corner
MAX_DISTANCE = 20.0  # [m], of a corner from the sensor: the paper's limit


def lines_through(ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return theta in [0, pi) and d of the line through each pair of points, (K, 2, 2)."""
    step = ends[:, 1] - ends[:, 0]
    normal = np.arctan2(step[:, 0], -step[:, 1])
    return normalised(normal, ends[:, 0, 0] * np.cos(normal) + ends[:, 0, 1] * np.sin(normal))


def normalised(theta: FloatArray, d: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same lines with theta in [0, pi)."""
    turns = np.floor(theta / math.pi)
    theta = np.maximum(theta - turns * math.pi, 0.0)  # rounding may leave a hair less
    whole = theta >= math.pi  # what rounding makes of a tiny negative angle
    return np.where(whole, 0.0, theta), np.where((turns + whole) % 2, -d, d)


def difference(
    theta: FloatArray, d: FloatArray, true_theta: FloatArray, true_d: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return errors of theta [rad] and d [m], signed as the first line counts them.

    Theta wraps at pi, where d changes its sign.
    """
    turn = theta - true_theta
    wraps = np.round(turn / math.pi)
    return turn - wraps * math.pi, d - np.where(wraps % 2, -true_d, true_d)


def merge_collinear(theta: FloatArray, d: FloatArray) -> IntArray:
    """Return for each line the number of the first line that is the same, (K,)."""
    turn, shift = difference(theta[:, None], d[:, None], theta[None], d[None])
    same = (abs(turn) < SAME) & (abs(shift) < SAME)
    numbers = np.where(same, np.arange(theta.size), theta.size)
    first: IntArray = numbers.min(axis=1, initial=theta.size)
    return first


def cross(theta: FloatArray, d: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the corners (K, 2) of lines and the pair of lines that each belongs to, (K, 2).

    A corner is a crossing at 15 degrees or more within 20 m of the sensor (the paper, II.D, III.C).
    """
    i, j = np.triu_indices(theta.size, 1)
    c, s = np.cos(theta), np.sin(theta)
    det = c[i] * s[j] - s[i] * c[j]
    steep = abs(det) >= math.sin(MIN_ANGLE) - 1e-12
    i, j, det = i[steep], j[steep], det[steep]
    x = (d[i] * s[j] - d[j] * s[i]) / det
    y = (d[j] * c[i] - d[i] * c[j]) / det
    near = np.hypot(x, y) <= MAX_DISTANCE
    return np.stack([x[near], y[near]], axis=1), np.stack([i[near], j[near]], axis=1)
