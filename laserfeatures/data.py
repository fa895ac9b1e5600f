"""The data that flow through the package: scans in, lines, segments and corners out.

All are frozen dataclasses of read-only C-contiguous arrays, checked when they are made: a read-only
array is taken as it is, any other is copied. Metres, radians, seconds; the sensor's frame has x forward, y left, angles counter-clockwise.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self, cast

import numpy as np
from numpy.typing import ArrayLike

from laserfeatures._arrays import BoolArray, FloatArray, IntArray, Record, read_only

FULL_TURN = 2 * math.pi * (1 + 1e-6)  # a full turn may have a beam at both -pi and pi

# The angles seen last and their directions: a sensor's beams do not change from scan to scan.
_last_directions: list[tuple[FloatArray, FloatArray]] = [(np.empty(0), np.empty((0, 2)))]


@dataclass(frozen=True)
class Pose2D:
    """A position [m] and heading [rad] in the plane."""

    x: float
    y: float
    theta: float

    def transform(self, points: ArrayLike) -> FloatArray:
        """Return points (N, 2) [m] of this pose's frame in the frame that the pose is given in."""
        xy = np.asarray(points, dtype=np.float64).reshape(-1, 2)
        c, s = math.cos(self.theta), math.sin(self.theta)
        return xy @ np.array([[c, s], [-s, c]]) + (self.x, self.y)


@dataclass(frozen=True, eq=False, kw_only=True)
class LaserScan(Record):
    """One sweep of a 2D laser rangefinder.

    Parameters
    ----------
    angles : (N,) array
        Direction of each beam [rad], strictly increasing, at most one turn.
    ranges : (N,) array
        Measured range of each beam [m]. 0, inf, nan and anything outside the limits is no return.
    range_min, range_max : float
        Limits of the sensor [m]: a return r has ``range_min <= r < range_max``.
    stamp : float
        Time of the scan [s]; nan where the source has none.
    pose : Pose2D or None
        Pose of the sensor as the source gives it; the source says whether that is raw odometry.

    Raises
    ------
    ValueError
        If shapes differ, angles do not increase, or a limit makes no sense.

    Examples
    --------
    >>> scan = LaserScan(angles=[0.0, 0.1], ranges=[2.0, float("inf")])
    >>> scan.points.tolist()
    [[2.0, 0.0]]
    """

    angles: FloatArray
    ranges: FloatArray
    range_min: float = 0.0
    range_max: float = math.inf
    stamp: float = math.nan
    pose: Pose2D | None = None

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        angles = read_only(self.angles, "angles", (None,))
        ranges = read_only(self.ranges, "ranges", angles.shape)
        self._set(angles=angles, ranges=ranges)
        if angles.size:
            increasing = angles[1:] > angles[:-1]
            if not increasing.all():
                i = int(np.argmin(increasing))
                raise ValueError(
                    f"angles must be strictly increasing, got {angles[i]:.6g} rad at beam {i} and "
                    f"{angles[i + 1]:.6g} rad at beam {i + 1}"
                )
            if not angles[-1] - angles[0] <= FULL_TURN:
                raise ValueError(
                    "angles must be finite and span at most one turn, "
                    f"got {angles[0]:.6g} .. {angles[-1]:.6g} rad"
                )
        if not (0 <= self.range_min < self.range_max):
            raise ValueError(
                "limits must be 0 <= range_min < range_max, "
                f"got {self.range_min!r} and {self.range_max!r} m"
            )

    @classmethod
    def uniform(
        cls, ranges: ArrayLike, angle_min: float, angle_increment: float, **rest: Any
    ) -> Self:
        """Make a scan of evenly spaced beams.

        Parameters
        ----------
        ranges : (N,) array
            Measured ranges [m], in beam order.
        angle_min : float
            Direction of the first beam [rad].
        angle_increment : float
            Step from beam to beam [rad]. Negative for a sensor that turns clockwise or is mounted
            upside down: angles and ranges are then reversed.
        **rest
            The other fields of `LaserScan`.

        Raises
        ------
        ValueError
            As `LaserScan`.
        """
        values = np.asarray(ranges, dtype=np.float64)
        angles = angle_min + angle_increment * np.arange(values.size)
        if angle_increment < 0:
            angles, values = angles[::-1], values[::-1]
        return cls(angles=cast("FloatArray", angles), ranges=cast("FloatArray", values), **rest)

    @cached_property
    def valid(self) -> BoolArray:
        """Which beams have a return, (N,) bool."""
        r = self.ranges
        valid = (r >= self.range_min) & (r < self.range_max)
        if self.range_min == 0:
            valid &= r > 0
        if self.range_max == math.inf:
            valid &= np.isfinite(r)
        valid.flags.writeable = False
        return valid

    @cached_property
    def beams(self) -> IntArray:
        """Index of the beam of each point, (P,) int."""
        beams = np.flatnonzero(self.valid)
        beams.flags.writeable = False
        return beams

    @cached_property
    def points(self) -> FloatArray:
        """Returns as points (P, 2) [m] in beam order."""
        points = self.ranges[self.beams, None] * self.directions[self.beams]
        points.flags.writeable = False
        return points

    @property
    def directions(self) -> FloatArray:
        """Unit vector along each beam, (N, 2); computed once for scans that share their angles."""
        angles, directions = _last_directions[0]
        if angles is not self.angles:
            directions = np.stack([np.cos(self.angles), np.sin(self.angles)], axis=1)
            directions.flags.writeable = False
            _last_directions[0] = (self.angles, directions)
        return directions

    def __len__(self) -> int:
        """Return the number of beams."""
        return self.angles.size


