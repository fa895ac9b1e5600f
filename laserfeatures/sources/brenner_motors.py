"""The wheels of the robot of Brenner's SLAM lecture: `M ms left . . . right ..`, in ticks.

The lecture gives 0.349 mm a tick, a wheel gauge that was measured as 173 mm, a scanner 30 mm ahead
of the axle, and a start at (1850 mm, 1897 mm, 213 degrees) in the frame of the arena, whose walls
are at x, y = 0 and 2000 mm. (Its later units take a gauge of 150 or 155 mm. In `robot4` that turns
the robot by 756 degrees where the walls in the scans show 678; 173 mm gives 677.)

The scans are stamped later than the ticks: by 0.45 s, at which odometry agrees best with the poses
that the walls in the scans of `robot4` show, in either half of it.
"""

import math
import re
from collections.abc import Callable
from pathlib import Path

from laserfeatures.errors import SourceError
from laserfeatures.scan import Pose2D
from laserfeatures.sources.beams import numbers
from laserfeatures.sources.files import read_head
from laserfeatures.sources.log import Log
from laserfeatures.wheels import WheelOdometry, Wheels

ROBOT = Wheels(tick=0.349e-3, track=0.173, ahead=0.03, latency=0.45)
START = Pose2D(1.850, 1.897, math.radians(213))
LEFT, RIGHT = 2, 6  # the ticks' fields
POSE_GAP = 1.0  # [s]; a scan that is later than the last ticks by more has no pose
SCAN = re.compile(r"scans?(?!.*scan)", re.IGNORECASE)


def is_motors(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a file."""
    tokens = head.split(b"\n", 1)[0].split()
    return len(tokens) > RIGHT and tokens[0] == b"M" and tokens[1].isdigit()


def motors_of(scans: Path) -> Path | None:
    """Return the motors file that stands beside a scan file, by its name, or None.

    ``robot4_scan.txt`` has ``robot4_motors.txt``, either of them packed with gzip or not.
    """
    return beside(scans, ("motors", "motor"), is_motors)


def beside(scans: Path, words: tuple[str, ...], is_it: Callable[[bytes], bool]) -> Path | None:
    """Return the file whose name has one of `words` where that of `scans` has "scan", or None.

    It is None as well if the file's content is not what `is_it` tells.
    """
    for word in words:
        name, count = SCAN.subn(word, scans.name)
        if not count:
            return None
        for other in (name, name.removesuffix(".gz"), f"{name}.gz"):
            path = scans.with_name(other)
            if path.is_file() and is_it(read_head(path)):
                return path
    return None


def odometry_of(log: Log, path: Path) -> WheelOdometry:
    """Return the odometry of a motors file; its broken lines are the log's.

    Raises
    ------
    SourceError
        If a line is broken, or there is none that is whole.
    """
    odometry = WheelOdometry(ROBOT, START)

    def parse(line: bytes) -> None:
        tokens = line.split()
        if not tokens:
            return
        if tokens[0] != b"M" or len(tokens) <= RIGHT:
            start = b" ".join(tokens[:3])[:30].decode("ascii", "backslashreplace")
            raise ValueError(
                f"expected M, milliseconds and at least {RIGHT - 1} more fields, got "
                f"{len(tokens)} fields that start with {start!r}"
            )
        stamp = int(tokens[1]) / 1e3
        if stamp < odometry.end:
            raise ValueError(f"expected a time after {odometry.end} s, got {stamp} s")
        ticks = numbers([tokens[LEFT], tokens[RIGHT]], "ticks of both wheels")
        odometry.add(stamp, *ticks.tolist())

    for _ in log.records(parse, path):
        pass
    if odometry.end == -math.inf:
        raise SourceError(f"{path}: expected records M with wheel ticks, got none")
    return odometry
