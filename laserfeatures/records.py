"""Features as plain records, to be written as JSON or CSV."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from laserfeatures.data import Features

_SCAN = ("index", "stamp", "id")
COLUMNS = {
    "lines": (*_SCAN, "theta", "d", "support", "evidence"),
    "segments": (*_SCAN, "line", "x1", "y1", "x2", "y2", "support", "rms"),
    "corners": (
        *(*_SCAN, "x", "y", "line_1", "line_2", "angle", "real"),
        *("cov_xx", "cov_xy", "cov_yy", "evidence"),
    ),
}
"""The columns of the table of each kind that `to_rows` gives."""


def to_record(features: Features, index: int | None = None) -> dict[str, Any]:
    """Return features as a dictionary of plain Python values that JSON can hold.

    Parameters
    ----------
    features : Features
        What an extractor found in one scan.
    index : int, optional
        Number of the scan in its log, from 0.

    Returns
    -------
    dict
        ``{"index", "stamp", "lines": [{"theta", "d", "support", "evidence"}], "segments": [{"line",
        "x1", "y1", "x2", "y2", "support", "rms"}], "corners": [{"x", "y", "lines": [i, j], "angle",
        "real", "cov": [[..], [..]], "evidence"}]}``: metres, radians, seconds and nats in the
        sensor's frame; "line" and "lines" count in this record's lines; a corner that was found
        without lines has None there. None stands for what is not finite, too, such as the stamp of
        a log without stamps.
    """
    lines, segments, corners = features.lines, features.segments, features.corners
    x1, y1, x2, y2 = segments.endpoints.reshape(-1, 4).T
    x, y = corners.positions.T
    return {
        "index": index,
        "stamp": features.scan.stamp if math.isfinite(features.scan.stamp) else None,
        "lines": _dicts(
            theta=lines.theta,
            d=lines.d,
            support=_counts(lines.support),
            evidence=lines.evidence,
        ),
        "segments": _dicts(
            line=segments.line,
            x1=x1,
            y1=y1,
            x2=x2,
            y2=y2,
            support=_counts(segments.support),
            rms=segments.rms,
        ),
        "corners": _dicts(
            x=x,
            y=y,
            lines=_pairs(corners.lines),
            angle=corners.angles,
            real=corners.real,
            cov=corners.covariance,
            evidence=corners.evidence,
        ),
    }


def to_rows(record: dict[str, Any], kind: str) -> Iterator[dict[str, Any]]:
    """Yield the rows of a table of lines, of segments or of corners: a row for each.

    Parameters
    ----------
    record : dict
        As `to_record` returns it.
    kind : {"lines", "segments", "corners"}
        What the rows are.

    Yields
    ------
    dict
        The `COLUMNS` of that kind. "id" counts within scan and kind; "line", "line_1" and "line_2"
        are the ids of lines of the same scan, None for a corner that was found without lines.
    """
    scan = {"index": record["index"], "stamp": record["stamp"]}
    for i, item in enumerate(record[kind]):
        row = {**scan, "id": i, **item}
        if kind == "corners":
            row["line_1"], row["line_2"] = row.pop("lines") or (None, None)
            (row["cov_xx"], row["cov_xy"]), (_, row["cov_yy"]) = row.pop("cov")
        yield row


def _counts(support: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.rint(support).astype(np.int64)  # a number of points reads as 23, not 23.0


def _pairs(lines: NDArray[np.int64]) -> list[list[int] | None]:
    return [None if min(pair) < 0 else pair for pair in lines.tolist()]


def _dicts(**columns: NDArray[Any] | list[Any]) -> list[dict[str, Any]]:
    rows = zip(
        *(column if isinstance(column, list) else _finite(column) for column in columns.values()),
        strict=True,
    )
    return [dict(zip(columns, row, strict=True)) for row in rows]


def _finite(column: NDArray[Any]) -> list[Any]:
    known = np.isfinite(column)
    if not known.all():
        column = column.astype(object)
        column[~known] = None
    items: list[Any] = column.tolist()
    return items
