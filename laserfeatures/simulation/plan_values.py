"""What the tables of a plan may hold."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import SHORTEST

FARTHEST = 1e6  # [m]; no number of a plan is larger
LONGEST_VALUE = 60  # characters of a wrong value that an error shows

Point = tuple[float, float]


class WrongValueError(ValueError):
    """A value is not what its key wants; the message says what it wants."""


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= FARTHEST:
        raise WrongValueError(f"a finite number up to {FARTHEST:.0f}")
    return float(value)


def _positive(value: Any) -> float:
    if _number(value) < SHORTEST:
        raise WrongValueError("a number > 0")
    return float(value)


def _share(value: Any) -> float:
    if not 0 < _number(value) <= 1:
        raise WrongValueError("a number in (0, 1]")
    return float(value)


def _whole(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value < 2**63:
        raise WrongValueError("a whole number >= 0")
    return value


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise WrongValueError("a text")
    return value


def _yes_or_no(value: Any) -> bool:
    if not isinstance(value, bool):
        raise WrongValueError("true or false")
    return value


def _point(value: Any) -> Point:
    try:
        x, y = map(_number, value if isinstance(value, list) else ())
    except ValueError:
        raise WrongValueError(f"two finite numbers [x, y] up to {FARTHEST:.0f}") from None
    return x, y


def _size(value: Any) -> Point:
    try:
        length, width = map(_positive, value if isinstance(value, list) else ())
    except ValueError:
        raise WrongValueError("two numbers > 0, [length, width]") from None
    return length, width


def _points(value: Any) -> list[Point]:
    if not isinstance(value, list):
        raise WrongValueError("points [[x, y], ...]")
    points = []
    for i, point in enumerate(value):
        try:
            points.append(_point(point))
        except WrongValueError:
            raise WrongValueError(f"points [[x, y], ...], and number {i + 1} is none") from None
    if len(points) < 2:
        raise WrongValueError("at least 2 points [[x, y], ...]")
    return points


@dataclass(frozen=True)
class Schema:
    """The keys of a table: how to convert the value of each, and which must be there."""

    keys: Mapping[str, Callable[[Any], Any]]
    needed: tuple[str, ...] = ()


WALL = Schema({"from": _point, "to": _point, "reflectivity": _share}, ("from", "to"))
OUTLINE = Schema({"points": _points, "closed": _yes_or_no, "reflectivity": _share}, ("points",))
BOX = Schema(
    {
        "center": _point, "size": _size, "heading_deg": _number, "heading_rad": _number,
        "reflectivity": _share,
    },
    ("center", "size"),
)  # fmt: skip
POLE = Schema({"center": _point, "radius": _positive, "reflectivity": _share}, ("center", "radius"))
DRIVE = Schema(
    {
        "waypoints": _points, "scanner": _text, "seed": _whole, "speed": _positive,
        "scan_rate": _positive,
    },
    ("waypoints",),
)  # fmt: skip
SCANNER = Schema({f.name: _whole if f.name == "beams" else _number for f in fields(Scanner)})


def shown(value: Any) -> str:
    """Return a wrong value as an error shows it."""
    text = repr(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + "..."
