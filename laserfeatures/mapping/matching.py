"""Which pose of a run goes with which one of a reference."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.errors import SourceError
from laserfeatures.mapping.reference import Reference
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.optional import optional

ENOUGH = 0.5  # of the shorter trajectory must match by stamp, where scan numbers could do


@dataclass(frozen=True, eq=False)
class Matched:
    """Pairs of poses.

    Parameters
    ----------
    estimate, reference : (K,) int arrays
        Numbers of the poses that go together, in the run and in the reference.
    by : "stamp" or "scan"
        Whether they were taken at the same time, or in the same scan.
    """

    estimate: IntArray
    reference: IntArray
    by: Literal["stamp", "scan"]

    def pairs(self, estimate: Trajectory, reference: Trajectory) -> tuple[Trajectory, Trajectory]:
        """Return both trajectories' matched poses, in pairs."""
        return part(estimate, self.estimate), part(reference, self.reference)


def part(trajectory: Trajectory, which: IntArray) -> Trajectory:
    """Return some poses of a trajectory, in the order that is given."""
    return Trajectory(stamps=trajectory.stamps[which], poses=trajectory.poses[which])


def matched(estimate: Trajectory, reference: Reference) -> Matched:
    """Match the poses of a run and a reference.

    By their stamps, where both have such as tell time: each pose of the run with the nearest one of
    the reference, at most half a period away (of the two periods the shorter). Else by the number
    of the scan, for which both must have as many poses.

    Raises
    ------
    SourceError
        If neither is possible; the message says how many poses and which times there are.
    MissingDependencyError
        If evo is not installed.
    """
    other = reference.trajectory
    pairs = _by_stamp(estimate.stamps, other.stamps)
    known = np.isfinite(other.poses[:, 0] + other.poses[:, 1])
    pairs = pairs[:, known[pairs[1]]]
    shorter = min(len(estimate), len(other))
    if pairs.shape[1] >= max(ENOUGH * shorter, 1):
        return Matched(pairs[0], pairs[1], "stamp")
    if len(estimate) == len(other):
        numbers = np.flatnonzero(known)
        return Matched(numbers, numbers, "scan")
    if pairs.shape[1] >= 3:
        return Matched(pairs[0], pairs[1], "stamp")
    raise SourceError(
        f"{reference.path}: expected a reference of this log, got one of {len(other)} poses "
        f"{_span(other.stamps)} for {len(estimate)} scans {_span(estimate.stamps)}: neither their "
        "times nor their numbers match"
    )


def _by_stamp(stamps: FloatArray, others: FloatArray) -> IntArray:
    """Return pairs (2, K) of nearest stamps, each of either side at most once."""
    period = min(_period(stamps), _period(others))
    if not period:
        return np.empty((2, 0), dtype=np.int64)
    sync = optional("evo.core.sync", "matching of trajectories needs evo", "slam")
    mine, theirs = sync.matching_time_indices(stamps, others, period / 2)
    _, first = np.unique(np.array(theirs, dtype=np.int64), return_index=True)
    pairs = np.array([mine, theirs], dtype=np.int64)
    return pairs[:, np.sort(first)]


def _period(stamps: FloatArray) -> float:
    """Return the median time between two poses [s]; 0 where the stamps do not tell time."""
    if len(stamps) < 2 or not np.isfinite(stamps).all():
        return 0.0
    return max(float(np.median(np.diff(stamps))), 0.0)


def _span(stamps: FloatArray) -> str:
    known = stamps[np.isfinite(stamps)]
    return f"({known.min():.3f} to {known.max():.3f} s)" if known.size else "(without stamps)"
