"""What the text formats of Hokuyo URG-04LX sensors share: limits, and ranges in millimetres."""

import math

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.sources.beams import even_scan, numbers

RANGE_MIN, RANGE_MAX = 0.02, 5.6  # [m]; smaller values are error codes
STEP = 2 * math.pi / 1024
FIRST = (44 - 384) * STEP  # step 44 is the first that measures, 384 looks ahead
BEAMS = 682


def urg_scan(
    millimetres: list[bytes],
    range_max: float | None,
    stamp: float,
    first: float = FIRST,
    step: float = STEP,
    *,
    pose: Pose2D | None = None,
) -> LaserScan:
    """Make a scan of ranges in millimetres, given as text.

    Raises
    ------
    ValueError
        If one of them is not a number.
    """
    ranges = numbers(millimetres, "ranges in mm") / 1000
    ranges.flags.writeable = False
    limit = range_max or RANGE_MAX
    return even_scan(
        ranges, first, step, range_min=RANGE_MIN, range_max=limit, stamp=stamp, pose=pose
    )
