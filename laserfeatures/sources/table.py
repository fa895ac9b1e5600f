"""Plain tables: CSV with a header row, or columns of numbers that are named.

Wide, one scan a row: after the column `stamp` and, where there are poses, `x`, `y` and `theta`, the
header gives the direction of each beam, increasing or decreasing::

    stamp,x,y,theta,-1.5708,-1.5621,...
    12.25,0.5,1.0,0.1,3.41,3.40,...

Long, one beam a row, in any order within a scan. A new scan begins where `scan` changes, or `stamp`
where there is no `scan`; both are optional, and without them the file is one scan::

    scan,stamp,angle,range
    0,12.25,-1.5708,3.41

A column `intensity` or `quality` is passed over. Metres, radians, seconds; a header may give
others, as `angle_deg` or `range [mm]`, and so may the options `angle_unit` and `range_unit`. Angles
that span more than a turn in radians are degrees. Between cells there are commas, or semicolons,
tabs or blanks; then numbers may have decimal commas. What ``rostopic echo -p`` writes is read, too.

Without a header `columns` names them; two columns that look like angles and ranges are taken for
such, with a notice. A new scan then begins with each turn or sweep.

An empty cell, 0, nan or inf is no return; an empty stamp or pose is none. Empty lines
and lines that start with `#` are left out. A table does not say what its poses are; they count as
odometry, or as what is asked for.
"""

import csv
import math
import re

import numpy as np

from laserfeatures.arrays import read_only
from laserfeatures.errors import SourceError
from laserfeatures.scan import FULL_TURN, LaserScan
from laserfeatures.sources.files import read_head
from laserfeatures.sources.log import Log, Scans
from laserfeatures.sources.table_layouts import (
    DIRECTIONS,
    POSE,
    READ,
    Layout,
    Long,
    Wide,
    rostopic,
)
from laserfeatures.sources.text_columns import (
    delimiter_of,
    is_angle_and_range,
    rows_of,
    split_cells,
)

WANTED = (
    "'angle,range' (scan and stamp may be added) or 'stamp,<direction of each beam in rad>' (x, y "
    "and theta may follow stamp)"
)
ANGLE_UNITS = {"rad": 1.0, "deg": math.radians(1)}
RANGE_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
DELIMITERS = {",": ",", ";": ";", "tab": "\t", "space": None}
IGNORED = {"intensity", "quality", "-"}
NAMES = {*READ, *IGNORED}
WITH_UNIT = re.compile(r"(angle|range)\s*[_ \[(]\s*([a-z]+)[\])]?")
HINT = (
    "; if it has none, name them: columns= (--columns angle,range), angle_unit= (--angle-unit "
    "deg), range_unit= (--range-unit mm)"
)


