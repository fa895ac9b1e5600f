"""A small matcher of two scans: points to lines, robust, from a first guess of the pose."""

import math

import numpy as np
from scipy.spatial import cKDTree

from laserfeatures.data import Pose2D

NEIGHBOURS = 3  # on either side, that give a point its normal
GATES = (0.3, 0.2, 0.15, 0.1, 0.1, 0.05, 0.05, 0.05)  # [m], largest gap of a pair, step by step
FLAT = 0.03  # [m], rms of a point's neighbours off their line; beyond it the point has no normal
SPACING = 0.5  # [m]; neighbours that span more than this on either side are not one surface
HUBER = 0.01  # [m]; what is farther off the line weighs less
LEAST = 40  # pairs
STIFF = 1e-3  # least eigenvalue of the normal equations, as a share of the pairs
MOVES = 0.15, math.radians(3)  # the farthest that a match may move a pose from the guess


class Matcher:
    """The points of one scan in beam order, to which others are matched."""

    def __init__(self, points):
        self.tree = cKDTree(points) if len(points) else None
        self.points = points
        self.normals, self.flat = _normals(points)

    def distances(self, points):
        """Return how far points are from the nearest of this scan [m]."""
        return np.full(len(points), math.inf) if self.tree is None else self.tree.query(points)[0]

    def pose(self, points, guess):
        """Return the pose that takes another scan's points to this one; None if it is not known."""
        pose = guess
        for gate in GATES:
            pose = self._step(points, pose, gate)
            if pose is None:
                return None
        moved = math.hypot(pose.x - guess.x, pose.y - guess.y)
        turned = abs(math.remainder(pose.theta - guess.theta, math.tau))
        return pose if moved < MOVES[0] and turned < MOVES[1] else None

    def _step(self, points, pose, gate):
        """Return the pose after one step of weighted least squares."""
        if self.tree is None:
            return None
        moved = pose.transform(points)
        gap, nearest = self.tree.query(moved)
        use = (gap < gate) & self.flat[nearest]
        if use.sum() < LEAST:
            return None
        at, normal = moved[use], self.normals[nearest[use]]
        error = ((self.points[nearest[use]] - at) * normal).sum(axis=1)
        arm = at - (pose.x, pose.y)
        lever = arm[:, 0] * normal[:, 1] - arm[:, 1] * normal[:, 0]
        rows = np.column_stack([normal, lever])
        weight = np.minimum(1.0, HUBER / np.maximum(abs(error), HUBER))
        information = rows.T @ (weight[:, None] * rows)
        if np.linalg.eigvalsh(information)[0] < STIFF * len(error):
            return None
        x, y, turn = np.linalg.solve(information, rows.T @ (weight * error))
        return Pose2D(pose.x + x, pose.y + y, pose.theta + turn)


def _normals(points):
    """Return a unit normal at each point (N, 2), and which points lie on a flat surface."""
    count = 2 * NEIGHBOURS + 1
    if len(points) < count:
        return np.zeros((len(points), 2)), np.zeros(len(points), bool)
    windows = np.lib.stride_tricks.sliding_window_view(points, count, axis=0)  # (M, 2, count)
    off = windows - windows.mean(axis=2, keepdims=True)
    spread, axes = np.linalg.eigh(off @ off.transpose(0, 2, 1) / count)
    span = np.hypot(*(windows[..., -1] - windows[..., 0]).T)
    flat = (spread[:, 0] < FLAT**2) & (span < 2 * SPACING) & (spread[:, 0] < 0.05 * spread[:, 1])
    first = np.clip(np.arange(len(points)) - NEIGHBOURS, 0, len(windows) - 1)
    inner = abs(np.arange(len(points)) - NEIGHBOURS - first) == 0
    return axes[first, :, 0], flat[first] & inner