@dataclass(frozen=True, eq=False, kw_only=True)
class Lines(Record):
    """Infinite lines d = x cos(theta) + y sin(theta) (the paper's Eq. 1).

    Parameters
    ----------
    theta : (L,) array
        Direction of each line's normal [rad], in [0, pi).
    d : (L,) array
        Signed distance from the sensor [m].
    support : (L,) array
        Number of the scan's points that lie on the line.
    covariance : (L, 2, 2) array
        Covariance of (theta, d) [rad^2, rad m, m^2].
    """

    theta: FloatArray
    d: FloatArray
    support: FloatArray
    covariance: FloatArray

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        theta = read_only(self.theta, "theta", (None,))
        n = theta.shape
        self._set(
            theta=theta,
            d=read_only(self.d, "d", n),
            support=read_only(self.support, "support", n),
            covariance=read_only(self.covariance, "covariance", (*n, 2, 2)),
        )
        if theta.size and not (theta.min() >= 0 and theta.max() < math.pi):
            raise ValueError(f"theta must lie in [0, pi) rad, got {theta.tolist()}")

    def __len__(self) -> int:
        """Return the number of lines."""
        return self.theta.size


@dataclass(frozen=True, eq=False, kw_only=True)
class LineSegments(Record):
    """Bounded pieces of lines, each cut where the scan's points along the line end.

    Parameters
    ----------
    lines : Lines
        The lines that the segments lie on; a line may carry several.
    line : (S,) int array
        Index of each segment's line.
    endpoints : (S, 2, 2) array
        First and last point of each segment in beam order [m], on its line.
    support : (S,) array
        Number of points on each segment.
    rms : (S,) array
        Root mean square distance of those points from the line [m].
    points : (S, N) bool array
        Which of the scan's N beams each segment holds.
    """

    lines: Lines
    line: IntArray
    endpoints: FloatArray
    support: FloatArray
    rms: FloatArray
    points: BoolArray

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        line = read_only(self.line, "line", (None,), np.int64)
        n = line.shape
        self._set(
            line=line,
            endpoints=read_only(self.endpoints, "endpoints", (*n, 2, 2)),
            support=read_only(self.support, "support", n),
            rms=read_only(self.rms, "rms", n),
            points=read_only(self.points, "points", (*n, None), np.bool_),
        )
        if line.size and not (line.min() >= 0 and line.max() < len(self.lines)):
            raise ValueError(
                f"line must index one of the {len(self.lines)} lines, got {line.tolist()}"
            )

    def __len__(self) -> int:
        """Return the number of segments."""
        return self.line.size

    @property
    def lengths(self) -> FloatArray:
        """Length of each segment [m], (S,)."""
        step = self.endpoints[:, 1] - self.endpoints[:, 0]
        return cast("FloatArray", np.hypot(step[:, 0], step[:, 1]))


@dataclass(frozen=True, eq=False, kw_only=True)
class PointFeatures(Record):
    """Corners: the intersections of lines.

    Parameters
    ----------
    positions : (F, 2) array
        Where the corners are [m].
    covariance : (F, 2, 2) array
        Covariance of each position [m^2].
    lines : (F, 2) int array
        The two lines that cross there.
    angles : (F,) array
        Angle between the two lines [rad], in (0, pi/2].
    real : (F,) bool array
        True for a real corner (both lines have a segment that reaches it), False for a virtual one.
    """

    positions: FloatArray
    covariance: FloatArray
    lines: IntArray
    angles: FloatArray
    real: BoolArray

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        positions = read_only(self.positions, "positions", (None, 2))
        n = positions.shape[0]
        self._set(
            positions=positions,
            covariance=read_only(self.covariance, "covariance", (n, 2, 2)),
            lines=read_only(self.lines, "lines", (n, 2), np.int64),
            angles=read_only(self.angles, "angles", (n,)),
            real=read_only(self.real, "real", (n,), np.bool_),
        )

    def __len__(self) -> int:
        """Return the number of corners."""
        return self.positions.shape[0]


@dataclass(frozen=True, eq=False, kw_only=True)
class Features:
    """What an extractor found in one scan."""

    scan: LaserScan
    segments: LineSegments
    corners: PointFeatures

    @property
    def lines(self) -> Lines:
        """The lines that carry the segments."""
        return self.segments.lines
