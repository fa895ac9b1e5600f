"""From the readings of a log without a range limit to scans with one."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.no_return import RangeLimit

BLOCK_BEAMS, BLOCK_SCANS = 200_000, 1_000  # bound the memory for long scans and for short ones


class Reading(NamedTuple):
    """A scan whose no-return value is not known yet."""

    angles: FloatArray
    ranges: FloatArray
    stamp: float
    pose: Pose2D | None
    range_max: float = math.inf
    odometry: Pose2D | None = None  # of the robot, where the log has it beside the laser's pose


def finish(log: Log, readings: Iterator[Reading]) -> Scans:
    """Yield `readings` as scans, with the limit that the values show (see `no_return`).

    A block whose stamps are all 0 has none: they become nan.
    """
    limit = RangeLimit()
    for block in _blocks(readings):
        found = log.range_max or limit.update([reading.ranges for reading in block])
        stamped = len(block) == 1 or any(reading.stamp for reading in block)
        for reading in block:
            yield LaserScan(
                angles=reading.angles,
                ranges=reading.ranges,
                range_max=found if log.range_max else min(found, reading.range_max),
                stamp=reading.stamp if stamped else math.nan,
                pose=reading.pose,
            )


def _blocks(readings: Iterator[Reading]) -> Iterator[list[Reading]]:
    """Group readings; those before an error come out before it is raised."""
    block: list[Reading] = []
    beams = 0
    error = None
    try:
        for reading in readings:
            block.append(reading)
            beams += reading.ranges.size
            if beams >= BLOCK_BEAMS or len(block) == BLOCK_SCANS:
                yield block
                block, beams = [], 0
    except SourceError as broken:
        error = broken
    if block:
        yield block
    if error:
        raise error
