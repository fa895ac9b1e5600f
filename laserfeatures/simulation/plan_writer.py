"""Plans to TOML files."""

import json
import math
from dataclasses import asdict
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from laserfeatures.errors import SourceError
from laserfeatures.simulation.plan import Drive, Plan
from laserfeatures.simulation.plan_reader import parse_plan
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import WHITE, World


def write_plan(world: World, path: str | PathLike[str], drive: Drive | None = None) -> None:
    """Write a world, and the drive through it, as a TOML file; `read_plan` gives the same back.

    Raises
    ------
    ValueError
        If the file would not be read back: the world is empty or too large, or a way-point is on a
        surface, or inside a box or pole.
    OSError
        If the file cannot be written.
    """
    Plan(world=world, drive=drive)  # checks the way-points
    text = "\n".join(_table(header, keys) for header, keys in [*_objects(world), *_drive(drive)])
    try:
        parse_plan(text, Path(path))
    except SourceError as error:
        raise ValueError(f"this is no plan that can be read again: {error}") from error
    Path(path).write_text(text)


def _objects(world: World) -> list[tuple[str, dict[str, Any]]]:
    tables = [("[[wall]]", {"from": start, "to": end}) for start, end in world.walls.tolist()]
    for x, y, length, width, heading in world.boxes.tolist():
        tables.append(("[[box]]", {"center": [x, y], "size": [length, width], **_angle(heading)}))
    for x, y, radius in world.poles.tolist():
        tables.append(("[[pole]]", {"center": [x, y], "radius": radius}))
    for (_, keys), share in zip(tables, np.asarray(world.reflectivity).tolist(), strict=True):
        if share != WHITE:
            keys["reflectivity"] = share
    return tables


def _angle(heading: float) -> dict[str, float]:
    """Return a heading in degrees, or in radians if that would not give the same back."""
    degrees = math.degrees(heading)
    if math.radians(degrees) == heading:
        return {"heading_deg": degrees}
    return {"heading_rad": heading}


def _drive(drive: Drive | None) -> list[tuple[str, dict[str, Any]]]:
    if drive is None:
        return []
    changes = {name: _changes(drive.scanner, name) for name in Scanner.MODELS}
    model = min(changes, key=lambda name: len(changes[name]))
    keys = {
        "waypoints": drive.waypoints.tolist(),
        "scanner": model,
        "seed": drive.seed,
        "speed": drive.speed,
        "scan_rate": drive.scan_rate,
    }
    return [("[drive]", keys), *([("[scanner]", changes[model])] if changes[model] else [])]


def _changes(scanner: Scanner, model: str) -> dict[str, Any]:
    base = asdict(Scanner.model(model))
    return {name: value for name, value in asdict(scanner).items() if value != base[name]}


def _table(header: str, keys: dict[str, Any]) -> str:
    # JSON's texts, numbers and lists are TOML's, but for infinity; an int of NumPy needs a hint.
    values = {key: json.dumps(value, default=int) for key, value in keys.items()}
    lines = [f"{key} = {value.replace('Infinity', 'inf')}" for key, value in values.items()]
    return "\n".join([header, *lines, ""])
