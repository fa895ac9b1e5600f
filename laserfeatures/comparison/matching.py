"""Corners told to be the same: again in the next scan, and by another extractor."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.data import LaserScan, Pose2D


@dataclass(frozen=True, kw_only=True)
class Share:
    """So many of so many."""

    found: int = 0
    judged: int = 0

    @property
    def value(self) -> float:
        """Found per judged; nan where none was judged."""
        return self.found / self.judged if self.judged else math.nan

    def plus(self, found: BoolArray) -> "Share":
        """Return the share with those cases besides."""
        return Share(found=self.found + int(found.sum()), judged=self.judged + found.size)


@dataclass(frozen=True, kw_only=True)
class Repeatability:
    """How many corners of a scan are found again in the next one.

    Parameters
    ----------
    pairs : int
        Number of neighbouring scans that both have a pose.
    in_view : Share
        Of the corners that lie in the next scan's field of view and range.
    in_sight : Share
        Of those among them that nothing nearer hides.
    """

    pairs: int
    in_view: Share
    in_sight: Share


def repeatability(
    scans: Sequence[LaserScan], positions: Sequence[FloatArray], tolerance: float
) -> Repeatability:
    """Measure how many corners of a scan are found again in the next one.

    The scans' poses move the corners from one into the other; scans without a pose are left out.

    Parameters
    ----------
    scans : sequence of LaserScan
        The scans in order.
    positions : sequence of (F, 2) arrays
        The corners found in each, in the sensor's frame [m].
    tolerance : float
        Greatest distance of a corner found again [m].

    Raises
    ------
    ValueError
        If there are not as many scans as arrays.

    References
    ----------
    C. Schmid, R. Mohr and C. Bauckhage, "Evaluation of Interest Point Detectors", IJCV 37(2),
    2000: the share found in both views of what lies in both.
    """
    pairs, in_view, in_sight = 0, Share(), Share()
    for i, after, every, inside in moved_on(scans, positions):
        pairs += 1
        moved = every[inside]
        found = near(moved, positions[i + 1], tolerance)
        in_view = in_view.plus(found)
        in_sight = in_sight.plus(found[_unhidden(after, moved, tolerance)])
    return Repeatability(pairs=pairs, in_view=in_view, in_sight=in_sight)


def moved_on(
    scans: Sequence[LaserScan], positions: Sequence[FloatArray]
) -> Iterator[tuple[int, LaserScan, FloatArray, BoolArray]]:
    """Move the corners of each scan into the next one, where both have a pose.

    Parameters
    ----------
    scans : sequence of LaserScan
        The scans in order.
    positions : sequence of (F, 2) arrays
        The corners found in each, in the sensor's frame [m].

    Yields
    ------
    tuple
        Number of the scan, the next scan, the corners in its sensor's frame (F, 2) [m], and which
        of them lie in its field of view and range (F,).

    Raises
    ------
    ValueError
        If there are not as many scans as arrays.
    """
    numbered = zip(range(len(scans)), scans, positions, strict=True)
    for (i, scan, corners), (_, after, _) in pairwise(numbered):
        if scan.pose is not None and after.pose is not None:
            moved = _into(after.pose, scan.pose.transform(corners))
            yield i, after, moved, _inside_view(after, moved)


def agreement(found: Sequence[Sequence[FloatArray]], tolerance: float) -> FloatArray:
    """Return the share of each extractor's corners that each other one has, (E, E).

    Parameters
    ----------
    found : sequence of sequences of (F, 2) arrays
        For each of E extractors the corners of each scan [m].
    tolerance : float
        Greatest distance of the same corner [m].

    Returns
    -------
    (E, E) array
        Row a, column b: share of the corners of a with one of b near it; nan where a has none.
    """
    shares = np.empty((len(found), len(found)))
    for a, own in enumerate(found):
        for b, theirs in enumerate(found):
            share = Share()
            for corners, others in zip(own, theirs, strict=True):
                share = share.plus(near(corners, others, tolerance))
            shares[a, b] = share.value
    return shares


def near(corners: FloatArray, others: FloatArray, tolerance: float) -> BoolArray:
    """Tell which of `corners` (F, 2) have one of `others` (G, 2) within `tolerance` [m], (F,)."""
    away = np.linalg.norm(corners[:, None] - others[None], axis=2)
    found: BoolArray = away.min(axis=1, initial=np.inf) <= tolerance
    return found


def _into(pose: Pose2D, points: FloatArray) -> FloatArray:
    """Return points (N, 2) of the frame that `pose` is given in, in the frame of `pose`."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    moved: FloatArray = (points - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    return moved


def _inside_view(scan: LaserScan, points: FloatArray) -> BoolArray:
    """Tell which points lie between the first and the last beam and in the sensor's range."""
    if not len(scan):
        return np.zeros(len(points), np.bool_)
    first, last = scan.angles[0], scan.angles[-1]
    turned = (np.arctan2(points[:, 1], points[:, 0]) - first) % (2 * np.pi)
    away = np.linalg.norm(points, axis=1)
    inside: BoolArray = (
        (turned <= last - first) & (away >= scan.range_min) & (away < scan.range_max)
    )
    return inside


def _unhidden(scan: LaserScan, points: FloatArray, tolerance: float) -> BoolArray:
    """Tell which points a beam reached: it passed within `tolerance` and measured as far."""
    directions, ranges = scan.directions[scan.beams], scan.ranges[scan.beams]
    along = points @ directions.T
    across = points[:, :1] * directions[:, 1] - points[:, 1:] * directions[:, 0]
    passes = (along > 0) & (np.abs(across) <= tolerance)
    reaches = ranges >= along - tolerance
    seen: BoolArray = np.any(passes & reaches, axis=1)
    return seen
