"""How true the landmarks of a map are."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.mapping.landmark_truth import TrueMap
from laserfeatures.slam import Landmark

SPURIOUS = 0.3
"""A landmark farther than this [m] from all that is true is spurious.

That is ten times what a landmark is commonly off by: one that is out of place is not taken for one
of nothing. It is near enough all the same to tell: of points thrown into the office loop at random,
8 % come as near to one of its true corners, and 3 % to a real one.
"""
TILT = math.radians(15)  # the paper's limit below which lines are one: so are a wall and its truth
OVERLAP = 0.5  # of the shorter of two walls, from where on they are the same part of a line


@dataclass(frozen=True, kw_only=True)
class LandmarkScore:
    """How true landmarks are.

    Parameters
    ----------
    landmarks : int
        How many there are.
    virtual : int
        How many are at virtual corners.
    spurious : int
        How many are farther than `SPURIOUS` from all true things of their kind.
    doubled : int
        How many are of the same true corner, or of the same part of a true wall, as another one.
    median_error : float
        Median of all distances from what is true [m]; nan without landmarks, or without truth.
    """

    landmarks: int
    virtual: int
    spurious: int
    doubled: int
    median_error: float


def score_landmarks(landmarks: Sequence[Landmark], truth: TrueMap) -> LandmarkScore:
    """Return how true landmarks are, each held against the nearest true thing of its kind.

    A corner's error is its distance from the nearest true corner, real or virtual. A wall's is the
    larger distance of its two ends from the nearest true line; it must run along that one, within
    15 degrees, and its middle must be where there is wall or a gap between walls.
    """
    corners = np.array([each.values for each in landmarks if each.kind == "corner"]).reshape(-1, 2)
    walls = np.array([each.ends for each in landmarks if each.kind == "wall"]).reshape(-1, 2, 2)
    at, away = _nearest(np.linalg.norm(corners[:, None] - truth.corners[None], axis=2))
    along, off = _nearest(_from_walls(walls, truth.walls))
    corner_known, wall_known = away <= SPURIOUS, off <= SPURIOUS
    errors = np.concatenate([away, off])
    median = float(np.median(errors)) if errors.size else math.nan
    return LandmarkScore(
        landmarks=len(landmarks),
        virtual=int((~truth.real[at[corner_known]]).sum()),
        spurious=int((errors > SPURIOUS).sum()),
        doubled=int(corner_known.sum())
        - np.unique(at[corner_known]).size
        + sum(
            _overlapping(walls[wall_known & (along == i)], truth.walls[i])
            for i in np.unique(along[wall_known])
        ),
        median_error=median if math.isfinite(median) else math.nan,
    )


def _nearest(away: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return which true thing (N,) is nearest to each landmark, and how far it is, from (N, K)."""
    if not away.size:
        return np.zeros(len(away), dtype=np.int64), np.full(len(away), math.inf)
    nearest = away.argmin(axis=1)
    return nearest, away[np.arange(len(away)), nearest]


def _from_walls(walls: FloatArray, truth: FloatArray) -> FloatArray:
    """Return how far walls (N, 2, 2) are from true ones (K, 2, 2); inf if not along it, (N, K)."""
    step = truth[:, 1] - truth[:, 0]
    length = np.linalg.norm(step, axis=1)
    along = step / length[:, None]
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    offset = walls[:, None] - truth[None, :, :1]  # (N, K, 2 ends, 2)
    off = abs((offset * normal[None, :, None]).sum(axis=3)).max(axis=2)
    middle = (offset.mean(axis=2) * along[None]).sum(axis=2)
    own = walls[:, 1] - walls[:, 0]
    across = abs(own @ normal.T)
    parallel: BoolArray = across <= math.sin(TILT) * np.linalg.norm(own, axis=1)[:, None]
    beside = (middle >= -SPURIOUS) & (middle <= length + SPURIOUS)
    return np.where(parallel & beside, off, math.inf)


def _overlapping(walls: FloatArray, line: FloatArray) -> int:
    """Return how many walls (N, 2, 2) of one line lie beside a longer one."""
    along = (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])
    spans = np.sort((walls - line[0]) @ along, axis=1)
    spans = spans[np.argsort(spans[:, 0] - spans[:, 1])]  # the longest first
    count = 0
    for i, (start, end) in enumerate(spans):
        shared = np.minimum(spans[:i, 1], end) - np.maximum(spans[:i, 0], start)
        count += bool((shared > OVERLAP * (end - start)).any())
    return count