def is_table(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a table."""
    line = next((line for line in head.splitlines() if line and not line.startswith(b"#")), b"")
    if not (line.isascii() and line.decode().replace("\t", " ").isprintable()):
        return False
    if b"," in line:
        return True
    text = line.decode()
    names, _ = _named(_cells(text, delimiter_of(text)))
    rows, _ = rows_of(head)
    return _is_long(names) or names[:1] == ["stamp"] or 2 <= rows.shape[-1] <= 4


def read_table(log: Log) -> Scans:
    """Yield the scans of a table.

    Raises
    ------
    SourceError
        If the header is not one of the kinds, or there is none and the columns are not named.
    """
    layout: Layout | None = None
    delimiter: str | None = None

    def parse(line: bytes) -> LaserScan | None:
        nonlocal layout, delimiter
        if not line.strip() or line.startswith(b"#"):
            return None
        text = line.decode("utf-8", "backslashreplace").rstrip("\r\n")
        if layout is not None:
            return layout.add(_cells(text, delimiter))
        delimiter = DELIMITERS[log.delimiter] if log.delimiter else delimiter_of(text)
        cells = _cells(text, delimiter)
        try:
            layout, header = _layout(cells, log)
        except ValueError as error:
            raise SourceError(f"{log.path}: {error}") from error
        return None if header else layout.add(cells)

    yield from log.records(parse)
    try:
        last = layout.end() if layout else None
    except ValueError as error:
        log.broken("end", error, error)
    else:
        if last is not None:
            yield last


def check_columns(columns: tuple[str, ...]) -> None:
    """Check the names of columns.

    Raises
    ------
    ValueError
        If a name is not known, or an angle or the range is missing or there twice.
    """
    unknown = [name for name in columns if name not in NAMES]
    twice = [name for name in READ if columns.count(name) > 1]
    directions = [name for name in columns if name in DIRECTIONS]
    if unknown or twice or len(directions) != 1 or "range" not in columns:
        raise ValueError(
            "columns must be angle (or clockwise) and range, with scan, stamp, intensity, quality "
            f"and - for others, each once; got {','.join(columns)}"
        )


def _cells(text: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return split_cells(text, None)
    try:
        cells = [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter))]
    except csv.Error as error:
        raise ValueError(f"expected cells with {delimiter!r} between them: {error}") from error
    return cells if delimiter == "," else [cell.replace(",", ".") for cell in cells]


def _named(header: list[str]) -> tuple[list[str], dict[str, str]]:
    """Return the names of a header, and the units that it gives."""
    names, units = [], {}
    for cell in header:
        name = cell.lower()
        found = WITH_UNIT.fullmatch(name)
        if found and found[2] in {*ANGLE_UNITS, *RANGE_UNITS, "degrees", "radians"}:
            name = found[1]
            units[name] = {"degrees": "deg", "radians": "rad"}.get(found[2], found[2])
        names.append(name)
    return names, units


def _is_long(names: list[str]) -> bool:
    return {"angle", "range"} <= {*names} <= NAMES and len({*names} & READ) == len(
        [name for name in names if name in READ]
    )


def _layout(cells: list[str], log: Log) -> tuple[Layout, bool]:
    """Return the layout that the first row shows, and whether that row is a header."""
    if log.columns:
        header = not all(
            _is_number(cell) for name, cell in zip(log.columns, cells, strict=False) if name in READ
        )
        return _long(log, [*log.columns], {}, turns=True), header
    names, units = _named(cells)
    if _is_long(names):
        return _long(log, names, units), True
    topic = rostopic(log, names)
    if topic is not None:
        return topic, True
    if all(_is_number(cell) for cell in cells):
        return _guessed(cells, log), False
    return _wide(cells, names, log), True


def _long(log: Log, names: list[str], units: dict[str, str], *, turns: bool = False) -> Long:
    angle = log.angle_unit or units.get("angle")
    range_ = log.range_unit or units.get("range", "m")
    if angle not in {None, *ANGLE_UNITS} or range_ not in RANGE_UNITS:
        raise ValueError(f"expected angles in rad or deg and ranges in m, cm or mm, got {units}")
    return Long(log, names, ANGLE_UNITS[angle] if angle else None, RANGE_UNITS[range_], turns=turns)


def _guessed(cells: list[str], log: Log) -> Long:
    rows, _ = rows_of(read_head(log.path))
    if not is_angle_and_range(rows):
        cloud = ", or write x, y, z as PCD or PLY" * (len(cells) == 3)
        got = f"got numbers without one, {','.join(cells)[:60]!r}"
        raise ValueError(f"expected the header {WANTED}, {got}{HINT}{cloud}")
    unit = log.angle_unit or ("deg" if np.ptp(rows[:, 0]) > FULL_TURN else "rad")
    log.notice(
        "columns",
        f"no header: taken for angles in {unit} and ranges in {log.range_unit or 'm'}; --columns, "
        "--angle-unit and --range-unit say otherwise",
    )
    return _long(log, ["angle", "range"], {"angle": unit}, turns=True)


def _wide(cells: list[str], names: list[str], log: Log) -> Wide:
    got = f"got {','.join(cells)[:60]!r}"
    named = 4 if names[1:4] == POSE else 1
    try:
        angles = np.array(cells[named:], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"expected the header {WANTED}, {got}{HINT}") from error
    if names[0] != "stamp":
        raise ValueError(f"expected the header {WANTED}, {got}{HINT}")
    angles = angles * ANGLE_UNITS[log.angle_unit or "rad"]
    order = -1 if angles.size > 1 and angles[1] < angles[0] else 1
    angles = angles[::order]
    if not (angles.size and (np.diff(angles) > 0).all() and np.ptp(angles) <= FULL_TURN):
        raise ValueError(f"expected directions in rad, in order and within one turn, {got}")
    log.poses = (log.wanted or "odometry") if named == 4 else "none"
    return Wide(
        names[:named],
        read_only(angles, "angles", (None,)),
        order,
        log.range_max or math.inf,
        RANGE_UNITS[log.range_unit or "m"],
    )


def _is_number(text: str) -> bool:
    try:
        float(text or "nan")
    except ValueError:
        return False
    return True
