"""Which of what was found is which of what is true, one to one."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LineSegments
from laserfeatures.evaluation.truth import Truth
from laserfeatures.optional import optional

GATE = 0.2  # [m], of a corner from its true one


def match_corners(
    found: FloatArray, true: FloatArray, gate: float = GATE
) -> tuple[IntArray, IntArray]:
    """Pair points one to one, as many as can be within `gate` metres and then the nearest.

    Parameters
    ----------
    found : (F, 2) array
        Points found [m].
    true : (K, 2) array
        True points [m].
    gate : float
        Largest distance of a pair [m].

    Returns
    -------
    tuple of (M,) int arrays
        The numbers of the points found, and those of their true ones.

    Raises
    ------
    ValueError
        If the gate is not a distance.
    MissingDependencyError
        If SciPy is missing.
    """
    if not 0 < gate < math.inf:
        raise ValueError(f"gate must be > 0 m and finite, got {gate!r}")
    gaps = np.hypot(*(found[:, None] - true[None]).transpose(2, 0, 1))
    # A pair that is too far costs more than all near pairs together.
    rows, columns = _assign(np.where(gaps <= gate, gaps, gate * (1 + min(gaps.shape))))
    near = gaps[rows, columns] <= gate
    return rows[near], columns[near]


def match_lines(segments: LineSegments, truth: Truth) -> tuple[IntArray, int]:
    """Pair lines with true lines by the beams that they share.

    Parameters
    ----------
    segments : LineSegments
        What was found.
    truth : Truth
        What is true; its lines must be known.

    Returns
    -------
    (L,) int array
        Number of each line's true line, -1 where it has none: less than half of its points are of
        one true line, or another line has that.
    int
        Number of duplicates: lines on a true line that another line has.

    Raises
    ------
    ValueError
        If they are of scans of different sizes.
    MissingDependencyError
        If SciPy is missing.
    """
    if segments.points.shape[1] != truth.line.size:
        raise ValueError(
            f"features and truth must be of one scan, got {segments.points.shape[1]} and "
            f"{truth.line.size} beams"
        )
    members = np.zeros((len(segments.lines), truth.line.size), dtype=np.int64)
    np.logical_or.at(members, segments.line, segments.points)
    on_line = truth.line[None] == np.arange(truth.theta.size)[:, None]
    shared = members @ on_line.T
    mostly = (shared > 0) & (2 * shared >= members.sum(axis=1)[:, None])
    wall = np.full(len(segments.lines), -1)
    rows, columns = _assign(-np.where(mostly, shared, 0))
    taken = mostly[rows, columns]
    wall[rows[taken]] = columns[taken]
    return wall, int((mostly.any(axis=1) & (wall < 0)).sum())


def _assign(cost: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the rows and columns of the one-to-one assignment of the least cost."""
    optimize = optional("scipy.optimize", "scores need SciPy", "evaluation")
    rows, columns = optimize.linear_sum_assignment(cost)
    return rows, columns
