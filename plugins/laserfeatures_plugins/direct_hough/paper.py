"""The paper's literal algorithm: bins as lines, a fixed number of peaks, a fixed window."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import IntArray
from laserfeatures.data import LaserScan, Lines, LineSegments
from laserfeatures.engine import kernel
from laserfeatures.engine.segments import check_size, cut_segments
from laserfeatures.parameters import is_whole, settle
from laserfeatures_plugins.direct_hough.accumulator import Accumulator, accumulate, check_steps


@dataclass(frozen=True, kw_only=True)
class PaperHough:
    """Find lines as the paper does, with its parameters.

    Parameters
    ----------
    theta_step : float
        Angular resolution of the accumulator [rad] (the paper's delta theta).
    distance_step : float
        Distance resolution of the accumulator [m] (delta d).
    neighborhood : tuple of int
        Odd numbers of cells in d and theta that a peak suppresses around itself
        ([delta V_d, delta V_theta]).
    min_votes : int
        Least number of votes of a peak (MinTh).
    relative_threshold : float
        Least share of the largest vote count that a peak must have (0.15 in the paper's Eq. 2).
    max_peaks : int
        Number of lines at the most (MaxN).
    max_distance : float
        Points nearer than this to a line belong to it [m] (MinDist).

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    Notes
    -----
    The covariance of a line is that of a uniform error within its cell. The shared stages take the
    paper's values too: MaxError = 0.02 m, and every crossing of lines that are not parallel.

    References
    ----------
    The paper, sections II and III.C and Table I.
    """

    stages: ClassVar[Mapping[str, Mapping[str, float]]] = {
        "segment_filter": {"max_error": 0.02},
        "intersections": {"min_angle": 0.0, "max_sigma": math.inf, "max_distance": 20.0},
    }

    theta_step: float = math.radians(1.0)
    distance_step: float = 0.02
    neighborhood: tuple[int, int] = (21, 11)
    min_votes: int = 4
    relative_threshold: float = 0.15
    max_peaks: int = 8
    max_distance: float = 0.04

    def __post_init__(self) -> None:
        """Check the parameters."""
        settle(self)
        check_steps(self.theta_step, self.distance_step)
        window = self.neighborhood
        cells = tuple(window) if isinstance(window, Iterable) else ()
        if len(cells) != 2 or any(not is_whole(v) or v < 1 or v % 2 != 1 for v in cells):
            raise ValueError(f"neighborhood must be two odd numbers of cells >= 1, got {window!r}")
        object.__setattr__(self, "neighborhood", (int(cells[0]), int(cells[1])))
        for name in ("min_votes", "max_peaks"):
            if not getattr(self, name) >= 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)!r}")
        if not 0 <= self.relative_threshold <= 1:
            raise ValueError(
                f"relative_threshold must be in [0, 1], got {self.relative_threshold!r}"
            )
        if not self.max_distance > 0:
            raise ValueError(f"max_distance must be > 0 m, got {self.max_distance!r}")

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the lines of `scan` and the runs of beams along them."""
        accumulator = self.accumulator(scan)
        votes = accumulator.votes
        # Eq. 2; Python's round would send 10.5 to 10, the paper's to 11.
        share = math.floor(self.relative_threshold * int(votes.max(initial=0)) + 0.5)
        rows, columns = _find_peaks(
            votes, max(self.min_votes, share), self.max_peaks, *self.neighborhood
        )
        theta = accumulator.theta[rows]
        d = accumulator.d[columns]
        x, y = np.ascontiguousarray(scan.points.T)
        off = np.abs(np.outer(np.cos(theta), x) + np.outer(np.sin(theta), y) - d[:, None])
        members = off < self.max_distance
        covariance = np.zeros((theta.size, 2, 2))
        covariance[:, 0, 0] = self.theta_step**2 / 12
        covariance[:, 1, 1] = self.distance_step**2 / 12
        on_line, member = np.nonzero(members)
        line, endpoints, support, rms, points = cut_segments(
            x, y, scan.beams, scan.beams, len(scan), theta, d, on_line, member, 0, 0.0, math.inf
        )
        check_size(line, points)
        lines = Lines(theta=theta, d=d, support=members.sum(axis=1), covariance=covariance)
        return LineSegments(
            lines=lines, line=line, endpoints=endpoints, support=support, rms=rms, points=points
        )

    def accumulator(self, scan: LaserScan) -> Accumulator:
        """Return the d-theta plane of `scan`."""
        return accumulate(scan, self.theta_step, self.distance_step)


@kernel
def _find_peaks(
    votes: NDArray[np.int32], threshold: int, max_peaks: int, window_d: int, window_theta: int
) -> tuple[IntArray, IntArray]:
    """Return rows and columns of the peaks, highest first; each suppresses its window.

    Across theta = 0 and pi the window goes on at -d: it is the same line.
    """
    thetas, distances = votes.shape
    votes = votes.copy()
    max_peaks = min(max_peaks, votes.size)
    rows = np.empty(max_peaks, np.int64)
    columns = np.empty(max_peaks, np.int64)
    beside = min(window_theta // 2, thetas)  # by then it has gone over all rows, both ways round
    for peak in range(max_peaks):
        most = threshold - 1
        row = -1
        column = -1
        for t in range(thetas):
            for k in range(distances):
                if votes[t, k] > most:
                    most = votes[t, k]
                    row = t
                    column = k
        if row < 0:
            return rows[:peak], columns[:peak]
        rows[peak] = row
        columns[peak] = column
        for dt in range(-beside, beside + 1):
            turns = (row + dt) // thetas
            middle = column if turns % 2 == 0 else distances - 1 - column
            low = max(0, middle - window_d // 2)
            votes[(row + dt) % thetas, low : middle + window_d // 2 + 1] = 0
    return rows, columns
