"""A map as a JSON file, and back.

::

    {"format": "laserfeatures map", "version": 1,
     "units": {"length": "m", "angle": "rad"}, "frame": "...",
     "landmarks": [
       {"kind": "corner", "x": .., "y": .., "covariance": [[..], [..]], "sightings": n},
       {"kind": "wall", "theta": .., "d": .., "covariance": [[..], [..]],
        "ends": [[x, y], [x, y]], "sightings": n}]}

A wall is the line d = x cos(theta) + y sin(theta), seen between both ends. A covariance is that of
x and y, or of theta and d. All numbers are finite.
"""

import json
from collections.abc import Iterable
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.errors import SourceError
from laserfeatures.slam import Landmark

FORMAT, VERSION = "laserfeatures map", 1
FRAME = "that of the odometry, which the map shares at the first scan; x, y, counter-clockwise"
NAMES: dict[str, tuple[str, str]] = {"corner": ("x", "y"), "wall": ("theta", "d")}


def map_json(landmarks: Iterable[Landmark], frame: str = FRAME) -> str:
    """Return a map as JSON text.

    Parameters
    ----------
    landmarks : iterable of Landmark
        The map.
    frame : str
        What its frame is, in words.

    Raises
    ------
    ValueError
        If a number is not finite.
    """
    whole = {
        "format": FORMAT,
        "version": VERSION,
        "units": {"length": "m", "angle": "rad"},
        "frame": frame,
        "landmarks": [_entry(landmark) for landmark in landmarks],
    }
    return json.dumps(whole, indent=1, allow_nan=False) + "\n"


def read_map(path: str | PathLike[str]) -> tuple[Landmark, ...]:
    """Return the landmarks of a map as `map_json` writes it.

    Raises
    ------
    SourceError
        If it cannot be read or is no such map; the message names the landmark and its field.
    """
    name = fspath(path)
    try:
        whole = json.loads(Path(path).read_text(encoding="utf-8"), parse_constant=_refuse)
    except OSError as error:
        raise SourceError(f"{name}: {error.strerror}") from error
    except ValueError as error:
        raise SourceError(f"{name}: expected a map as JSON: {error}") from error
    found = (whole.get("format"), whole.get("version")) if isinstance(whole, dict) else whole
    if found != (FORMAT, VERSION):
        raise SourceError(
            f"{name}: expected format {FORMAT!r} of version {VERSION}, got {str(found)[:60]}"
        )
    entries = whole.get("landmarks")
    if not isinstance(entries, list):
        raise SourceError(f"{name}: expected a list 'landmarks', got {str(entries)[:60]}")
    landmarks = []
    for i, entry in enumerate(entries):
        try:
            landmarks.append(_landmark(entry))
        except ValueError as error:
            raise SourceError(f"{name}: landmark {i}: {error}") from error
    return tuple(landmarks)


def _entry(landmark: Landmark) -> dict[str, Any]:
    values = zip(NAMES[landmark.kind], landmark.values.tolist(), strict=True)
    entry = {"kind": landmark.kind, **dict(values), "covariance": landmark.covariance.tolist()}
    if landmark.kind == "wall":
        entry["ends"] = landmark.ends.tolist()
    return entry | {"sightings": landmark.sightings}


def _landmark(entry: Any) -> Landmark:
    if not isinstance(entry, dict):
        raise ValueError(f"expected an object, got {str(entry)[:60]}")  # noqa: TRY004 - of a file
    kind = entry.get("kind")
    if kind not in NAMES:
        raise ValueError(f"expected kind {' or '.join(NAMES)}, got {str(kind)[:60]}")
    values = np.array([float(_numbers(entry, name, ())) for name in NAMES[kind]])
    sightings = _numbers(entry, "sightings", ())
    if not (sightings >= 1 and float(sightings).is_integer()):
        raise ValueError(f"expected sightings, a whole number of 1 or more, got {sightings}")
    return Landmark(
        kind=kind,
        values=values,
        covariance=_numbers(entry, "covariance", (2, 2)),
        ends=_numbers(entry, "ends", (2, 2)) if kind == "wall" else np.tile(values, (2, 1)),
        sightings=int(sightings),
    )


def _numbers(entry: dict[str, Any], name: str, shape: tuple[int, ...]) -> FloatArray:
    """Return the numbers of a field as an array of that shape."""
    try:
        numbers: FloatArray = np.array(entry[name], dtype=float)
    except KeyError as error:
        raise ValueError(f"expected a field {name!r}, got {', '.join(entry)}") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"expected numbers as {name}, got {str(entry[name])[:60]}") from error
    if numbers.shape != shape or not np.isfinite(numbers).all():
        what = "2 x 2 finite numbers" if shape else "a finite number"
        raise ValueError(f"expected {what} as {name}, got {str(entry[name])[:60]}")
    return numbers


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is no JSON number")
