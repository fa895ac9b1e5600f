"""A robot's way through the hallway as a CARMEN log, with odometry that drifts."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np

from laserfeatures.data import Pose2D
from laserfeatures.poses import compose
from laserfeatures.simulation import Scanner, hallway

PERIOD = 0.25  # [s]
RIGHT = 5  # steps, so that the first landmarks are where they belong
TURNED_TOO_FAR = math.radians(0.4)  # by the odometry, at each step after these


def drive(steps=6):
    """Return the true poses along the hallway's path, `steps` from way-point to way-point."""
    _, path = hallway()
    known = np.array([(pose.x, pose.y, pose.theta) for pose in path])
    at = np.arange(0, len(path) - 1 + 1e-9, 1 / steps)
    columns = [np.interp(at, np.arange(len(path)), column) for column in known.T]
    return [Pose2D(*map(float, row)) for row in np.stack(columns, axis=1)]


def drifted(truth):
    """Return the same way by odometry, which starts right and turns too far."""
    poses = [truth[0]]
    for number, (before, after) in enumerate(pairwise(truth)):
        c, s = math.cos(-before.theta), math.sin(-before.theta)
        dx, dy = after.x - before.x, after.y - before.y
        turn = after.theta - before.theta + TURNED_TOO_FAR * (number >= RIGHT)
        step = Pose2D(c * dx - s * dy, s * dx + c * dy, turn)
        poses.append(compose(poses[-1], step))
    return poses


def write_log(path, truth, odometry, stamps=None, *, corrected=True):
    """Write scans from the true poses; with these, or with the odometry alone."""
    world, _ = hallway()
    rng = np.random.default_rng(1)
    lines = ["NEFF 0.5 0 host 0\n"] if corrected else []
    times = PERIOD * np.arange(len(truth)) if stamps is None else stamps
    for pose, moved, stamp in zip(truth, odometry, times, strict=True):
        ranges = Scanner().scan(world, pose, rng).ranges
        values = " ".join(f"{r:.3f}" for r in ranges)
        first, second = (
            f"{each.x:.6f} {each.y:.6f} {each.theta:.6f}"
            for each in (pose if corrected else moved, moved)
        )
        lines.append(
            f"FLASER {ranges.size} {values} {first} {second} {stamp:.6f} host {stamp:.6f}\n"
        )
    Path(path).write_text("".join(lines), encoding="ascii")
    return str(path)
