"""BreezySLAM logs (`.dat`) of a Hokuyo URG-04LX: one scan a line.

25 fields, the first of them the time in microseconds, then 682 ranges in millimetres. The wheel
ticks among the 25 are not read: the scans have no pose.
"""

from laserfeatures.data import LaserScan
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.urg import BEAMS, urg_scan

FIELDS = 25


def is_breezy(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a BreezySLAM log."""
    tokens = head.split(b"\n", 1)[0].split()
    return len(tokens) > FIELDS and all(
        token.replace(b".", b"", 1).lstrip(b"-").isdigit() for token in tokens
    )


def read_breezy(log: Log) -> Scans:
    """Yield the scans of a BreezySLAM log."""

    def parse(line: bytes) -> LaserScan | None:
        tokens = line.split()
        if not tokens:
            return None
        if len(tokens) != FIELDS + BEAMS:
            raise ValueError(
                f"expected {FIELDS} fields and {BEAMS} ranges, got {len(tokens)} fields"
            )
        return urg_scan(tokens[FIELDS:], log.range_max, int(tokens[0]) / 1e6)

    yield from log.records(parse)
