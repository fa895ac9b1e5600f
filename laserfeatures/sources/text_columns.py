"""Columns of numbers without a header: which are angles and which are ranges.

A guess is held against what it implies before it is believed: angles go round one way, in steps
that a laser makes, ranges are not negative, a quality is a small whole number.
"""

from collections import Counter

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray

ROWS = 1000  # that are looked at
FEWEST = 10
FLAGS = {"true": "1", "false": "0"}
SHORTEST_MM = 50.0  # half of all distances in millimetres are beyond
LARGEST_QUALITY = 255
TRAVEL = 30.0  # [degrees] that a part of a turn must cover to be believed
UNEVEN = 3.0  # times the median step


def delimiter_of(line: str) -> str | None:
    """Return what stands between the cells of a line; None for blanks.

    ``1,5;2,5`` has semicolons and decimal commas, ``1,5 2,5`` has blanks.
    """
    for mark in ";\t":
        if mark in line:
            return mark
    cells = [cell.strip() for cell in line.split(",")]
    numbers = [cell for cell in cells if len(cell.split()) > 1 and cell.strip('"') == cell]
    blanks = any(all(_is_number(part) for part in cell.split()) for cell in numbers)
    return "," if len(cells) > 1 and not blanks else None


def split_cells(line: str, delimiter: str | None) -> list[str]:
    """Return the cells of a line of numbers, with points where there are decimal commas."""
    cells = [cell.strip() for cell in line.split(delimiter)]
    return cells if delimiter == "," else [cell.replace(",", ".") for cell in cells]


def rows_of(head: bytes) -> tuple[FloatArray, str | None]:
    """Return the numbers (N, K) of the rows in the first bytes of a file, and their delimiter.

    Lines of words, and those with another number of cells than most, are left out; there are no
    rows if more than a fifth of the lines are such.
    """
    lines = _lines(head)
    none = np.empty((0, 0))
    if not lines:
        return none, None
    delimiter = delimiter_of(lines[0])
    rows = [row for line in lines if (row := _row(split_cells(line, delimiter)))]
    if not rows:
        return none, delimiter
    columns, _ = Counter(len(row) for row in rows).most_common(1)[0]
    rows = [row for row in rows if len(row) == columns]
    return (np.array(rows) if len(rows) >= 0.8 * len(lines) else none), delimiter


def begins_with_words(head: bytes) -> bool:
    """Return whether the first row of a file is a header, of which no cell is a number."""
    lines = _lines(head)
    return bool(lines) and not any(map(_is_number, split_cells(lines[0], delimiter_of(lines[0]))))


def _lines(head: bytes) -> list[str]:
    lines = head.decode("ascii", "replace").splitlines()[: ROWS + 1]
    if len(lines) > 1 and not head.endswith(b"\n"):
        lines = lines[:-1]  # it may be cut
    return [line for line in lines if line.strip() and not line.startswith(("#", "%"))]


def _row(cells: list[str]) -> list[float]:
    try:
        return [float(FLAGS.get(cell.lower(), cell) or "nan") for cell in cells]
    except ValueError:
        return []


def _is_number(text: str) -> bool:
    return bool(_row([text.replace(",", ".")]))


def rplidar_columns(rows: FloatArray) -> tuple[int, int] | None:
    """Return which columns of rows (N, K) are an angle in degrees and a distance in millimetres.

    None where they do not fit one, and only one, of: angle, distance, quality; quality, angle,
    distance; flag of a new turn, quality, angle, distance.
    """
    if len(rows) < FEWEST:
        return None
    known: dict[int, list[tuple[int, int, int, int | None]]] = {
        3: [(0, 1, 2, None), (1, 2, 0, None)],
        4: [(2, 3, 1, 0)],
    }
    fitting = []
    for angle, distance, quality, flag in known.get(rows.shape[1], []):
        whole = _whole(rows[:, quality]) & (rows[:, quality] <= LARGEST_QUALITY)
        positive = rows[:, distance][rows[:, distance] > 0]
        if (
            _goes_round(rows[:, angle])
            and (rows[:, distance] >= 0).all()
            and positive.size
            and np.median(positive) >= SHORTEST_MM
            and whole.mean() > 0.95
            and (flag is None or np.isin(rows[:, flag], (0, 1)).all())
        ):
            fitting.append((angle, distance))
    return fitting[0] if len(fitting) == 1 else None


def _whole(values: FloatArray) -> BoolArray:
    whole: BoolArray = (values >= 0) & (values == np.round(values))
    return whole


def _goes_round(degrees: FloatArray) -> bool:
    if not (np.isfinite(degrees).all() and degrees.min() >= -360.5 and degrees.max() <= 720):
        return False
    steps = (np.diff(degrees) + 180) % 360 - 180
    steps = steps[steps != 0]
    if not steps.size:
        return False
    way = np.sign(np.median(steps))
    return bool(
        np.mean(np.sign(steps) == way) >= 0.9
        and np.median(np.abs(steps)) <= 10
        and abs(steps.sum()) >= TRAVEL
    )


def is_angle_and_range(rows: FloatArray) -> bool:
    """Return whether rows (N, 2) are directions, in nearly even steps, and ranges."""
    if len(rows) < FEWEST or rows.shape[1] != 2:
        return False
    angles, ranges = rows.T
    steps = np.diff(angles)
    steps = steps * np.sign(np.median(steps))
    seen = ranges[np.isfinite(ranges)]
    return bool(
        np.isfinite(angles).all()
        and np.ptp(angles) <= 360.5
        and (steps > 0).mean() >= 0.95
        and np.quantile(steps, 0.9) <= UNEVEN * np.median(steps)
        and (seen >= 0).all()
        and seen.any()
    )
