"""From the measurements of a turn to a scan."""

import math
from collections.abc import Sequence

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.drivers.rplidar.nodes import DEGREE, TURN, Measurements
from laserfeatures.scan import LaserScan

NEIGHBOURS = 4  # on either side, that an angle is compared with
OUTLIER = 15 * DEGREE  # an angle further than this from most of them is damaged
HOLE = 4.0  # median steps; a wider one is a hole
SMALLEST_HOLE = 3 * DEGREE
APART = 1e-9  # [rad] between measurements of equal angle
TO_RADIANS = math.pi / (TURN // 2)
EMPTY = Measurements(np.empty(0, np.int64), np.empty(0), np.empty(0, np.int64))


def joined(pieces: Sequence[Measurements]) -> Measurements:
    """Return measurements one after the other."""
    angles, distances, quality = zip(*pieces, strict=True)
    return Measurements(np.concatenate(angles), np.concatenate(distances), np.concatenate(quality))


def part(measured: Measurements, which: slice | BoolArray) -> Measurements:
    """Return a part of the measurements."""
    angles, distances, quality = measured
    return Measurements(angles[which], distances[which], quality[which])


def outliers(measured: Measurements) -> BoolArray:
    """Return which angles (N,) cannot be, as most of those before and after are elsewhere."""
    company = np.zeros(len(measured.angles), np.int64)
    for away in range(1, NEIGHBOURS + 1):
        close = abs(difference(measured.angles, np.roll(measured.angles, away))) <= OUTLIER
        company += close
        company += np.roll(close, -away)
    wrong: BoolArray = company < NEIGHBOURS - 1
    return wrong


def share_missing(measured: Measurements) -> float:
    """Return the share of the turn in which nothing was measured."""
    if len(measured.angles) < 2:
        return 1.0
    ordered = np.sort(measured.angles)
    steps = np.diff(ordered, append=ordered[0] + TURN)
    step = np.median(steps)
    holes = steps[steps > max(HOLE * step, SMALLEST_HOLE)]
    return float((holes - step).sum() / TURN)


def scan_of(
    measured: Measurements, limits: tuple[float, float], stamp: float, min_quality: int
) -> LaserScan:
    """Return the scan of a turn.

    The device counts angles clockwise from its front, 0 .. 360 degrees; the scan has them
    counter-clockwise from -pi (excluded) to pi, 0 at the front, sorted. Measurements of the same
    angle, in units of the device, are kept, a nanoradian apart. No return is nan.

    Parameters
    ----------
    measured : Measurements
        Of one turn, in any order.
    limits : tuple of float
        Smallest and largest range [m].
    stamp : float
        Time of the turn's first measurement [s].
    min_quality : int
        Below it a measurement is no return.
    """
    turned = TURN // 2 - (measured.angles + TURN // 2) % TURN
    order = np.argsort(turned, kind="stable")
    turned = turned[order]
    angles: FloatArray = np.multiply(turned, TO_RADIANS)
    same = np.flatnonzero(turned[1:] == turned[:-1]) + 1
    if same.size:
        place = np.arange(turned.size)
        first = place.copy()
        first[same] = 0
        angles += APART * (place - np.maximum.accumulate(first))
    returned = (measured.distances > 0) & (measured.quality >= min_quality)
    ranges = np.where(returned, measured.distances / 1000, math.nan)[order]
    return LaserScan(
        angles=angles, ranges=ranges, range_min=limits[0], range_max=limits[1], stamp=stamp
    )


def difference(later: IntArray, earlier: IntArray) -> IntArray:
    """Return how far it is from one angle to the other, at most half a turn."""
    off: IntArray = (later - earlier + TURN // 2) % TURN - TURN // 2
    return off
