"""The plan of a building: its walls, and the lines that carry them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.evaluation.true_lines import normalised
from laserfeatures.testbench.real.cloud import Cloud, gather
from laserfeatures.testbench.real.walls import along_and_across, fit, grow

GIVE = 0.04  # [m]: walls that end this near to one line lie on it
COPY = 0.08  # [m]: of walls this near and over one another, one is the other, mapped twice
SIGMA = 0.02  # [m], of where one scan, in its pose, puts a wall
FLOOR = 0.005  # [m], which many scans do not get below


@dataclass(frozen=True, eq=False)
class Plan:
    """The walls of a building and the lines that carry them.

    Parameters
    ----------
    ends : (W, 2, 2) array
        Both ends of each wall [m].
    line : (W,) int array
        Number of the line that each wall lies on.
    theta, d : (L,) arrays
        The lines [rad, m], in the map's frame.
    middle : (L, 2) array
        Mean of the points on each line [m].
    variance : (L, 2) array
        Variance of each line's offset at its middle [m^2] and of its direction [rad^2].
    cells : (C, 2) array
        Points all along the walls [m].
    wall : (C,) int array
        Number of the wall that each of these lies on.
    """

    ends: FloatArray
    line: IntArray
    theta: FloatArray
    d: FloatArray
    middle: FloatArray
    variance: FloatArray
    cells: FloatArray
    wall: IntArray


def plan_of(scans: Sequence[LaserScan], poses: Sequence[Pose2D]) -> Plan:
    """Draw the plan that scans show.

    All their points are gathered in cells of 5 cm; straight walls are grown from cell to cell,
    fitted by least squares to all points on them. Walls whose ends lie within 4 cm of one line
    share it.

    Parameters
    ----------
    scans : sequence of LaserScan
        The scans.
    poses : sequence of Pose2D
        Where each was taken, in one frame for all.

    Raises
    ------
    MissingDependencyError
        If SciPy is missing.
    """
    cloud = gather(scans, poses)
    walls, ends = _without_copies(cloud, grow(cloud))
    lines = _joined(cloud, walls, ends)
    merged = [np.concatenate([walls[k] for k in line]) for line in lines]
    fits = [np.stack(fit(cloud, members)) for members in merged]
    middle, normal = np.array(fits).reshape(-1, 2, 2).transpose(1, 0, 2)
    theta, d = normalised(np.arctan2(normal[:, 1], normal[:, 0]), (middle * normal).sum(axis=1))
    line_of = np.empty(len(walls), np.int64)
    for number, line in enumerate(lines):
        line_of[line] = number
    return Plan(
        ends=ends,
        line=line_of,
        theta=theta,
        d=d,
        middle=middle,
        variance=np.array([_variance(cloud, members) for members in merged]).reshape(-1, 2),
        cells=cloud.points[np.concatenate([np.empty(0, np.int64), *walls])],
        wall=np.repeat(np.arange(len(walls)), [members.size for members in walls]),
    )


def _ends(cloud: Cloud, members: IntArray) -> FloatArray:
    """Return both ends of a wall, (2, 2)."""
    centre, normal = fit(cloud, members)
    along, _ = along_and_across(cloud, members)
    return centre + np.outer((along.min(), along.max()), (-normal[1], normal[0]))


def _without_copies(cloud: Cloud, walls: list[IntArray]) -> tuple[list[IntArray], FloatArray]:
    """Return the walls that do not run over a longer one, and their ends."""
    kept: list[IntArray] = []
    ends = np.empty((0, 2, 2))
    for members in walls:
        own = _ends(cloud, members)
        if not _is_copy(own, ends):
            kept.append(members)
            ends = np.concatenate([ends, own[None]])
    return kept, ends


def _is_copy(own: FloatArray, others: FloatArray) -> bool:
    step = others[:, 1] - others[:, 0]
    length = np.hypot(*step.T)
    along = step / length[:, None]
    away = own[None] - others[:, :1]
    reach = np.einsum("wek,wk->we", away, along)
    off = away[:, :, 1] * along[:, None, 0] - away[:, :, 0] * along[:, None, 1]
    shared = np.minimum(reach.max(axis=1), length) - np.maximum(reach.min(axis=1), 0)
    copied = (shared > 0.5 * np.ptp(reach, axis=1)) & (abs(off).max(axis=1) < COPY)
    return bool(copied.any())


def _joined(cloud: Cloud, walls: list[IntArray], ends: FloatArray) -> list[list[int]]:
    """Return the numbers of the walls of each line; the longest walls choose first."""
    lines: list[list[int]] = []
    centre, normal = np.empty((2, len(walls), 2))  # of each line
    for wall, own in enumerate(ends):
        away = np.einsum("lek,lk->le", own - centre[: len(lines), None], normal[: len(lines)])
        best, least = len(lines), GIVE
        for number in np.flatnonzero(abs(away).max(axis=1) < 5 * GIVE):  # worth a fit
            together = [*lines[number], wall]
            middle, across = fit(cloud, np.concatenate([walls[k] for k in together]))
            off = float(abs((ends[together] - middle) @ across).max())
            if off < least:
                best, least = int(number), off
        if best == len(lines):
            lines.append([])
        lines[best].append(wall)
        centre[best], normal[best] = fit(cloud, np.concatenate([walls[k] for k in lines[best]]))
    return lines


def _variance(cloud: Cloud, members: IntArray) -> tuple[float, float]:
    """Return a line's variances: scans count, not points, for a scan's points err together."""
    along, _ = along_and_across(cloud, members)
    mean = SIGMA**2 / cloud.scans_on(members)
    return mean + FLOOR**2, mean / float(np.mean(along**2))
