"""What is odd about the odometry and the stamps of a log, each in one line."""

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.mapping.trajectory import Trajectory

PERIODS = 4.0  # median periods, and at least
PAUSE = 1.0  # [s], that make a gap; robots that scan each metre or so pause to turn
FASTER = 3.0  # than nine of ten steps, and at least
JUMP = 0.5  # [m], that make a jump
SPUN = math.radians(120)  # between two scans: no match of scans is to be had then


def oddities(odometry: Trajectory, scans: Sequence[int] | None = None) -> list[str]:
    """Return what a user should know about a log before trusting SLAM on it.

    Stamps that run backwards, gaps, and odometry that jumps; SLAM itself needs no stamps.

    Parameters
    ----------
    odometry : Trajectory
        The pose of each scan by odometry, in the order of the log.
    scans : (N,) sequence of int, optional
        Their numbers in the log; from 0 on if left out.

    Returns
    -------
    list of str
        A line for each kind of oddity, which names the worst case and how many there are.

    Examples
    --------
    >>> poses = [(0.1 * i, 0.0, 0.0) for i in range(5)]
    >>> oddities(Trajectory(stamps=[0.0, 0.1, 0.2, 0.1, 0.2], poses=poses))
    ['stamps run backwards from scan 2 to 3, by 0.1 s; SLAM goes by the order of the scans']
    """
    if not len(odometry):
        return ["there is no scan"]
    if len(odometry) == 1:
        return ["there is only one scan: nothing is seen twice, so nothing becomes a landmark"]
    steps = _Steps(odometry, range(len(odometry)) if scans is None else scans)
    return [*steps.backwards(), *steps.gaps(), *steps.jumps()]


def together(notices: Iterable[tuple[int, str]]) -> list[str]:
    """Return notices, each with its scan, those that scan after scan repeats as one.

    Examples
    --------
    >>> together([(3, "lost"), (4, "lost"), (9, "lost")])
    ['scans 3 to 4: lost', 'scan 9: lost']
    """
    counted = ((i - order, i, text) for order, (i, text) in enumerate(notices))
    told = []
    for (_, text), same in groupby(counted, key=lambda each: (each[0], each[2])):
        scans = [scan for _, scan, _ in same]
        where = f"scan {scans[0]}" if len(scans) == 1 else f"scans {scans[0]} to {scans[-1]}"
        told.append(f"{where}: {text}")
    return told


class _Steps:
    """From each scan to the next: the time, the way [m] and the turn [rad]."""

    def __init__(self, odometry: Trajectory, scans: Sequence[int]) -> None:
        self._scans = scans
        self._times = np.diff(odometry.stamps)
        change = np.diff(odometry.poses, axis=0)
        self._ways = np.hypot(change[:, 0], change[:, 1])
        self._turns = abs(np.remainder(change[:, 2] + math.pi, math.tau) - math.pi)
        ahead = self._times[self._times > 0]
        self._period = float(np.median(ahead)) if ahead.size else math.nan
        self._is_gap: BoolArray = self._times > max(PERIODS * self._period, PAUSE)

    def backwards(self) -> Iterator[str]:
        """Tell of stamps that are smaller than those before."""
        times = np.flatnonzero(self._times < 0)
        if times.size:
            worst = int(times[np.argmin(self._times[times])])
            yield (
                f"stamps run backwards {self._between(worst)}, by {-self._times[worst]:.3g} s"
                f"{_others(times.size, 'time')}; SLAM goes by the order of the scans"
            )

    def gaps(self) -> Iterator[str]:
        """Tell of pauses that are long beside the usual time between scans."""
        gaps = np.flatnonzero(self._is_gap)
        if gaps.size:
            worst = int(gaps[np.argmax(self._times[gaps])])
            yield (
                f"a gap of {self._times[worst]:.3g} s {self._between(worst)}, in which odometry "
                f"moved {self._moved(worst)}{_others(gaps.size, 'gap')}; "
                f"{self._period:.2g} s is usual (the median)"
            )

    def jumps(self) -> Iterator[str]:
        """Tell of odometry that moves as the robot cannot, such as one that is reset."""
        far = (self._ways > JUMP) & (self._ways > FASTER * _usual(self._ways)) & ~self._is_gap
        speeds = self._ways[self._times > 0] / self._times[self._times > 0]
        if speeds.size:  # in a gap, the way may be long
            far |= self._is_gap & (
                self._ways > np.maximum(self._times * FASTER * _usual(speeds), JUMP)
            )
        jumps = np.flatnonzero(far | (self._turns > SPUN) & ~self._is_gap)
        if jumps.size:
            worst = int(jumps[np.argmax(self._ways[jumps])])
            yield (
                f"odometry jumps {self._between(worst)}: it moved {self._moved(worst)}"
                f"{_others(jumps.size, 'jump')}; was it reset? SLAM takes it for a motion"
            )

    def _between(self, step: int) -> str:
        return f"from scan {self._scans[step]} to {self._scans[step + 1]}"

    def _moved(self, step: int) -> str:
        return f"{self._ways[step]:.3g} m and turned {math.degrees(self._turns[step]):.0f} deg"


def _usual(values: FloatArray) -> float:
    """Return what nine of ten values do not exceed."""
    return float(np.quantile(values, 0.9, method="lower"))


def _others(count: int, what: str) -> str:
    return f" (the worst of {count} {what}s)" if count > 1 else ""
