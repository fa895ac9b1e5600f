"""Bare rows of 682 ranges in millimetres, as some URG-04LX programs save them (`.csv`).

No header, no times, no poses. A row of nothing but zeros is space that was never filled (the
programs save a table of fixed size): a real scan of this sensor always holds some return or some
error code. Such rows are left out.
"""

import math

from laserfeatures.data import LaserScan
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.urg import BEAMS, urg_scan


def is_urg_csv(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a table."""
    cells = head.split(b"\n", 1)[0].split(b",")
    return len(cells) == BEAMS and all(cell.strip().isdigit() for cell in cells)


def read_urg_csv(log: Log) -> Scans:
    """Yield the scans of such a table."""

    def parse(line: bytes) -> LaserScan | None:
        if not line.strip(b"0, \r\n"):
            return None
        cells = line.split(b",")
        if len(cells) != BEAMS:
            raise ValueError(f"expected {BEAMS} ranges in mm, got {len(cells)} cells")
        return urg_scan(cells, log.range_max, math.nan)

    yield from log.records(parse)
