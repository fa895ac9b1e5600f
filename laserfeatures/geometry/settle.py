"""What comes before and after every search for walls."""

import math
from typing import Any

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, lock
from laserfeatures.data import LaserScan, Lines, LineSegments
from laserfeatures.geometry.arcs import set_arcs_aside
from laserfeatures.geometry.compiled import inlined
from laserfeatures.geometry.crumbs import drop_crumbs
from laserfeatures.geometry.noise import estimate_sigma
from laserfeatures.geometry.points import returns
from laserfeatures.geometry.segments import MAX_GROWTH, Segments, cut_segments
from laserfeatures.geometry.sharing import merge_pieces, share_points
from laserfeatures.geometry.short_walls import add_short_walls
from laserfeatures.geometry.walls import FREE, ROUND, Cut, lines_of, members_of, widen

# What a kernel returns: the numbers of lines and segments in one array, the line of each segment,
# and which beams it holds. Handing an array to Python takes half a microsecond, a view of it less.
Found = tuple[FloatArray, IntArray, BoolArray]

ALWAYS_WIDE = 0.1  # [m]; beams of a laser scanner are never that far apart at 1 m


def check_walls(detector: Any) -> None:
    """Check the parameters that all detectors of walls have.

    Raises
    ------
    ValueError
        If one is out of its range.
    """
    if detector.range_sigma is not None and not 0 < detector.range_sigma <= 1:
        raise ValueError(f"range_sigma must be in (0, 1] m, got {detector.range_sigma!r}")
    if not detector.min_points >= 3:
        raise ValueError(f"min_points must be >= 3, got {detector.min_points!r}")
    if not detector.max_missed >= 0:
        raise ValueError(f"max_missed must be >= 0, got {detector.max_missed!r}")
    for name in ("max_gap", "object_gap"):
        if not 0 < getattr(detector, name) < math.inf:
            raise ValueError(f"{name} must be > 0 m, got {getattr(detector, name)!r}")
    if not detector.max_pole_radius >= 0:
        raise ValueError(f"max_pole_radius must be >= 0 m, got {detector.max_pole_radius!r}")


def check_gap(scan: LaserScan, max_gap: float) -> None:
    """Check that the beams of a scan are not farther apart than a gap may be.

    Raises
    ------
    ValueError
        If beside the nearest return, or at 1 m if that is nearer, they are.
    """
    if max_gap >= ALWAYS_WIDE or len(scan) < 2:
        return
    step = float(np.diff(scan.angles).min())
    nearest = min(1.0, float(scan.ranges[scan.beams].min(initial=math.inf)))
    if max_gap < step * nearest:
        raise ValueError(
            f"max_gap is {max_gap} m, but beams {math.degrees(step):.3g} deg apart are "
            f"{step * nearest:.4f} m apart at {nearest:.2f} m: every step would be a gap"
        )


@inlined
def free_points(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    jump: float,
    radius: float,
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, float]:
    """Return x, y and beam of the returns, their owners, all free but for poles, and the noise.

    `sigma` 0 stands for unknown: it is estimated. `jump` is the distance of points on different
    objects, `radius` the largest of a round object; 0 keeps them.
    """
    x, y, beam = returns(directions, ranges, limits[0], limits[1])
    owner = np.empty(x.size, np.int64)
    for i in range(x.size):
        owner[i] = FREE
    if sigma == 0.0:
        sigma = estimate_sigma(x, y)
    if radius > 0.0:
        set_arcs_aside(x, y, beam, sigma, jump, radius, ROUND, owner)
    return x, y, beam, owner, sigma


@inlined
def settle(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    beams: int,
    owner: IntArray,
    walls: FloatArray,
    sigma: float,
    gate: float,
    refit: bool,
    cut: Cut,
) -> Found:
    """Turn what a search found into lines and their segments.

    The shortest walls get their ends back, pieces of one wall are merged, the points at corners
    shared out, the lines cut into segments, and what is too small for one is dropped.

    Points that are free still and within `gate` of a wall beside them join it; 0 leaves them free.
    `refit` says that the walls' fits are not the weighted ones of `fit_line` yet.
    """
    walls = add_short_walls(x, y, beam, owner, walls, sigma, cut)
    merge_pieces(x, y, owner, walls, sigma)
    line, member = share_points(x, y, owner, walls, gate, sigma, refit, cut[0])
    if refit and merge_pieces(x, y, owner, walls, sigma):  # rough fits had kept pieces apart
        line, member = members_of(owner, walls, cut[0])
    theta, d, support, covariance = lines_of(walls, cut[0], sigma)
    segments = cut_segments(x, y, beam, beams, theta, d, line, member, cut[1], cut[2], MAX_GROWTH)
    if drop_crumbs(x, y, owner, walls, member, segments[2], cut[0]):
        line, member = members_of(owner, walls, cut[0])
        theta, d, support, covariance = lines_of(walls, cut[0], sigma)
        segments = cut_segments(
            x, y, beam, beams, theta, d, line, member, cut[1], cut[2], MAX_GROWTH
        )
    widen(x, y, line, member, theta, d, covariance, sigma)
    return pack(theta, d, support, covariance, segments)


@inlined
def pack(
    theta: FloatArray,
    d: FloatArray,
    support: FloatArray,
    covariance: FloatArray,
    segments: Segments,
) -> Found:
    """Put the numbers of lines and segments into one array, one field after another."""
    line, endpoints, points_on, rms, points = segments
    lines = theta.size
    count = line.size
    numbers = np.empty(7 * lines + 6 * count)
    for k in range(lines):
        numbers[k] = theta[k]
        numbers[lines + k] = d[k]
        numbers[2 * lines + k] = support[k]
        at = 3 * lines + 4 * k
        numbers[at] = covariance[k, 0, 0]
        numbers[at + 1] = numbers[at + 2] = covariance[k, 0, 1]
        numbers[at + 3] = covariance[k, 1, 1]
    for j in range(count):
        at = 7 * lines + j
        numbers[at] = points_on[j]
        numbers[at + count] = rms[j]
        at += 2 * count + 3 * j
        numbers[at] = endpoints[j, 0, 0]
        numbers[at + 1] = endpoints[j, 0, 1]
        numbers[at + 2] = endpoints[j, 1, 0]
        numbers[at + 3] = endpoints[j, 1, 1]
    return numbers, line, points


def line_segments(found: Found) -> LineSegments:
    """Return what a kernel found as `LineSegments`."""
    numbers, line, points = found
    lock(numbers, line, points)
    count = line.size
    lines = (numbers.size - 6 * count) // 7
    rest = numbers[7 * lines :]
    return LineSegments.trusted(
        lines=Lines.trusted(
            theta=numbers[:lines],
            d=numbers[lines : 2 * lines],
            support=numbers[2 * lines : 3 * lines],
            covariance=numbers[3 * lines : 7 * lines].reshape(lines, 2, 2),
        ),
        line=line,
        endpoints=rest[2 * count :].reshape(count, 2, 2),
        support=rest[:count],
        rms=rest[count : 2 * count],
        points=points,
    )
