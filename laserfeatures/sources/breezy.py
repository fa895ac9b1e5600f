"""BreezySLAM logs (`.dat`) of a Hokuyo URG-04LX on a rover: one scan a line.

25 fields, the first of them the time in microseconds, the third and fourth what the left and right
wheel have counted, then 682 ranges in millimetres. The poses are the scanner's by these ticks.

The counts are ahead of the scan in the same line: of ``breezy_exp1.dat``, neighbouring scans fit
each other best with the counts of 0.15 s before, in each quarter of the log.
"""

import math

from laserfeatures.data import LaserScan
from laserfeatures.sources.beams import numbers
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.urg import BEAMS, urg_scan
from laserfeatures.wheels import WheelOdometry, Wheels

FIELDS = 25
LEFT = 2  # its field, that of the right wheel follows
ROVER = Wheels(tick=math.tau * 0.077 / 2000, track=2 * 0.165, ahead=0.145, latency=0.15)


def is_breezy(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a BreezySLAM log."""
    tokens = head.split(b"\n", 1)[0].split()
    return len(tokens) > FIELDS and all(
        token.replace(b".", b"", 1).lstrip(b"-").isdigit() for token in tokens
    )


def read_breezy(log: Log) -> Scans:
    """Yield the scans of a BreezySLAM log."""
    log.poses = "odometry"
    odometry = WheelOdometry(ROVER, keep=ROVER.latency)

    def parse(line: bytes) -> LaserScan | None:
        tokens = line.split()
        if not tokens:
            return None
        if len(tokens) != FIELDS + BEAMS:
            raise ValueError(
                f"expected {FIELDS} fields and {BEAMS} ranges, got {len(tokens)} fields"
            )
        stamp = int(tokens[0]) / 1e6
        left, right = numbers(tokens[LEFT : LEFT + 2], "ticks of both wheels").tolist()
        odometry.add(stamp, left, right)
        return urg_scan(tokens[FIELDS:], log.range_max, stamp, pose=odometry.at(stamp))

    yield from log.records(parse)
