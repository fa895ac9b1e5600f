"""Step 10: make corners, the intersections of lines (the paper's section II.D)."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.compiled import helper, kernel, leaf
from laserfeatures.data import LineSegments, PointFeatures
from laserfeatures.parameters import settle

SIGMAS = 2.0  # of the corner along the wall: nearly all of its errors
PROLONGED = 2.0  # times the range limit: walls go on beyond what is seen of them, but not for ever
MOST_LINES = 6000  # corners of their pairs would take 1.5 GB
SHARE = 0.5  # of a segment's length: beside a grazing wall, the next beam meets it anywhere


@dataclass(frozen=True, kw_only=True)
class Intersections:
    """Cross all pairs of lines that are not parallel.

    Parameters
    ----------
    max_distance : float, optional
        Corners farther from the sensor are dropped [m]; None: those beyond twice the range limit of
        the scan.
    min_angle : float
        Lines that cross at less than this angle count as parallel [rad].
    max_sigma : float
        Corners whose standard deviation along the worst direction is larger are withheld [m]: far
        from the data, a short wall says nothing about where its line crosses another.
    reach : float
        A corner is real where both lines have a segment that comes this near to it [m], virtual
        otherwise. To that is added how far the wall may go on unseen: to where the next beam would
        meet it, and two standard deviations of the corner along it, but at most half of the
        segment's length.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    The paper, section II.D, where `max_distance` is 20 m and the other limits do not exist.
    """

    max_distance: float | None = None
    min_angle: float = math.radians(15.0)
    max_sigma: float = 0.25
    reach: float = 0.05

    def __post_init__(self) -> None:
        """Check the parameters."""
        settle(self)
        for name in ("max_distance", "max_sigma"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"{name} must be > 0 m, got {value!r}")
        if not 0 <= self.min_angle < math.pi / 2:
            raise ValueError(f"min_angle must be in [0, pi/2) rad, got {self.min_angle!r}")
        if not self.reach >= 0:
            raise ValueError(f"reach must be >= 0 m, got {self.reach!r}")

    def __call__(self, segments: LineSegments, *, limit: float = math.inf) -> PointFeatures:
        """Return the corners of the lines that carry `segments`.

        Parameters
        ----------
        segments : LineSegments
            The segments of one scan.
        limit : float
            Range limit of the scan [m], in place of a `max_distance` that was left out.

        Raises
        ------
        ValueError
            If the limit is not positive, or there are more lines than can be crossed in pairs.
        """
        if not limit > 0:
            raise ValueError(f"limit must be > 0 m, got {limit!r}")
        count = len(segments.lines)
        if count > MOST_LINES:
            raise ValueError(
                f"expected at most {MOST_LINES} lines to cross in pairs, got {count}: "
                "are the ranges noise? A SegmentFilter with a min_evidence leaves fewer"
            )
        numbers, pairs, real = _cross(
            segments.pack(),
            segments.line,
            float(PROLONGED * limit if self.max_distance is None else self.max_distance),
            max(math.sin(self.min_angle), 1e-9),
            self.max_sigma,
            self.reach,
        )
        lock(numbers, pairs, real)
        return PointFeatures.packed(numbers, lines=pairs, real=real)


@kernel
def _cross(
    packed: FloatArray,
    line: IntArray,
    max_distance: float,
    sin_min: float,
    max_sigma: float,
    reach: float,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Return the corners' numbers, pairs of lines, and reality; `packed` is what `pack` returns.

    The numbers are positions, covariances, angles and evidence in one array, with room for a corner
    of each pair of lines: to hand an array to Python takes longer than to view a part of it there.
    """
    count = line.size
    lines = (packed.size - 6 * count) // 8
    theta = packed[:lines]
    d = packed[lines : 2 * lines]
    evidence = packed[3 * lines : 4 * lines]
    covariance = packed[4 * lines : 8 * lines].reshape(lines, 2, 2)
    support = packed[8 * lines : 8 * lines + count]
    endpoints = packed[8 * lines + 2 * count :].reshape(count, 2, 2)
    most = lines * (lines - 1) // 2
    numbers = np.empty(8 * most)
    spread = numbers[2 * most :]
    angles = numbers[6 * most :]
    pairs = np.empty((most, 2), np.int64)
    real = np.empty(most, np.bool_)
    cos = np.cos(theta)
    sin = np.sin(theta)
    extent = _extent(endpoints, max_distance)
    begins, order = _by_line(line, lines)
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
            variance = 0.5 * (xx + yy + math.hypot(xx - yy, 2.0 * xy))  # the largest
            if variance > max_sigma * max_sigma:
                continue
            numbers[2 * count] = x
            numbers[2 * count + 1] = y
            spread[4 * count] = xx
            spread[4 * count + 1] = spread[4 * count + 2] = xy
            spread[4 * count + 3] = yy
            pairs[count, 0] = a
            pairs[count, 1] = b
            angles[count] = math.asin(min(abs(det), 1.0))
            gap = _gap(x, y, a, b, begins, order, endpoints)
            numbers[7 * most + count] = _evidence(extent, variance, gap, evidence[a], evidence[b])
            turned = (cos[a] * cos[b] + sin[a] * sin[b]) ** 2
            along_a = math.sqrt(va * turned + vb)
            along_b = math.sqrt(vb * turned + va)
            real[count] = _reaches(
                x, y, a, abs(d[a]), along_a, begins, order, endpoints, support, reach
            ) and _reaches(x, y, b, abs(d[b]), along_b, begins, order, endpoints, support, reach)
            count += 1
    return numbers, pairs[:count], real[:count]


