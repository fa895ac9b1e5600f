"""Figures written as CSV, JSON and the cells of a table."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from laserfeatures.comparison.document import Table

NONE = "-"

Row = Mapping[str, Any]


def to_table(rows: Sequence[Row], text: int = 1) -> Table:
    """Return rows as a table headed by the keys of the first; `text` columns go to the left."""
    header = list(rows[0])
    cells = [[cell(row[key], key) for key in header] for row in rows]
    return Table(header, cells, frozenset(range(text)))


def cell(value: Any, name: str = "") -> str:
    """Return a value as it stands in a table; None and nan are a dash.

    A float has three digits, or if it has "percent" in its `name`, one after the point.
    """
    plain = finite(value)
    if plain is None:
        return NONE
    if not isinstance(plain, float):
        return str(plain)
    if "percent" in name:
        return f"{plain:.1f}"
    digits = 2 - math.floor(math.log10(abs(plain))) if plain else 1
    return f"{plain:.{min(max(digits, 0), 4)}f}"


def to_csv(rows: Sequence[Row]) -> str:
    """Return rows as CSV with a header; what is not known is left empty.

    A mapping in a row gives a column for each of its keys, named after both.
    """
    flat = [_flat(row) for row in rows]
    file = io.StringIO()
    writer = csv.DictWriter(file, list(flat[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(flat)
    return file.getvalue()


def to_json(value: Any) -> str:
    """Return a value as JSON, with null for what is not finite: JSON has no NaN."""
    return json.dumps(finite(value), indent=2, allow_nan=False) + "\n"


def finite(value: Any) -> Any:
    """Return a value made of plain numbers, lists and dicts, with None for what is not finite."""
    match value:
        case np.ndarray() | np.generic():
            return finite(value.tolist())
        case Mapping():
            return {key: finite(part) for key, part in value.items()}
        case list() | tuple():
            return [finite(part) for part in value]
        case float() if not math.isfinite(value):
            return None
    return value


def _flat(row: Row) -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in finite(row).items():
        if isinstance(value, dict):
            flat |= {f"{key}_{part}": inner for part, inner in _flat(value).items()}
        elif isinstance(value, list):
            flat[key] = " ".join(map(str, value))
        else:
            flat[key] = f"{value:.6g}" if isinstance(value, float) else value
    return flat
