"""RPLIDAR text files: `angle distance quality` a line, in degrees clockwise and millimetres.

`#` lines are comments; `#COUNT=` says how many measurements follow. A turn ends where the angle
passes the turn's first angle again, and is one scan. The sensor's steps are irregular: the
beams are sorted, and equal angles are told apart by the smallest possible difference. There are no
times and no poses, and no range limit (the file does not name the model); distance 0 is no return.
"""

import math
import re

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.sources.log import Log, Scans

COUNT = re.compile(rb"#\s*COUNT\s*=\s*(\d+)")


def is_rplidar(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a file."""
    lines = head.splitlines()
    data = next((line for line in lines if line.strip() and not line.startswith(b"#")), b"")
    try:
        return head.startswith(b"#RPLIDAR") or len([float(token) for token in data.split()]) == 3
    except ValueError:
        return False


def read_rplidar(log: Log) -> Scans:
    """Yield the turns of such a file."""
    expected = None

    def parse(line: bytes) -> tuple[float, float] | None:
        nonlocal expected
        if not line.strip() or line.startswith(b"#"):
            count = COUNT.match(line)
            expected = int(count[1]) if count else expected
            return None
        return _measurement(line.split())

    turn: list[tuple[float, float]] = []
    travelled, got = 0.0, 0
    for angle, distance in log.records(parse):
        if turn:
            travelled += (angle - turn[-1][0] + 180) % 360 - 180  # neighbours may be out of order
        if travelled >= 360:
            yield _scan(turn, log.range_max)
            turn, travelled = [], 0.0
        turn.append((angle, distance))
        got += 1
    if turn:
        yield _scan(turn, log.range_max)
    if expected is not None and got + log.skipped != expected:
        problem = f"expected {expected} measurements as #COUNT= says, got {got}; the file is cut"
        log.broken("end", problem, EOFError(problem))


def _measurement(tokens: list[bytes]) -> tuple[float, float]:
    if len(tokens) != 3:
        raise ValueError(f"expected angle, distance and quality, got {len(tokens)} fields")
    angle, distance, _ = (float(token) for token in tokens)
    if not math.isfinite(angle):
        raise ValueError(f"expected a finite angle in degrees, got {angle}")
    return angle, distance


def _scan(turn: list[tuple[float, float]], range_max: float | None) -> LaserScan:
    degrees, millimetres = np.array(turn).T
    angles = math.pi - np.radians(degrees + 180) % (2 * math.pi)  # counter-clockwise
    order = np.argsort(angles, kind="stable")
    angles = angles[order]
    for i in np.flatnonzero(np.diff(angles) <= 0) + 1:
        angles[i] = np.nextafter(angles[i - 1], math.inf)
    return LaserScan(
        angles=angles, ranges=millimetres[order] / 1000, range_max=range_max or math.inf
    )
