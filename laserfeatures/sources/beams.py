"""Beam directions, one read-only array for all scans with the same beams."""

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


def spread_angles(count: int, field_of_view: float) -> FloatArray:
    """Return `count` directions spread evenly over `field_of_view` [rad], symmetric about 0."""
    if count < 2:
        return even_angles(count, 0.0, 1.0)
    return even_angles(count, -field_of_view / 2, field_of_view / (count - 1))


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
