"""RPLIDAR text files: `angle distance quality` a line, in degrees clockwise and millimetres.

Or `quality angle distance`, or `new quality angle distance`, as its Python libraries give them.
Files that do not begin with `#RPLIDAR` or `#COUNT` are held against that: the angles must go round.

`#` lines are comments; `#COUNT=` says how many measurements follow. A turn ends where the angle
passes the turn's first angle again, and is one scan. The sensor's steps are irregular: the
beams are sorted, and equal angles are told apart by the smallest possible difference. There are no
times and no poses, and no range limit (the file does not name the model); distance 0 is no return.
"""

import math
import re

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.sources.beams import told_apart
from laserfeatures.sources.files import MOST_BEAMS, read_head
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.text_columns import (
    begins_with_words,
    rows_of,
    rplidar_columns,
    split_cells,
)

TITLE = re.compile(rb"#\s*(RPLIDAR|COUNT\s*=)")
COUNT = re.compile(rb"#\s*COUNT\s*=\s*(\d+)")


def is_rplidar(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a file."""
    if TITLE.match(head):
        return True
    return not begins_with_words(head) and rplidar_columns(rows_of(head)[0]) is not None


def read_rplidar(log: Log) -> Scans:
    """Yield the turns of such a file."""
    expected = None
    rows, delimiter = rows_of(read_head(log.path))
    found = rplidar_columns(rows)
    place, width = (found, rows.shape[1]) if found else ((0, 1), 3)
    if found and not TITLE.match(read_head(log.path)):
        log.notice(
            "columns",
            "no header: taken for RPLIDAR text, with clockwise angles in degrees in column "
            f"{place[0] + 1} and distances in mm in column {place[1] + 1}",
        )

    def parse(line: bytes) -> tuple[float, float] | None:
        nonlocal expected
        if not line.strip() or line.startswith(b"#"):
            count = COUNT.match(line)
            expected = int(count[1]) if count else expected
            return None
        cells = split_cells(line.decode("ascii", "backslashreplace"), delimiter if found else None)
        return _measurement(cells, width, *place)

    turn: list[tuple[float, float]] = []
    travelled, got = 0.0, 0
    for angle, distance in log.records(parse):
        if turn:
            travelled += (angle - turn[-1][0] + 180) % 360 - 180  # neighbours may be out of order
        if travelled >= 360:
            yield _scan(turn, log.range_max)
            turn, travelled = [], 0.0
        if len(turn) == MOST_BEAMS:
            raise SourceError(
                f"{log.path}: expected a turn of at most {MOST_BEAMS} measurements, got more"
            )
        turn.append((angle, distance))
        got += 1
    if turn:
        yield _scan(turn, log.range_max)
    if expected is not None and got + log.skipped != expected:
        problem = f"expected {expected} measurements as #COUNT= says, got {got}; the file is cut"
        log.broken("end", problem, EOFError(problem))


def _measurement(tokens: list[str], width: int, at: int, beside: int) -> tuple[float, float]:
    if len(tokens) != width:
        raise ValueError(f"expected angle, distance and quality, got {len(tokens)} fields")
    angle, distance = float(tokens[at]), float(tokens[beside])
    float(tokens[2 if at == 0 else at - 1])  # the quality
    if not math.isfinite(angle):
        raise ValueError(f"expected a finite angle in degrees, got {angle}")
    return angle, distance


def _scan(turn: list[tuple[float, float]], range_max: float | None) -> LaserScan:
    degrees, millimetres = np.array(turn).T
    angles = math.pi - np.radians(degrees + 180) % (2 * math.pi)  # counter-clockwise
    order = np.argsort(angles, kind="stable")
    return LaserScan(
        angles=told_apart(angles[order]),
        ranges=millimetres[order] / 1000,
        range_max=range_max or math.inf,
    )
