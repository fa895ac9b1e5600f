"""The stage that makes corners: the intersections of lines (the paper's section II.D)."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.data import LineSegments, PointFeatures
from laserfeatures.geometry import helper, kernel


@dataclass(frozen=True, kw_only=True)
class Intersections:
    """Cross all pairs of lines that are not parallel.

    Parameters
    ----------
    max_distance : float
        Corners farther from the sensor are dropped [m].
    min_angle : float
        Lines that cross at less than this angle count as parallel [rad].
    max_sigma : float
        Corners whose standard deviation along the worst direction is larger are withheld [m]: far
        from the data, a short wall says nothing about where its line crosses another.
    reach : float
        A corner is real where both lines have a segment that comes this near to it [m], plus twice
        the way from one beam to the next along the wall there; virtual otherwise.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    The paper, section II.D, where `max_distance` is 20 m and the other limits do not exist.
    """

    max_distance: float = 20.0
    min_angle: float = math.radians(15.0)
    max_sigma: float = 0.3
    reach: float = 0.05

    def __post_init__(self) -> None:
        """Check the parameters."""
        for name in ("max_distance", "max_sigma"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} must be > 0 m, got {getattr(self, name)!r}")
        if not 0 <= self.min_angle < math.pi / 2:
            raise ValueError(f"min_angle must be in [0, pi/2) rad, got {self.min_angle!r}")
        if not self.reach >= 0:
            raise ValueError(f"reach must be >= 0 m, got {self.reach!r}")

    def __call__(self, segments: LineSegments) -> PointFeatures:
        """Return the corners of the lines that carry `segments`."""
        lines = segments.lines
        numbers, pairs, real = _cross(
            lines.theta,
            lines.d,
            lines.covariance,
            segments.line,
            segments.endpoints,
            segments.support,
            self.max_distance,
            max(math.sin(self.min_angle), 1e-9),
            self.max_sigma,
            self.reach,
        )
        lock(numbers, pairs, real)
        count = real.size
        most = numbers.size // 7
        return PointFeatures.trusted(
            positions=numbers[: 2 * count].reshape(count, 2),
            covariance=numbers[2 * most : 2 * most + 4 * count].reshape(count, 2, 2),
            lines=pairs,
            angles=numbers[6 * most : 6 * most + count],
            real=real,
        )


@kernel
def _cross(
    theta: FloatArray,
    d: FloatArray,
    covariance: FloatArray,
    line: IntArray,
    endpoints: FloatArray,
    support: FloatArray,
    max_distance: float,
    sin_min: float,
    max_sigma: float,
    reach: float,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Return the corners' numbers, pairs of lines, and reality.

    The numbers are positions, covariances and angles in one array, with room for a corner of each
    pair of lines: to hand an array to Python takes longer than to view a part of it there.
    """
    lines = theta.size
    most = lines * (lines - 1) // 2
    numbers = np.empty(7 * most)
    spread = numbers[2 * most :]
    angles = numbers[6 * most :]
    pairs = np.empty((most, 2), np.int64)
    real = np.empty(most, np.bool_)
    cos = np.empty(lines)
    sin = np.empty(lines)
    for a in range(lines):
        cos[a] = math.cos(theta[a])
        sin[a] = math.sin(theta[a])
    count = 0
    for a in range(lines):
        for b in range(a + 1, lines):
            det = cos[a] * sin[b] - sin[a] * cos[b]
            if abs(det) < sin_min:
                continue
            x = (d[a] * sin[b] - d[b] * sin[a]) / det
            y = (d[b] * cos[a] - d[a] * cos[b]) / det
            if x * x + y * y > max_distance * max_distance:
                continue
            # An error of a line shifts it at (x, y) by along * dtheta - dd; solve for the point.
            va = _variance_at(y * cos[a] - x * sin[a], covariance[a]) / (det * det)
            vb = _variance_at(y * cos[b] - x * sin[b], covariance[b]) / (det * det)
            xx = va * sin[b] * sin[b] + vb * sin[a] * sin[a]
            yy = va * cos[b] * cos[b] + vb * cos[a] * cos[a]
            xy = -va * sin[b] * cos[b] - vb * sin[a] * cos[a]
            if 0.5 * (xx + yy + math.hypot(xx - yy, 2.0 * xy)) > max_sigma * max_sigma:
                continue
            numbers[2 * count] = x
            numbers[2 * count + 1] = y
            spread[4 * count] = xx
            spread[4 * count + 1] = spread[4 * count + 2] = xy
            spread[4 * count + 3] = yy
            pairs[count, 0] = a
            pairs[count, 1] = b
            angles[count] = math.asin(min(abs(det), 1.0))
            real[count] = _reaches(x, y, a, d[a], line, endpoints, support, reach) and _reaches(
                x, y, b, d[b], line, endpoints, support, reach
            )
            count += 1
    return numbers, pairs[:count], real[:count]


@helper
def _variance_at(along: float, covariance: FloatArray) -> float:
    """Return the variance of a line's offset at the coordinate `along` it."""
    cross = covariance[0, 1]
    return float(along * along * covariance[0, 0] - 2.0 * along * cross + covariance[1, 1])


@helper
def _reaches(
    x: float,
    y: float,
    k: int,
    d: float,
    line: IntArray,
    endpoints: FloatArray,
    support: FloatArray,
    reach: float,
) -> bool:
    """Tell whether a segment of line k comes near to a point on the line."""
    for j in range(line.size):
        if line[j] != k:
            continue
        ax = endpoints[j, 0, 0]
        ay = endpoints[j, 0, 1]
        bx = endpoints[j, 1, 0]
        by = endpoints[j, 1, 1]
        # Is the point between the ends? Then the way to both points in opposite directions.
        if (x - ax) * (x - bx) + (y - ay) * (y - by) <= 0.0:
            return True
        turn = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by)) / max(support[j] - 1.0, 1.0)
        for end in range(2):
            ex = endpoints[j, end, 0]
            ey = endpoints[j, end, 1]
            step = (ex * ex + ey * ey) * turn / max(abs(d), 1e-6)
            if math.hypot(x - ex, y - ey) <= reach + 2.0 * min(step, 0.25):
                return True
    return False
