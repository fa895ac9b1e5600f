"""Beam directions, one read-only array for all scans with the same beams."""

import math
from functools import lru_cache

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.scan import FULL_TURN, LaserScan, Pose2D


@lru_cache(maxsize=16)
def even_angles(count: int, first: float, step: float) -> FloatArray:
    """Return `count` directions [rad] from `first` on in steps of `step`, in increasing order.

    Raises
    ------
    ValueError
        If they are not distinct or span more than a turn.
    """
    angles: FloatArray = first + step * np.arange(count, dtype=np.float64)
    if step < 0:
        angles = angles[::-1].copy()
    if count and not ((np.diff(angles) > 0).all() and angles[-1] - angles[0] <= FULL_TURN):
        raise ValueError(
            f"expected distinct directions within one turn, got {count} from {first} rad on in "
            f"steps of {step} rad"
        )
    angles.flags.writeable = False
    return angles


def spread_angles(count: int, field_of_view: float | tuple[float, float]) -> FloatArray:
    """Return `count` directions spread evenly over `field_of_view` [rad].

    That is from its first to its second value, or, if it is one, symmetric about 0.
    """
    if isinstance(field_of_view, tuple):
        first, last = field_of_view
    else:
        first, last = -field_of_view / 2, field_of_view / 2
    if count < 2:
        return even_angles(count, (first + last) / 2, 1.0)
    return even_angles(count, first, (last - first) / (count - 1))


def even_scan(
    ranges: FloatArray,
    first: float,
    step: float,
    *,
    range_min: float,
    range_max: float,
    stamp: float,
    pose: Pose2D | None = None,
) -> LaserScan:
    """Make a scan of evenly spaced beams, as `LaserScan.uniform` does, with shared angles.

    Raises
    ------
    ValueError
        As `even_angles` and `LaserScan`.
    """
    angles = even_angles(ranges.size, first, step if ranges.size > 1 else 1.0)
    return LaserScan(
        angles=angles,
        ranges=ranges[::-1] if step < 0 else ranges,
        range_min=range_min,
        range_max=range_max,
        stamp=stamp,
        pose=pose,
    )


def told_apart(angles: FloatArray) -> FloatArray:
    """Return angles in order, (N,) [rad], equal ones moved by the least step there is."""
    angles = angles.copy()
    for i in np.flatnonzero(np.diff(angles) <= 0) + 1:
        angles[i] = np.nextafter(angles[i - 1], np.inf)
    return angles


def contradiction(first: float, step: float, count: int, last: float) -> str | None:
    """Return what to say where `last` [rad] is not the direction of the last of `count` beams.

    Some drivers give the direction of the next one, which is none.
    """
    off = (last - first) / step - (count - 1) if count > 1 and step else 0.0
    if -0.5 <= off <= 1.5 or not math.isfinite(off):
        return None
    return (
        f"angle_max is {math.degrees(last):.2f} deg, but angle_min + {count - 1} x angle_increment "
        f"is {math.degrees(first + (count - 1) * step):.2f} deg: the increment, "
        f"{math.degrees(step):.4f} deg, is believed; by angle_min and angle_max a beam comes every "
        f"{math.degrees((last - first) / (count - 1)):.4f} deg"
    )


def numbers(tokens: list[bytes], what: str) -> FloatArray:
    """Return `tokens` as a read-only array.

    Raises
    ------
    ValueError
        If one of them is not a number; the message names `what` was expected, and it.
    """
    try:
        array: FloatArray = np.array(tokens, dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"expected {what}: {error}") from error
    array.flags.writeable = False
    return array
