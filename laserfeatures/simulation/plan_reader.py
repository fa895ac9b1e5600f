"""Plans from TOML files."""

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from laserfeatures.errors import SourceError
from laserfeatures.registry import near_names
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.plan import Drive, Plan
from laserfeatures.simulation.plan_values import (
    BOX,
    DRIVE,
    OUTLINE,
    POLE,
    SCANNER,
    WALL,
    Point,
    Schema,
    WrongValueError,
    shown,
)
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.toml_lines import TomlLines
from laserfeatures.simulation.world import SHORTEST, WHITE, World

LISTS = ("wall", "outline", "box", "pole")
SINGLES = ("drive", "scanner")
LARGEST = 1 << 22  # bytes; 10,000 walls take 500 kB
DEEP = re.compile(r"""([\w"'-]{1,40}[ \t]*\.[ \t]*){50}""")  # tomllib takes its time for them


def read_plan(path: str | PathLike[str]) -> Plan:
    """Return the plan that a TOML file holds: ``docs/simulation.md`` describes the format.

    Walls come in the order of the ``[[wall]]`` tables, then of the ``[[outline]]`` tables.

    Raises
    ------
    SourceError
        If the file cannot be read or makes no plan; the message names the line.
    """
    path = Path(path)
    if path.exists() and not path.is_dir() and not path.is_file():
        raise SourceError(
            f"{path}: expected a file, got a pipe or device; write it to a file first"
        )
    if path.is_file() and path.stat().st_size > LARGEST:
        raise SourceError(f"{path}: expected a plan of at most {LARGEST} bytes, got a larger file")
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise SourceError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise SourceError(f"{path}:{line}: expected UTF-8 text, got other bytes") from error
    return parse_plan(text, path)


def parse_plan(text: str, path: Path) -> Plan:
    """Return the plan that a TOML text holds, as `read_plan`; `path` is what errors call it."""
    text = text.replace("\r\n", "\n")
    deep = DEEP.search(text)
    if deep:
        line = text.count("\n", 0, deep.start()) + 1
        raise SourceError(f"{path}:{line}: expected a plan, got a key of more than 50 parts")
    try:
        tables = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # ValueError: also a number of too many digits
        found = re.search(r"at line (\d+)", str(error))
        line = int(found[1]) if found else text.rstrip("\n").count("\n") + 1
        raise SourceError(f"{path}:{line}: expected TOML, got a mistake: {error}") from error
    try:
        return _Reader(path, text).plan(tables)
    except RecursionError as error:
        raise SourceError(f"{path}: expected a plan, got values within values") from error


