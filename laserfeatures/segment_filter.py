"""Step 9: remove segments which are no reliable surface (the paper's section II.C)."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.compiled import kernel, leaf
from laserfeatures.data import LineSegments
from laserfeatures.parameters import settle

ROUNDING = 1e-9  # of a sine that is made of others


@dataclass(frozen=True, kw_only=True)
class SegmentFilter:
    """Remove doubtful, small, bad and repeated segments, then the lines that have none left.

    Parameters
    ----------
    min_points : int
        Segments of fewer points go (the paper's MinPuntos).
    max_error : float
        Segments whose rms distance from their line is larger go [m] (MaxError).
    min_angle : float
        Of two segments whose lines cross at less than this angle [rad] and that are copies of one
        surface, the one with fewer points goes, or with as many, the one of larger error (MinAng).
    copy_distance : float
        Segments are copies where the smaller shares half of its points with the larger, or runs
        over it by half of its length at less than this distance [m]. The walls of a corridor are
        not copies.
    min_evidence : float
        Lines whose evidence is smaller go with all their segments [nats]. This is the one number
        that trades recall for precision: the larger, the fewer and the surer lines and corners.
        Detectors that tell no evidence give 0 to all their lines: above 0, none of those stays.

    Raises
    ------
    ValueError
        If a parameter is out of its range.

    References
    ----------
    The paper, section II.C, with the values of its section III.C; a larger `max_error`, for
    sensors that are noisier than the paper's.
    """

    min_points: int = 4
    max_error: float = 0.15
    min_angle: float = math.radians(15.0)
    copy_distance: float = 0.08
    min_evidence: float = 0.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        settle(self)
        if not self.min_points >= 1:
            raise ValueError(f"min_points must be >= 1, got {self.min_points!r}")
        if not self.max_error > 0:
            raise ValueError(f"max_error must be > 0 m, got {self.max_error!r}")
        if not 0 <= self.min_angle <= math.pi / 2:
            raise ValueError(f"min_angle must be in [0, pi/2] rad, got {self.min_angle!r}")
        if not self.copy_distance >= 0:
            raise ValueError(f"copy_distance must be >= 0 m, got {self.copy_distance!r}")
        if not self.min_evidence >= 0:
            raise ValueError(f"min_evidence must be >= 0, got {self.min_evidence!r}")

    def __call__(self, segments: LineSegments) -> LineSegments:
        """Return the segments that are worth keeping, with their lines numbered anew."""
        numbers = segments.pack()
        removed, kept, chosen = _reliable(
            numbers,
            segments.line,
            segments.points,
            self.min_points,
            self.max_error,
            math.sin(self.min_angle),
            self.copy_distance,
            self.min_evidence,
        )
        if removed == 0:
            return segments
        numbers, line, points = _chosen(numbers, segments.line, segments.points, kept, chosen)
        lock(numbers, line, points)
        return LineSegments.packed(numbers, line=line, points=points)


@kernel
def _chosen(
    packed: FloatArray, line: IntArray, points: BoolArray, kept: int, chosen: IntArray
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Return what is chosen of numbers, lines of segments, and beams that they hold."""
    count = line.size
    lines = (packed.size - 6 * count) // 8
    keep = chosen[lines : lines + kept]
    used = chosen[lines + kept :]
    numbers = np.empty(8 * used.size + 6 * kept)
    of_line = np.empty(kept, np.int64)
    beams = np.empty((kept, points.shape[1]), np.bool_)
    at = first = 0
    for width in (1, 1, 1, 1, 4):  # as `LineSegments.pack` lays them out
        for k in used:
            for m in range(width):
                numbers[at] = packed[first + width * k + m]
                at += 1
        first += width * lines
    for width in (1, 1, 4):
        for j in keep:
            for m in range(width):
                numbers[at] = packed[first + width * j + m]
                at += 1
        first += width * count
    for m in range(kept):
        of_line[m] = chosen[line[keep[m]]]
        for i in range(points.shape[1]):
            beams[m, i] = points[keep[m], i]
    return numbers, of_line, beams


@kernel
def _reliable(
    packed: FloatArray,
    line: IntArray,
    points: BoolArray,
    min_points: int,
    max_error: float,
    sin_min: float,
    copy_distance: float,
    min_evidence: float,
) -> tuple[int, int, IntArray]:
    """Return how many segments and lines go, how many segments stay, and which.

    The last is one array of the lines' new numbers (L,), the segments and the lines that stay.
    """
    count = line.size
    lines = (packed.size - 6 * count) // 8
    theta = packed[:lines]
    evidence = packed[3 * lines : 4 * lines]
    support = packed[8 * lines : 8 * lines + count]
    rms = packed[8 * lines + count : 8 * lines + 2 * count]
    endpoints = packed[8 * lines + 2 * count :].reshape(count, 2, 2)
    keep = np.empty(count, np.bool_)
    for j in range(count):
        keep[j] = (
            support[j] >= min_points and rms[j] <= max_error and evidence[line[j]] >= min_evidence
        )
    cos = np.cos(theta)
    sin = np.sin(theta)
    spans = np.full((count, 2), -1)
    for a in range(count):
        for b in range(a + 1, count):
            k, m = line[a], line[b]
            if not (keep[a] and keep[b]) or k == m:
                continue
            # The first is cheap: there are as many pairs as segments squared.
            if (
                abs(sin[k] * cos[m] - cos[k] * sin[m]) > sin_min + ROUNDING
                or abs(math.sin(theta[k] - theta[m])) >= sin_min
            ):
                continue
            better, worse = a, b
            if support[b] > support[a] or (support[b] == support[a] and rms[b] < rms[a]):
                better, worse = b, a
            if _is_copy(endpoints, support, points, spans, better, worse, copy_distance):
                keep[worse] = False
    chosen = np.zeros(lines + count + lines, np.int64)
    kept = 0
    for j in range(count):
        if keep[j]:
            chosen[lines + kept] = j
            chosen[line[j]] += 1
            kept += 1
    used = 0
    for k in range(lines):
        if chosen[k] > 0:
            chosen[lines + kept + used] = k
            chosen[k] = used
            used += 1
    return count - kept + lines - used, kept, chosen[: lines + kept + used]


@leaf
def _find_span(points: BoolArray, spans: IntArray, j: int) -> None:
    """Note the first beam of segment j, and one past its last, unless that is known."""
    if spans[j, 0] >= 0:
        return
    first = 0
    last = points.shape[1]
    while first < last and not points[j, first]:
        first += 1
    while last > first and not points[j, last - 1]:
        last -= 1
    spans[j, 0] = first
    spans[j, 1] = last


@leaf
def _is_copy(
    endpoints: FloatArray,
    support: FloatArray,
    points: BoolArray,
    spans: IntArray,
    better: int,
    worse: int,
    copy_distance: float,
) -> bool:
    """Tell whether a segment shares half of its points with a better one, or runs over it."""
    _find_span(points, spans, better)
    _find_span(points, spans, worse)
    shared = 0
    for i in range(max(spans[better, 0], spans[worse, 0]), min(spans[better, 1], spans[worse, 1])):
        shared += points[better, i] & points[worse, i]
    if 2 * shared >= support[worse]:
        return True
    x = endpoints[better, 0, 0]
    y = endpoints[better, 0, 1]
    ux = endpoints[better, 1, 0] - x
    uy = endpoints[better, 1, 1] - y
    length = math.sqrt(ux * ux + uy * uy)
    if length == 0.0:
        return False
    ux /= length
    uy /= length
    ax = endpoints[worse, 0, 0] - x
    ay = endpoints[worse, 0, 1] - y
    bx = endpoints[worse, 1, 0] - x
    by = endpoints[worse, 1, 1] - y
    low = min(ax * ux + ay * uy, bx * ux + by * uy)
    high = max(ax * ux + ay * uy, bx * ux + by * uy)
    apart = abs(0.5 * (ax + bx) * uy - 0.5 * (ay + by) * ux)
    over = min(high, length) - max(low, 0.0)
    return bool(over > 0.0 and over >= 0.5 * (high - low) and apart < copy_distance)
