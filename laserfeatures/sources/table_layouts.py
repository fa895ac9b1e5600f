"""How the rows of a table become scans: one scan a row, one beam a row, or ROS's own columns."""

import math
import re
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.errors import SourceError
from laserfeatures.scan import LaserScan, Pose2D
from laserfeatures.sources.beams import contradiction, even_scan, told_apart
from laserfeatures.sources.files import MOST_BEAMS
from laserfeatures.sources.log import Log

POSE = ["x", "y", "theta"]
DIRECTIONS = {"angle": 1, "clockwise": -1}
TOO_MANY = f"expected at most {MOST_BEAMS} beams a scan, got more"
READ = {*DIRECTIONS, "range", "scan", "stamp"}
TURN = 2 * math.pi
WRAP = math.radians(300)  # a step this long goes on where the circle begins again


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
    range_scale: float = 1.0  # [m]

    def add(self, cells: list[str]) -> LaserScan:
        """Return the row's scan."""
        named = len(self.columns)
        row = numbers_of(cells, named + self.angles.size)
        values = dict(zip(self.columns, row[:named].tolist(), strict=True))
        pose = [values[name] for name in POSE if name in values]
        return LaserScan(
            angles=self.angles,
            ranges=row[named:][:: self.order] * self.range_scale,
            range_max=self.range_max,
            stamp=values.get("stamp", math.nan),
            pose=Pose2D(*pose) if pose and all(map(math.isfinite, pose)) else None,
        )

    def end(self) -> None:
        """Return None: the last row was complete."""


@dataclass
class Long:
    """One beam a row.

    Parameters
    ----------
    log : Log
        What is guessed is told there.
    columns : list of str
        Their names; other names than those in `READ` are passed over.
    angle_unit : float or None
        [rad]; None: radians, or degrees where radians would be more than a turn.
    range_unit : float
        [m]
    turns : bool
        Whether the rows are in order, and a scan ends with its turn or sweep where no column says.
    """

    log: Log
    columns: list[str]
    angle_unit: float | None = None
    range_unit: float = 1.0
    turns: bool = False
    rows: list[FloatArray] = field(default_factory=list)
    _travelled: float = 0.0
    _wrapped: bool = False

    def __post_init__(self) -> None:
        """Find the columns."""
        self._read = [i for i, name in enumerate(self.columns) if name in READ]
        names = [self.columns[i] for i in self._read]
        self._direction = next(name for name in names if name in DIRECTIONS)
        self._angle = names.index(self._direction)
        self._names = names
        self._key = next((names.index(n) for n in ("scan", "stamp") if n in names), None)

    def add(self, cells: list[str]) -> LaserScan | None:
        """Return the scan before this row, if the row begins another."""
        if len(cells) != len(self.columns):
            raise ValueError(
                f"expected {len(self.columns)} cells as in the header, got {len(cells)}"
            )
        row = numbers_of([cells[i] for i in self._read], len(self._read))
        if not math.isfinite(row[self._angle]):
            raise ValueError(f"expected an angle in radians or degrees, got {cells}")
        if not self.rows or not self._begins(row):
            if len(self.rows) == MOST_BEAMS:
                raise SourceError(f"{self.log.path}: {TOO_MANY}")
            self.rows.append(row)
            return None
        done, self.rows = self.rows, [row]
        return self._scan(done)

    def end(self) -> LaserScan | None:
        """Return the last scan."""
        return self._scan(self.rows) if self.rows else None

    def _begins(self, row: FloatArray) -> bool:
        """Return whether a row begins another scan."""
        if self._key is not None:
            return bool(self.rows[-1][self._key] != row[self._key])
        if not self.turns:
            return False
        step = float(row[self._angle] - self.rows[-1][self._angle]) * (self.angle_unit or 1.0)
        wraps = abs(step) > WRAP
        back = step * self._travelled < 0 and abs(step) > abs(self._travelled) / 2 and not wraps
        self._wrapped |= wraps
        self._travelled += (step + math.pi) % TURN - math.pi
        ends = (back and len(self.rows) > 2) or (
            self._wrapped and abs(self._travelled) >= TURN * (1 - 1e-6)
        )
        if ends:
            self._travelled, self._wrapped = 0.0, False
        return ends

    def _scan(self, rows: list[FloatArray]) -> LaserScan:
        columns = dict(zip(self._names, np.array(rows).T, strict=True))
        given = columns[self._direction]
        if self.angle_unit is None:
            self.angle_unit = self._unit_of(given)
        angles = given * (self.angle_unit * DIRECTIONS[self._direction])
        order = np.argsort(angles, kind="stable")
        angles = angles[order]
        return LaserScan(
            angles=told_apart(angles) if self.turns else angles,
            ranges=columns["range"][order] * self.range_unit,
            range_max=self.log.range_max or math.inf,
            stamp=float(columns["stamp"][0]) if "stamp" in columns else math.nan,
        )

    def _unit_of(self, angles: FloatArray) -> float:
        low, high = np.quantile(angles, (0.1, 0.9))  # a few may be damaged
        if high - low <= TURN:
            return 1.0
        self.log.notice("angles", "the angles span more than a turn in radians: taken for degrees")
        return math.radians(1)


@dataclass
class Rostopic:
    """One message a row, as ``rostopic echo -p`` writes them."""

    log: Log
    places: dict[str, int]
    ranges: list[int]
    count: int

    def add(self, cells: list[str]) -> LaserScan:
        """Return the row's scan."""
        if len(cells) != self.count:
            raise ValueError(f"expected {self.count} cells as in the header, got {len(cells)}")
        values = {name: float(cells[at]) for name, at in self.places.items()}
        ranges = numbers_of([cells[at] for at in self.ranges], len(self.ranges))
        first, step = values["angle_min"], values["angle_increment"]
        said = contradiction(first, step, ranges.size, values.get("angle_max", math.nan))
        if said:
            self.log.notice("angle_max", said)
        stated = values.get("range_max", math.inf)
        return even_scan(
            ranges,
            first,
            step,
            range_min=max(values.get("range_min", 0.0), 0.0),
            range_max=self.log.range_max or (stated if stated > 0 else math.inf),
            stamp=(values.get("stamp") or values.get("%time", math.nan)) / 1e9,
        )

    def end(self) -> None:
        """Return None: the last row was complete."""


def rostopic(log: Log, names: list[str]) -> Rostopic | None:
    """Return the layout of a header of ``rostopic echo -p``, None if it is none."""
    last = [name.rpartition(".")[2] for name in names]
    ranges = [i for i, name in enumerate(last) if re.fullmatch(r"ranges\d+", name)]
    wanted = ("%time", "stamp", "angle_min", "angle_max", "angle_increment")
    places = {
        name: last.index(name) for name in (*wanted, "range_min", "range_max") if name in last
    }
    if not ranges or not {"angle_min", "angle_increment"} <= places.keys():
        return None
    return Rostopic(log, places, ranges, len(names))


def numbers_of(cells: list[str], count: int) -> FloatArray:
    """Return cells as numbers; an empty one is nan.

    Raises
    ------
    ValueError
        If they are not `count`, or one is no number.
    """
    if len(cells) != count:
        raise ValueError(f"expected {count} cells as in the header, got {len(cells)}")
    row: FloatArray = np.array([cell or "nan" for cell in cells], dtype=np.float64)
    row.flags.writeable = False
    return row