@dataclass(frozen=True)
class _Reader:
    path: Path
    text: str

    @cached_property
    def lines(self) -> TomlLines:
        """Where the keys stand; found when there is something to refuse."""
        return TomlLines(self.text)

    def plan(self, tables: Mapping[str, Any]) -> Plan:
        for name in tables:
            if name not in (*LISTS, *SINGLES):
                near = near_names(name, (*LISTS, *SINGLES))
                self.refuse((name,), f"a plan has no {shown(name)}; {near}")
        world, owners = self.world(tables)
        if not owners:
            self.refuse((), "a plan needs a [[wall]], [[outline]], [[box]] or [[pole]], got none")
        drive = self.drive(tables)
        for i, (x, y) in enumerate(() if drive is None else drive.waypoints):
            at = world.blocking(Pose2D(x, y, 0.0))
            if at is not None:
                self.refuse(
                    ("drive", "waypoints"),
                    f"way-point {i + 1} must be free, got ({x:.6g}, {y:.6g}), which is on or "
                    f"inside the {owners[at][0]} of line {self.lines.of(*owners[at])}",
                )
        return Plan(world=world, drive=drive, path=self.path)

    def world(self, tables: Mapping[str, Any]) -> tuple[World, list[tuple[str, int]]]:
        """Return the world, and the table that each wall, box and pole comes from."""
        walls, boxes, poles, shares, owners = [], [], [], [], []
        for i, wall in enumerate(self.tables(tables, "wall", WALL)):
            walls.append((wall["from"], wall["to"]))
            self.check_wall(*walls[-1], ("wall", i, "to"))
            shares.append(wall.get("reflectivity", WHITE))
            owners.append(("wall", i))
        for i, outline in enumerate(self.tables(tables, "outline", OUTLINE)):
            points = outline["points"]
            if outline.get("closed", True) and len(points) > 2:
                points = [*points, points[0]]
            for start, end in pairwise(points):
                self.check_wall(start, end, ("outline", i, "points"))
                walls.append((start, end))
                shares.append(outline.get("reflectivity", WHITE))
                owners.append(("outline", i))
        for i, box in enumerate(self.tables(tables, "box", BOX)):
            boxes.append((*box["center"], *box["size"], self.heading(box, i)))
            shares.append(box.get("reflectivity", WHITE))
            owners.append(("box", i))
        for i, pole in enumerate(self.tables(tables, "pole", POLE)):
            poles.append((*pole["center"], pole["radius"]))
            shares.append(pole.get("reflectivity", WHITE))
            owners.append(("pole", i))
        world = World(
            walls=np.array(walls).reshape(-1, 2, 2),
            boxes=np.array(boxes).reshape(-1, 5),
            poles=np.array(poles).reshape(-1, 3),
            reflectivity=np.array(shares),
        )
        return world, owners

    def drive(self, tables: Mapping[str, Any]) -> Drive | None:
        """Return what the drive table and the scanner table say."""
        changes = self.table(tables, "scanner", SCANNER)
        if "drive" not in tables:
            if changes is not None:
                self.refuse(("scanner",), "a [scanner] needs a [drive] to go with")
            return None
        table = self.table(tables, "drive", DRIVE) or {}
        model = table.pop("scanner", "lms200")
        if model not in Scanner.MODELS:
            near = near_names(model, Scanner.MODELS)
            self.refuse(("drive", "scanner"), f"there is no scanner {shown(model)}; {near}")
        try:
            scanner = Scanner.model(model, **(changes or {}))
        except ValueError as error:  # it begins with the parameter's name
            self.refuse(("scanner", str(error).split()[0]), str(error), error)
        points = table["waypoints"]
        for i, (here, there) in enumerate(pairwise(points), 1):
            if not math.dist(here, there) >= SHORTEST:
                problem = f"way-points {i} and {i + 1} must differ, got {list(here)} twice"
                self.refuse(("drive", "waypoints"), problem)
        return Drive(**table, scanner=scanner)

    def heading(self, box: Mapping[str, float], i: int) -> float:
        if "heading_deg" in box and "heading_rad" in box:
            self.refuse(("box", i, "heading_rad"), "give heading_deg or heading_rad, not both")
        return box.get("heading_rad", math.radians(box.get("heading_deg", 0.0)))

    def check_wall(self, start: Point, end: Point, where: tuple[str | int, ...]) -> None:
        if not math.dist(start, end) >= SHORTEST:
            self.refuse(where, f"a wall must have a length > 0, got {list(start)} as both its ends")

    def tables(self, tables: Mapping[str, Any], name: str, schema: Schema) -> list[dict[str, Any]]:
        """Return the converted tables of a list such as [[wall]]."""
        given = tables.get(name, [])
        if not isinstance(given, list) or not all(isinstance(table, dict) for table in given):
            self.refuse((name,), f"expected tables [[{name}]], got {shown(given)}")
        return [self.convert((name, i), table, schema) for i, table in enumerate(given)]

    def table(self, tables: Mapping[str, Any], name: str, schema: Schema) -> dict[str, Any] | None:
        """Return a converted table such as [drive], or None if there is none."""
        if name not in tables:
            return None
        if not isinstance(tables[name], dict):
            self.refuse((name,), f"expected one table [{name}], got {shown(tables[name])}")
        return self.convert((name,), tables[name], schema)

    def convert(
        self, where: tuple[str | int, ...], table: Mapping[str, Any], schema: Schema
    ) -> dict[str, Any]:
        converted = {}
        for key, value in table.items():
            if key not in schema.keys:
                problem = f"a {where[0]} has no {shown(key)}; {near_names(key, schema.keys)}"
                self.refuse((*where, key), problem)
            try:
                converted[key] = schema.keys[key](value)
            except WrongValueError as error:
                self.refuse((*where, key), f"{key} must be {error}, got {shown(value)}", error)
        for key in schema.needed:
            if key not in converted:
                self.refuse(where, f"a {where[0]} needs {key!r}")
        return converted

    def refuse(
        self, where: tuple[str | int, ...], problem: str, cause: Exception | None = None
    ) -> NoReturn:
        raise SourceError(f"{self.path}:{self.lines.of(*where)}: {problem}") from cause
