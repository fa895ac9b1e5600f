"""Kernels that tell which returns of a scan are on one surface, and so to be joined by a line."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.engine import ZERO, helper

NOISES = 3.0  # standard deviations of the noise that may be mistaken for shape
PLAIN = math.tan(math.radians(30))  # surfaces that are met at this angle or more need no other test
BASELINE = 5.0  # pixels; over that length two returns tell the direction of their surface


@helper
def contours(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    live: IntArray,
    slant: float,
    sigma: float,
    baseline: float,
    max_missed: int,
) -> tuple[IntArray, IntArray]:
    """Chain the points `live` of each surface; return the points and where each chain ends.

    Chain k is ``points[ends[k] : ends[k + 1]]``. More than `max_missed` beams without a point of
    the chain end it. Points that it goes past as outliers, or that none other joins, are on none.
    """
    points = np.empty(live.size, np.int64)
    ends = np.empty(live.size + 1, np.int64)
    count = chains = 0
    m = ZERO
    joined = False
    while m < live.size:
        i = live[m]
        if not joined:
            if chains > 0 and ends[chains - 1] == count - 1:  # the last chain has only one point
                count -= 1
                chains -= 1
            ends[chains] = count
            chains += 1
        points[count] = i
        count += 1
        after = m + 1
        joined = False
        if after < live.size:
            # Most points end here, and a call with so many arrays takes longer than the test.
            j = live[after]
            joined = beam[j] - beam[i] <= max_missed + 1 and is_near(x[i], y[i], x[j], y[j], PLAIN)
            if not joined:
                after = next_on(x, y, beam, live, m, slant, sigma, baseline, max_missed)
                joined = after > m
        m = after if joined else m + 1
    if chains > 0 and ends[chains - 1] == count - 1:
        count -= 1
        chains -= 1
    ends[chains] = count
    return points[:count], ends[: chains + 1]


@helper
def is_near(ax: float, ay: float, bx: float, by: float, slant: float) -> bool:
    """Tell whether returns a and b are as near as on a surface that the beams meet at a wide angle.

    At an angle lambda or more they are no farther apart than r sin(phi) / sin(lambda - phi), with
    phi the angle between the beams (Borges and Aldon 2004); `slant` is tan(lambda).
    """
    cross = abs(ax * by - bx * ay)
    steep = slant * (ax * bx + ay * by) - cross
    near = min(ax * ax + ay * ay, bx * bx + by * by)
    apart = (bx - ax) ** 2 + (by - ay) ** 2
    return steep > 0.0 and apart * steep * steep <= near * (1.0 + slant * slant) * cross * cross


@helper
def next_on(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    live: IntArray,
    m: int,
    slant: float,
    sigma: float,
    baseline: float,
    max_missed: int,
) -> int:
    """Return the number of the next point on the surface of ``live[m]``, or -1.

    It is the next point of all, if that is joined to this one. Past others, which then are
    outliers, it is one that is plainly near and that the surface goes straight on to.
    """
    i = live[m]
    for n in range(m + 1, live.size):
        j = live[n]
        if beam[j] - beam[i] > max_missed + 1:
            break
        if n == m + 1:
            if are_joined(x, y, live, m, n, slant, sigma, baseline):
                return n
        elif is_near(x[i], y[i], x[j], y[j], PLAIN):
            straight, _ = how_joined(x, y, live, m, n, sigma, baseline)
            if straight:
                return n
    return -1


@helper
def are_joined(
    x: FloatArray,
    y: FloatArray,
    live: IntArray,
    m: int,
    n: int,
    slant: float,
    sigma: float,
    baseline: float,
) -> bool:
    """Tell whether two points of successive beams are on one surface.

    They are where they are near each other for the noise or on a surface that is met at a plain
    angle, and are not where they are too far apart for one that is met at `slant`. Between the two
    the surface goes straight on, has a corner there, or ends: the edge of an object.
    """
    i = live[m]
    j = live[n]
    if is_near(x[i], y[i], x[j], y[j], PLAIN):
        return True
    if (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 <= 2.0 * (NOISES * sigma) ** 2:
        return True
    if not is_near(x[i], y[i], x[j], y[j], slant):
        return False
    straight, corner = how_joined(x, y, live, m, n, sigma, baseline)
    return straight or corner


@helper
def how_joined(
    x: FloatArray, y: FloatArray, live: IntArray, m: int, n: int, sigma: float, baseline: float
) -> tuple[bool, bool]:
    """Tell whether the surfaces at two points may be a straight one, and whether they meet between.

    They meet between the beams of the two where either point lies before the other's surface, a
    corner that recedes, or either behind it, one that juts out. At the edge of an object the point
    on what is hidden lies behind, and that on the object before the other's surface.
    """
    first, doubt = behind(x, y, live, m, -1, live[n], sigma, baseline)
    straight = abs(first) <= doubt
    second, doubt = behind(x, y, live, n, 1, live[m], sigma, baseline)
    straight = straight or abs(second) <= doubt
    return straight, (first > 0.0) == (second > 0.0)


@helper
def behind(
    x: FloatArray,
    y: FloatArray,
    live: IntArray,
    m: int,
    way: int,
    other: int,
    sigma: float,
    baseline: float,
) -> tuple[float, float]:
    """Return how far a point lies behind the surface beside ``live[m]``, and the doubt in that.

    Negative is before the surface. Its direction is that from ``live[m]`` to the next point that is
    `baseline` away, along the scan or (`way` -1) against it; with none the doubt is infinite.
    """
    i = live[m]
    k = m + way
    dx = dy = square = 0.0
    while square < baseline * baseline:
        if not 0 <= k < live.size:
            return 0.0, math.inf
        dx = x[live[k]] - x[i]
        dy = y[live[k]] - y[i]
        square = dx * dx + dy * dy
        k += way
    length = math.sqrt(square)
    ox = x[other] - x[i]
    oy = y[other] - y[i]
    off = (ox * dy - oy * dx) / length
    if x[i] * dy - y[i] * dx < 0.0:  # then that normal points at the sensor
        off = -off
    return off, NOISES * sigma * (1.0 + 2.0 * math.sqrt((ox * ox + oy * oy) / square))
