"""Scans and poses: what a source yields."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, Record, read_only, unmasked
from laserfeatures.parameters import number

GAP = 0.5  # [rad]; a wider one is no step of a ring with uneven steps
FULL_TURN = 2 * math.pi * (1 + 1e-6)  # a full turn may have a beam at both -pi and pi


class _Beams:
    """What follows from the angles alone: the same for all scans of a sensor."""

    def __init__(self, angles: FloatArray) -> None:
        self.angles = angles

    def check(self) -> None:
        """Raise a `ValueError` unless the angles increase over one turn at most."""
        angles = self.angles
        if not angles.size:
            return
        increasing = angles[1:] > angles[:-1]
        if not increasing.all():
            i = int(np.argmin(increasing))
            turn = angles[i] - angles[i + 1]
            raise ValueError(
                f"angles must be strictly increasing, got {angles[i]:.6g} rad at beam {i} and "
                f"{angles[i + 1]:.6g} rad at beam {i + 1}"
                + (f"; is it a full circle? Begin it at beam {i + 1}" * bool(turn > math.pi))
            )
        if not angles[-1] - angles[0] <= FULL_TURN:
            raise ValueError(
                "angles must be finite and span at most one turn, "
                f"got {angles[0]:.6g} .. {angles[-1]:.6g} rad"
            )

    @cached_property
    def directions(self) -> FloatArray:
        """Unit vector along each beam, (N, 2)."""
        directions = np.stack([np.cos(self.angles), np.sin(self.angles)], axis=1)
        directions.flags.writeable = False
        return directions

    @cached_property
    def ring(self) -> int:
        """How the beams go round, as `LaserScan.ring` tells."""
        steps = self.angles.size - 1
        if steps < 2:
            return 0
        span = float(self.angles[-1] - self.angles[0])
        left, step = 2 * math.pi - span, span / steps
        if left <= 1.5 * step:
            return 1 if left > 0.1 * step else 2
        if left > GAP:
            return 0  # without a look at all steps, which takes longer
        return int(left <= 1.5 * float(np.diff(self.angles).max()))


_last_beams = [_Beams(np.empty(0))]  # of the angles seen last


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
        turned: FloatArray = xy @ np.array([[c, s], [-s, c]])
        turned += (self.x, self.y)
        return turned


@dataclass(frozen=True, eq=False, kw_only=True)
class LaserScan(Record):
    """One sweep of a 2D laser rangefinder.

    Parameters
    ----------
    angles : (N,) array
        Direction of each beam [rad], strictly increasing, at most one turn.
    ranges : (N,) array
        Measured range of each beam [m]. 0, inf, nan, anything outside the limits and
        what a mask of NumPy covers is no return.
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

    if TYPE_CHECKING:  # what it takes is wider than what it holds

        def __init__(
            self,
            *,
            angles: ArrayLike,
            ranges: ArrayLike,
            range_min: float = 0.0,
            range_max: float = math.inf,
            stamp: float = math.nan,
            pose: Pose2D | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        beams = _last_beams[0]
        if self.angles is not beams.angles:
            beams = _Beams(read_only(self.angles, "angles", (None,)))
            beams.check()
            _last_beams[0] = beams
        ranges = read_only(self.ranges, "ranges", beams.angles.shape)
        self._set(angles=beams.angles, ranges=ranges)
        for name in ("range_min", "range_max", "stamp"):
            value = getattr(self, name)
            if type(value) is not float:  # kernels are compiled for no other
                self._set(**{name: number(name, value, self)})
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
        values = np.asarray(unmasked(ranges), dtype=np.float64)
        angles = angle_min + angle_increment * np.arange(values.size, dtype=np.float64)
        if angle_increment < 0:
            angles, values = angles[::-1], values[::-1]
        return cls(angles=angles, ranges=values, **rest)

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

    @property
    def closed(self) -> bool:
        """Whether the beams go round: the next one after the last would be the first.

        It would within half a step, or the last beam has the direction of the first again. Where
        steps differ, as of scans merged from two sensors, the widest one counts.
        """
        return self.ring > 0

    @property
    def ring(self) -> int:
        """How the beams go round: 0, they do not; 1, once; 2, the last repeats the first."""
        return self._beams.ring

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
        return self._beams.directions

    @property
    def _beams(self) -> _Beams:
        beams = _last_beams[0]
        if beams.angles is not self.angles:
            beams = _last_beams[0] = _Beams(self.angles)
        return beams

    def __repr__(self) -> str:
        """Return what it is in one line: its arrays are too long to be read."""
        text = f"{len(self)} beam{'s' * (len(self) != 1)}"
        if len(self):
            first, last = math.degrees(self.angles[0]), math.degrees(self.angles[-1])
            text += f" from {first:.4g} to {last:.4g} deg"
        text += f", {self.beams.size} return{'s' * (self.beams.size != 1)}"
        if self.beams.size:
            seen = self.ranges[self.beams]
            text += f" from {seen.min():.4g} to {seen.max():.4g} m"
        if math.isfinite(self.stamp):
            text += f", at {self.stamp:.15g} s"
        if self.pose:
            pose, turned = self.pose, math.degrees(self.pose.theta)
            text += f", pose {pose.x:.4g} m, {pose.y:.4g} m, {turned:.4g} deg"
        return f"LaserScan({text})"

    def __len__(self) -> int:
        """Return the number of beams."""
        return self.angles.size