@leaf
def _extent(endpoints: FloatArray, max_distance: float) -> float:
    """Return how far from the sensor a corner may be: if at all, as far as anything is seen."""
    if max_distance < math.inf:
        return max_distance
    square = 0.0
    for j in range(endpoints.shape[0]):
        for end in range(2):
            square = max(square, endpoints[j, end, 0] ** 2 + endpoints[j, end, 1] ** 2)
    return math.sqrt(square)


@helper
def _by_line(line: IntArray, lines: int) -> tuple[IntArray, IntArray]:
    """Sort the segments by lines: those of line k are ``order[begins[k] : begins[k + 1]]``."""
    begins = np.zeros(lines + 2, np.int64)
    for j in range(line.size):
        begins[line[j] + 2] += 1
    for k in range(2, lines + 2):
        begins[k] += begins[k - 1]
    order = np.empty(line.size, np.int64)
    for j in range(line.size):
        order[begins[line[j] + 1]] = j
        begins[line[j] + 1] += 1
    return begins, order


@leaf
def _gap(
    x: float, y: float, a: int, b: int, begins: IntArray, order: IntArray, endpoints: FloatArray
) -> float:
    """Return how far a corner of lines a and b is from the nearer of their segments."""
    least = math.inf
    for k in (a, b):
        for j in order[begins[k] : begins[k + 1]]:
            ax = x - endpoints[j, 0, 0]
            ay = y - endpoints[j, 0, 1]
            bx = x - endpoints[j, 1, 0]
            by = y - endpoints[j, 1, 1]
            if ax * bx + ay * by <= 0.0:
                return 0.0
            least = min(least, ax * ax + ay * ay, bx * bx + by * by)
    return math.sqrt(least)


@leaf
def _evidence(extent: float, variance: float, gap: float, one: float, other: float) -> float:
    """Return the evidence of a corner [nats].

    How much more likely it is at its place than anywhere within `extent`, where one that no wall
    reaches counts as uncertain as its `gap`; and the logarithms of its lines' evidence, half that
    of the stronger. Of what was tried this tells best, on real logs, which corners the next scan
    shows again (`benchmarks/repeatability.py --curves`).
    """
    weaker = min(one, other)
    if weaker == 0.0 or extent == 0.0:
        return 0.0
    if not variance > 0.0:
        return weaker
    sigma = math.sqrt(variance)
    odds = 0.5 * extent * extent / (sigma * (gap + sigma))
    odds *= weaker * math.sqrt(max(one, other))
    return math.log(odds) if odds > 1.0 else 0.0


@leaf
def _variance_at(along: float, covariance: FloatArray) -> float:
    """Return the variance of a line's offset at the coordinate `along` it."""
    cross = covariance[0, 1]
    return float(along * along * covariance[0, 0] - 2.0 * along * cross + covariance[1, 1])


@leaf
def _reaches(
    x: float,
    y: float,
    k: int,
    d: float,
    sigma: float,
    begins: IntArray,
    order: IntArray,
    endpoints: FloatArray,
    support: FloatArray,
    reach: float,
) -> bool:
    """Tell whether a segment of line k, `d` >= 0 away, comes near to a corner on the line.

    `sigma` is the corner's standard deviation along the line.
    """
    doubt = SIGMAS * sigma if sigma < math.inf else 0.0  # inf and nan tell nothing
    for j in order[begins[k] : begins[k + 1]]:
        ax = endpoints[j, 0, 0]
        ay = endpoints[j, 0, 1]
        bx = endpoints[j, 1, 0]
        by = endpoints[j, 1, 1]
        # Is the point between the ends? Then the way to both points in opposite directions.
        if (x - ax) * (x - bx) + (y - ay) * (y - by) <= 0.0:
            return True
        most = reach + SHARE * math.hypot(bx - ax, by - ay)
        for end in range(2):
            ex = endpoints[j, end, 0]
            ey = endpoints[j, end, 1]
            away = math.hypot(x - ex, y - ey)
            if away > most:  # nearly always, and what follows takes longer
                continue
            seen = abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))
            along = (ex * (x - ex) + ey * (y - ey)) / away
            beyond = _beyond(along, d, seen / max(support[j] - 1.0, 1.0))
            if away <= reach + doubt + beyond:
                return True
    return False


@leaf
def _beyond(along: float, d: float, turn: float) -> float:
    """Return how far beyond a point on a wall a beam meets it that is turned by `turn`.

    The wall is `d` away, the point lies `along` from its foot, to the side that the beam turns to.
    """
    bearing = math.atan2(along, d) + turn  # from the foot
    return d * math.tan(bearing) - along if bearing < 0.5 * math.pi else math.inf
