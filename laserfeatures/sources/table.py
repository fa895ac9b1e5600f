"""Plain CSV tables with a header row; metres, radians, seconds.

Wide, one scan a row: after the column `stamp` and, where there are poses, `x`, `y` and `theta`, the
header gives the direction of each beam, increasing or decreasing::

    stamp,x,y,theta,-1.5708,-1.5621,...
    12.25,0.5,1.0,0.1,3.41,3.40,...

Long, one beam a row, in any order within a scan. A new scan begins where `scan` changes, or `stamp`
where there is no `scan`; both are optional, and without them the file is one scan::

    scan,stamp,angle,range
    0,12.25,-1.5708,3.41

An empty cell, 0, nan or inf is no return; an empty stamp or pose is none. Empty lines
and lines that start with `#` are left out. A table does not say what its poses are; they count as
odometry, or as what is asked for.
"""

import csv
import math
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from laserfeatures.arrays import FloatArray, read_only
from laserfeatures.errors import SourceError
from laserfeatures.scan import FULL_TURN, LaserScan, Pose2D
from laserfeatures.sources.log import Log, Scans

WANTED = (
    "'angle,range' (scan and stamp may be added) or 'stamp,<direction of each beam in rad>' (x, y "
    "and theta may follow stamp)"
)
POSE = ["x", "y", "theta"]


def is_table(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a table with commas."""
    line = next((line for line in head.splitlines() if line and not line.startswith(b"#")), b"")
    return b"," in line and line.isascii() and line.decode().replace("\t", " ").isprintable()


def read_table(log: Log) -> Scans:
    """Yield the scans of a table.

    Raises
    ------
    SourceError
        If the header is not one of the two kinds.
    """
    layout: Layout | None = None

    def parse(line: bytes) -> LaserScan | None:
        nonlocal layout
        if not line.strip() or line.startswith(b"#"):
            return None
        cells = _cells(line)
        if layout is not None:
            return layout.add(cells)
        try:
            layout = _layout(cells, log)
        except ValueError as error:
            raise SourceError(f"{log.path}: {error}") from error
        return None

    yield from log.records(parse)
    try:
        last = layout.end() if layout else None
    except ValueError as error:
        log.broken("end", error, error)
    else:
        if last is not None:
            yield last


class Layout(Protocol):
    """How the rows of a table become scans."""

    def add(self, cells: list[str]) -> LaserScan | None:
        """Take a row; return the scan that it completes."""
        ...

    def end(self) -> LaserScan | None:
        """Return the scan that the end of the table completes."""
        ...


@dataclass
class Wide:
    """One scan a row."""

    columns: list[str]
    angles: FloatArray
    order: int  # -1 where the header's angles decrease, else 1
    range_max: float

    def add(self, cells: list[str]) -> LaserScan:
        """Return the row's scan."""
        named = len(self.columns)
        row = _row(cells, named + self.angles.size)
        values = dict(zip(self.columns, row[:named].tolist(), strict=True))
        pose = [values[name] for name in POSE if name in values]
        return LaserScan(
            angles=self.angles,
            ranges=row[named:][:: self.order],
            range_max=self.range_max,
            stamp=values.get("stamp", math.nan),
            pose=Pose2D(*pose) if pose and all(map(math.isfinite, pose)) else None,
        )

    def end(self) -> None:
        """Return None: the last row was complete."""


@dataclass
class Long:
    """One beam a row."""

    columns: list[str]
    range_max: float
    rows: list[FloatArray] = field(default_factory=list)

    def add(self, cells: list[str]) -> LaserScan | None:
        """Return the scan before this row, if the row begins another."""
        row = _row(cells, len(self.columns))
        if not math.isfinite(row[self.columns.index("angle")]):
            raise ValueError(f"expected an angle in radians, got {cells}")
        key = next((self.columns.index(n) for n in ("scan", "stamp") if n in self.columns), None)
        if key is None or not self.rows or self.rows[-1][key] == row[key]:
            self.rows.append(row)
            return None
        done, self.rows = self.rows, [row]
        return self._scan(done)

    def end(self) -> LaserScan | None:
        """Return the last scan."""
        return self._scan(self.rows) if self.rows else None

    def _scan(self, rows: list[FloatArray]) -> LaserScan:
        columns = dict(zip(self.columns, np.array(rows).T, strict=True))
        order = np.argsort(columns["angle"], kind="stable")
        return LaserScan(
            angles=columns["angle"][order],
            ranges=columns["range"][order],
            range_max=self.range_max,
            stamp=float(columns["stamp"][0]) if "stamp" in columns else math.nan,
        )


def _cells(line: bytes) -> list[str]:
    text = line.decode("utf-8-sig", "backslashreplace").rstrip("\r\n")
    try:
        return [cell.strip() for cell in next(csv.reader([text]))]
    except csv.Error as error:
        raise ValueError(f"expected cells with commas between them: {error}") from error


def _row(cells: list[str], columns: int) -> FloatArray:
    if len(cells) != columns:
        raise ValueError(f"expected {columns} cells as in the header, got {len(cells)}")
    row: FloatArray = np.array([cell or "nan" for cell in cells], dtype=np.float64)
    row.flags.writeable = False
    return row


def _layout(header: list[str], log: Log) -> Layout:
    names = [cell.lower() for cell in header]
    range_max = log.range_max or math.inf
    got = f"got {','.join(header)[:60]!r}"
    if {"angle", "range"} <= {*names} <= {"angle", "range", "scan", "stamp"}:
        return Long(names, range_max)
    named = 4 if names[1:4] == POSE else 1
    try:
        angles = np.array(header[named:], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"expected the header {WANTED}, {got}") from error
    if names[0] != "stamp":
        raise ValueError(f"expected the header {WANTED}, {got}")
    order = -1 if angles.size > 1 and angles[1] < angles[0] else 1
    angles = angles[::order]
    if not (angles.size and (np.diff(angles) > 0).all() and np.ptp(angles) <= FULL_TURN):
        raise ValueError(f"expected directions in rad, in order and within one turn, {got}")
    log.poses = (log.wanted or "odometry") if named == 4 else "none"
    return Wide(names[:named], read_only(angles, "angles", (None,)), order, range_max)
