"""A real scan with what is true of it, and where the truth has nothing to say."""

from dataclasses import dataclass, replace

import numpy as np

from laserfeatures.arrays import BoolArray, IntArray
from laserfeatures.data import Features, LaserScan
from laserfeatures.evaluation import Truth

BESIDE = 0.3  # [m], of a corner without lines: the returns that tell whether it can be judged


@dataclass(frozen=True, eq=False)
class View:
    """A scan and what is true of it.

    Parameters
    ----------
    scan : LaserScan
        The scan.
    truth : Truth
        Its true lines and corners, as far as they are known.
    known : (N,) bool array
        Which beams measure something that is known; the others have no return, or hit what no map
        shows: people, clutter, rooms behind a door.
    unsure : (U, 2) int array
        Pairs of true lines that cross where the map cannot say to the third of the gate.
    """

    scan: LaserScan
    truth: Truth
    known: BoolArray
    unsure: IntArray


def judged(features: Features, view: View) -> Features:
    """Return what was found without the corners of which the truth cannot say right or wrong.

    These are corners of a line with less than half of its points on what is known, crossings of two
    true lines that are unsure, and, of corners without lines, those with less than half of the
    returns within 0.3 m on what is known.
    """
    corners = features.corners
    if features.lines.theta.size:
        keep = _lines_judged(features, view)
    else:
        points = view.scan.ranges[:, None] * view.scan.directions
        away = np.hypot(*(points[None] - corners.positions[:, None]).transpose(2, 0, 1))
        beside = (away < BESIDE) & view.scan.valid
        keep = 2 * (beside & view.known).sum(axis=1) >= beside.sum(axis=1)
    return replace(features, corners=corners.select(keep))


def _lines_judged(features: Features, view: View) -> BoolArray:
    """Return which corners are judged, given that all are of lines."""
    segments, truth = features.segments, view.truth
    members = np.zeros((len(features.lines), len(view.scan)), np.bool_)
    np.logical_or.at(members, segments.line, segments.points)
    support = members.sum(axis=1)
    told = 2 * (members & view.known).sum(axis=1) >= support
    none = truth.theta.size
    numbers = np.append(np.arange(none), -2)  # no beam has the last one
    shared = members.astype(np.int64) @ (truth.line[:, None] == numbers)
    main = np.where(2 * shared.max(axis=1) >= support, shared.argmax(axis=1), none)
    unsure = np.zeros((none + 1, none + 1), np.bool_)
    unsure[view.unsure[:, 0], view.unsure[:, 1]] = True
    unsure |= unsure.T
    first, second = features.corners.lines.T
    keep: BoolArray = told[first] & told[second] & ~unsure[main[first], main[second]]
    return keep
