"""From the readings of a log without a range limit to scans with one."""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple, TypeVar

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.no_return import RangeLimit, below_limit

BLOCK_BEAMS, BLOCK_SCANS = 200_000, 1_000  # bound the memory for long scans and for short ones


class Reading(NamedTuple):
    """A scan whose no-return value is not known yet."""

    angles: FloatArray
    ranges: FloatArray
    stamp: float
    pose: Pose2D | None
    range_max: float = math.inf
    odometry: Pose2D | None = None  # of the robot, where the log has it beside the laser's pose


Sweep = TypeVar("Sweep", Reading, LaserScan)


def finish(log: Log, readings: Iterator[Reading]) -> Scans:
    """Yield `readings` as scans, with the limit that the values show (see `no_return`).

    A block whose stamps are all 0 has none: they become nan.
    """
    limit = RangeLimit()
    for block in _blocks(readings):
        found = log.range_max or limit.update([reading.ranges for reading in block])
        if not log.range_max and found < math.inf:
            log.no_return = min(found, log.no_return or math.inf)
        stamped = len(block) == 1 or any(reading.stamp for reading in block)
        for reading in block:
            yield LaserScan(
                angles=reading.angles,
                ranges=reading.ranges,
                range_max=found if log.range_max else min(found, reading.range_max),
                stamp=reading.stamp if stamped else math.nan,
                pose=reading.pose,
            )


def limited(log: Log, scans: Iterator[LaserScan]) -> Iterator[LaserScan]:
    """Yield scans without the no-returns that only the log as a whole shows (see `no_return`)."""
    limit = RangeLimit()
    for block in _blocks(scans):
        known = min(scan.range_max for scan in block)
        rows = [scan.ranges for scan in block]
        found = limit.update(
            [row[row < scan.range_max] for row, scan in zip(rows, block, strict=True)]
        )
        found = min(found, below_limit(np.concatenate(rows), known))
        if found < known:
            log.no_return = min(found, log.no_return or math.inf)
            log.notice(
                "no return",
                f"ranges of {found:g} m and more are taken for no return, as they come again and "
                "again; range_max= (--range-max) says otherwise",
            )
        for scan in block:
            yield scan if scan.range_max <= found else replace(scan, range_max=found)


def _blocks(readings: Iterator[Sweep]) -> Iterator[list[Sweep]]:
    """Group readings; those before an error come out before it is raised."""
    block: list[Sweep] = []
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
