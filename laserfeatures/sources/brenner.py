"""Logs of Brenner's SLAM lecture (URG-04LX class sensor): `S ms n r1..rn`, in millimetres.

Either the scan file or the folder that holds it. Poses are by the wheel ticks of the motors file
beside it (see `brenner_motors`); without one the scans have none. The reference beside it has
positions without headings, and is no odometry.
"""

from pathlib import Path

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.sources.brenner_motors import POSE_GAP, motors_of, odometry_of
from laserfeatures.sources.files import read_head
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.urg import urg_scan

STEP = 0.006135923  # [rad], 360/1024 degrees as the lecture rounds it
OFFSET = -0.06981317  # [rad], how the sensor is mounted
OTHERS = (b"P", b"M", b"L", b"I", b"F")  # reference, motors, landmarks and results


def is_brenner(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a scan file."""
    tokens = head.split(b"\n", 1)[0].split(None, 4)
    return len(tokens) > 3 and tokens[0] == b"S" and all(t.isdigit() for t in tokens[1:4])


def scan_files(folder: Path) -> list[Path]:
    """Return the scan files in `folder`."""
    return [path for path in sorted(folder.iterdir()) if path.is_file() and _has_scans(path)]


def _has_scans(path: Path) -> bool:
    try:
        return is_brenner(read_head(path))
    except SourceError:  # empty or damaged: no concern of its neighbours
        return False


def read_brenner(log: Log) -> Scans:
    """Yield the scans of such a log."""
    path = log.path
    if path.is_dir():
        files = scan_files(path)
        if len(files) != 1:
            found = ", ".join(file.name for file in files) or "none"
            raise SourceError(f"{path}: expected one file with S records, got {found}; name one")
        path = files[0]
    motors = motors_of(path)
    odometry = odometry_of(log, motors) if motors else None
    if odometry:
        log.poses = "odometry"

    def parse(line: bytes) -> LaserScan | None:
        tokens = line.split()
        if not tokens or tokens[0] in OTHERS:
            return None
        if tokens[0] != b"S" or len(tokens) < 3 or len(tokens) != 3 + int(tokens[2]):
            start = b" ".join(tokens[:3])[:30].decode("ascii", "backslashreplace")
            raise ValueError(
                f"expected S, milliseconds, the number of ranges and as many ranges, got "
                f"{len(tokens)} fields that start with {start!r}"
            )
        first = OFFSET - (len(tokens) - 3) // 2 * STEP
        stamp = int(tokens[1]) / 1e3
        known = odometry is not None and stamp <= odometry.end + POSE_GAP
        pose = odometry.at(stamp) if odometry and known else None
        return urg_scan(tokens[3:], log.range_max, stamp, first, STEP, pose=pose)

    yield from log.records(parse, path)
