"""What is true of a scan that was taken in a building with a plan."""

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.evaluation import Truth
from laserfeatures.evaluation.true_lines import cross, normalised
from laserfeatures.simulation.distances import to_walls
from laserfeatures.testbench.real.alignment import Locator
from laserfeatures.testbench.real.plan import Plan
from laserfeatures.testbench.real.view import View

AT_WALL = 0.1  # [m], of a point from the cells of its wall
ON_LINE = 0.05  # [m], of a point from its wall's line
MIN_BEAMS = 4
REACH = 0.2  # [m], of a real corner from a wall that beams hit
KNOWN = 0.2 / 3  # [m], standard deviation of a corner in the plan: a third of the gate


def view_in(locator: Locator, scan: LaserScan, pose: Pose2D) -> View:
    """Return what the plan says of a scan taken at `pose`.

    A beam measures the nearest wall if its point is within 5 cm of that wall's line. A line is true
    of the scan if four returns in a row measure it. The true corners are the crossings of the true
    lines (the paper, II.D), real where walls that beams measure come within 20 cm of it on both
    lines. A crossing that the plan knows worse than to 67 mm (one standard deviation) is unsure.

    Parameters
    ----------
    locator : Locator
        Of the plan.
    scan : LaserScan
        The scan.
    pose : Pose2D
        Where in the plan it was taken.
    """
    plan = locator.plan
    near, off = locator.nearest(pose.transform(scan.points), AT_WALL)
    wall = np.where(abs(off) < ON_LINE, near, -1)
    line = np.where(wall >= 0, plan.line[wall], -1)
    kept = np.flatnonzero(_longest_runs(line, plan.theta.size) >= MIN_BEAMS)
    number = np.full(plan.theta.size + 1, -1)
    number[kept] = np.arange(kept.size)
    beams = np.full(len(scan), -1)
    beams[scan.beams] = number[line]
    known = np.zeros(len(scan), np.bool_)
    known[scan.beams] = wall >= 0
    normal = np.stack([np.cos(plan.theta[kept]), np.sin(plan.theta[kept])], axis=1)
    theta, d = normalised(plan.theta[kept] - pose.theta, plan.d[kept] - normal @ (pose.x, pose.y))
    corners, pairs = cross(theta, d)
    at = pose.transform(corners)
    sure = np.array(
        [_sigma(plan, kept[p], q) < KNOWN for p, q in zip(pairs, at, strict=True)], np.bool_
    )
    seen = np.unique(wall[wall >= 0])
    pieces = [plan.ends[seen[plan.line[seen] == k]] for k in kept]
    real = np.array(
        [_meet(pieces[i], pieces[j], q) for (i, j), q in zip(pairs, at, strict=True)], np.bool_
    )
    truth = Truth(
        theta=theta, d=d, line=beams, corners=corners[sure], pairs=pairs[sure], real=real[sure]
    )
    return View(scan, truth, known, pairs[~sure])


def _longest_runs(line: IntArray, lines: int) -> IntArray:
    """Return the length of the longest run of each line in the lines of the returns, (lines,)."""
    longest = np.zeros(lines + 1, np.int64)  # the last one is of no line
    starts = np.flatnonzero(np.diff(line, prepend=-2))
    np.maximum.at(longest, line[starts], np.diff(np.append(starts, line.size)))
    return longest[:-1]


def _sigma(plan: Plan, pair: IntArray, at: FloatArray) -> float:
    """Return the standard deviation of a crossing of two lines, along its worst direction [m]."""
    normal = np.stack([np.cos(plan.theta[pair]), np.sin(plan.theta[pair])], axis=1)
    away = at - plan.middle[pair]
    along = away[:, 1] * normal[:, 0] - away[:, 0] * normal[:, 1]
    variance = plan.variance[pair, 0] + along**2 * plan.variance[pair, 1]
    inverse = np.linalg.inv(normal)
    return float(np.sqrt(np.linalg.eigvalsh((inverse * variance) @ inverse.T)[1]))


def _meet(one: FloatArray, other: FloatArray, point: FloatArray) -> bool:
    return _reaches(one, point) and _reaches(other, point)


def _reaches(walls: FloatArray, point: FloatArray) -> bool:
    """Tell whether one of some walls (P, 2, 2) comes within 20 cm of a point."""
    return bool(to_walls(walls, *point.reshape(2, 1, 1)).min() <= REACH)
