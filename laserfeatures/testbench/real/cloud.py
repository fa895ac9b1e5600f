"""The points of many scans, gathered in small cells, with the direction of the surface at each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.optional import optional

CELL = 0.05  # [m], side of a cell
RANGE = 15.0  # [m]; farther points say more about the heading's error than about the wall
AROUND = 0.2  # [m], of a cell: its neighbours, which tell its direction
STRIDE = 1 << 31  # between the rows of cells, when a cell is one number


@dataclass(frozen=True, eq=False)
class Cloud:
    """Cells that scans have points in.

    Parameters
    ----------
    points : (C, 2) array
        Mean of the points of each cell [m], in the map's frame.
    weight : (C,) array
        Number of points in each cell.
    normal : (C, 2) array
        Unit vector across the surface at each cell; its sign says nothing.
    spread : (C,) array
        Standard deviation, across that surface, of the points around each cell [m].
    links : (K, 2) int array
        The pairs of neighbouring cells, each once.
    hits : (H, 2) int array
        Cell and number of each scan that has a point in it.
    """

    points: FloatArray
    weight: FloatArray
    normal: FloatArray
    spread: FloatArray
    links: IntArray
    hits: IntArray

    def scans_on(self, members: IntArray) -> int:
        """Return how many scans have a point in one of the cells `members`."""
        return np.unique(self.hits[np.isin(self.hits[:, 0], members), 1]).size


def gather(scans: Sequence[LaserScan], poses: Sequence[Pose2D]) -> Cloud:
    """Return the cells that the points of scans nearer than 15 m fall in.

    Parameters
    ----------
    scans : sequence of LaserScan
        The scans.
    poses : sequence of Pose2D
        Where each was taken.

    Raises
    ------
    MissingDependencyError
        If SciPy is missing.
    """
    parts = [pose.transform(near_points(scan)) for scan, pose in zip(scans, poses, strict=True)]
    points = np.concatenate([np.empty((0, 2)), *parts])
    scan_of = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    grid = np.floor(points / CELL).astype(np.int64)
    keys, cell = np.unique(grid[:, 0] * STRIDE + grid[:, 1], return_inverse=True)
    weight = np.bincount(cell, minlength=keys.size).astype(np.float64)
    sums = [np.bincount(cell, points[:, k], keys.size) for k in (0, 1)]
    centres = np.stack(sums, axis=1) / weight[:, None]
    links = tree_of(centres).query_pairs(AROUND, output_type="ndarray")
    normal, spread = _directions(centres, weight, links)
    hits = np.unique(np.stack([cell, scan_of], axis=1), axis=0)
    return Cloud(centres, weight, normal, spread, links, hits)


def near_points(scan: LaserScan) -> FloatArray:
    """Return the points of a scan nearer than 15 m, in the sensor's frame (P, 2) [m]."""
    near: FloatArray = scan.points[scan.ranges[scan.beams] < RANGE]
    return near


def tree_of(points: FloatArray) -> Any:  # SciPy has no types
    """Return SciPy's k-d tree of points (P, 2).

    Raises
    ------
    MissingDependencyError
        If SciPy is missing.
    """
    return optional("scipy.spatial", "the truth of real scans needs SciPy", "evaluation").KDTree(
        points
    )


def _directions(
    points: FloatArray, weight: FloatArray, links: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Return the direction of least spread around each cell, and that spread."""
    own = np.arange(len(points))
    cell = np.concatenate([own, links[:, 0], links[:, 1]])
    other = np.concatenate([own, links[:, 1], links[:, 0]])
    x, y = (points[other] - points[cell]).T
    w = weight[other]
    total, sx, sy, sxx, sxy, syy = (
        np.bincount(cell, w * part, len(points)) for part in (x**0, x, y, x * x, x * y, y * y)
    )
    mixed = sxy - sx * sy / total
    moments = np.stack([sxx - sx**2 / total, mixed, mixed, syy - sy**2 / total], axis=1)
    values, vectors = np.linalg.eigh(moments.reshape(-1, 2, 2) / total[:, None, None])
    normal: FloatArray = vectors[:, :, 0]
    return normal, np.sqrt(np.maximum(values[:, 0], 0.0))
