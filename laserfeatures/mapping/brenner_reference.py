"""The reference of Brenner's SLAM lecture: `P ms x y`, in millimetres, without headings.

A camera overhead saw a marker on the robot; it lies 3 to 10 cm from where the walls in the scans
show the scanner to be. It is a reference for positions to a decimetre, and for nothing finer.
"""

import math
from pathlib import Path

from laserfeatures.errors import SourceError
from laserfeatures.mapping.rows import Row, read_rows
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.sources.beams import numbers
from laserfeatures.sources.brenner import scan_files
from laserfeatures.sources.brenner_motors import beside
from laserfeatures.sources.files import read_head

WORDS = ("reference", "ref")


def is_brenner_reference(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a reference."""
    tokens = head.split(b"\n", 1)[0].split()
    return len(tokens) == 4 and tokens[0] == b"P" and all(map(_is_number, tokens[1:]))


def reference_in(folder: Path) -> Path:
    """Return the reference that belongs to the scan file of a folder.

    Raises
    ------
    SourceError
        If there is none.
    """
    for scans in scan_files(folder):
        if found := beside(scans, WORDS, is_brenner_reference):
            return found
    files = [path for path in sorted(folder.iterdir()) if path.is_file() and path.stat().st_size]
    others = [path for path in files if is_brenner_reference(read_head(path))]
    if len(others) != 1:
        names = ", ".join(path.name for path in others) or "none"
        raise SourceError(f"{folder}: expected one file with records P ms x y, got {names}")
    return others[0]


def read_brenner_reference(path: Path) -> Trajectory:
    """Read such a reference; its headings are nan.

    Raises
    ------
    SourceError
        If it cannot be read, a line is broken, or there is none.
    """
    return read_rows(path, _position, "records P ms x y")


def _position(tokens: list[bytes]) -> Row:
    """Return the stamp and the position of a line.

    Raises
    ------
    ValueError
        If it does not hold them.
    """
    if len(tokens) != 4 or tokens[0] != b"P":
        raise ValueError(f"expected P, milliseconds, x and y in mm, got {len(tokens)} fields")
    stamp, x, y = (numbers(tokens[1:], "P with milliseconds, x and y in mm") / 1000).tolist()
    if not all(map(math.isfinite, (stamp, x, y))):
        raise ValueError(f"expected P with finite numbers, got {b' '.join(tokens).decode()}")
    return stamp, x, y, math.nan


def _is_number(token: bytes) -> bool:
    return token.lstrip(b"-").replace(b".", b"", 1).isdigit()
