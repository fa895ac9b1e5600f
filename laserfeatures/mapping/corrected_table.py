"""Tables of corrected poses: CSV with columns `t`, `corr_x`, `corr_y`, `corr_th` among others.

Seconds, metres and radians. So the table is laid out that has the odometry of the CSAIL run beside
its corrected poses.
"""

from pathlib import Path

from laserfeatures.mapping.rows import Row, read_rows
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.sources.beams import numbers

COLUMNS = (b"t", b"corr_x", b"corr_y", b"corr_th")


def is_corrected_table(head: bytes) -> bool:
    """Return whether a file that starts with `head` is such a table."""
    lines = (line for line in head.splitlines() if line.strip() and not line.startswith(b"#"))
    return set(COLUMNS) <= set(next(lines, b"").strip().split(b","))


def read_corrected_table(path: Path) -> Trajectory:
    """Read such a table.

    Raises
    ------
    SourceError
        If it cannot be read, a row is broken, or there is none.
    """
    header: list[bytes] = []

    def parse(words: list[bytes]) -> Row | None:
        cells = b" ".join(words).split(b",")
        if not header:
            header.extend(cells)
            return None
        if len(cells) != len(header):
            raise ValueError(f"expected {len(header)} cells as in the header, got {len(cells)}")
        row = [cells[header.index(name)] for name in COLUMNS]
        stamp, x, y, theta = numbers(row, "numbers as t, corr_x, corr_y and corr_th").tolist()
        return stamp, x, y, theta

    return read_rows(path, parse, "rows of poses")
