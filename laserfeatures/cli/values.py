"""Values as people type them: numbers with units, pairs, intervals, names."""

import math
import re
import types
from collections.abc import Callable
from typing import Any, Literal, Union, get_args, get_origin

import click

UNITS: dict[str, tuple[str, Callable[[float], float]]] = {
    "rad": ("angle", float),
    "deg": ("angle", math.radians),
    "m": ("length", float),
    "cm": ("length", lambda value: value / 100),
    "mm": ("length", lambda value: value / 1000),
    "s": ("time", float),
    "ms": ("time", lambda value: value / 1000),
}
"""The dimension of each unit, and how to come from it to the SI unit."""

BOOLEANS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}

_QUANTITY = re.compile(
    r"([+-]?(?:(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?|inf))\s*([a-z°µ%]*)", re.IGNORECASE
)


def parse(text: str, kind: object, unit: str | None = None) -> object:
    """Return `text` as a value of type `kind` in SI units.

    Parameters
    ----------
    text : str
        ``0.02``, ``2cm``, ``true``, ``none``, ``11,21`` or a name.
    kind : type
        The annotation of the parameter: bool, int, float, str, a tuple, a Literal or a union of
        those. With any other, the text's own form decides.
    unit : str, optional
        The SI unit that the parameter is documented in; None where it is not documented.

    Raises
    ------
    ValueError
        If the text is no such value. The message follows the parameter's name:
        "must be a number [m], got 'abc'".
    """
    text = text.strip()
    origin = get_origin(kind)
    if origin in {Union, types.UnionType}:
        return _parse_union(text, get_args(kind), unit)
    if origin is tuple:
        return _parse_tuple(text, get_args(kind), unit)
    if origin is Literal or kind is bool:
        choices = BOOLEANS if kind is bool else {str(name): name for name in get_args(kind)}
        if text.lower() not in choices:
            raise ValueError(f"must be one of {', '.join(choices)}, got {text!r}")
        return choices[text.lower()]
    if kind is int or kind is float:
        return _parse_number(text, kind, unit)
    return text if kind is str else _parse_anything(text, unit)


def describe(value: object, unit: str | None) -> str:
    """Return a value as text with its unit, angles in degrees as well."""
    if isinstance(value, tuple):
        return ",".join(describe(item, None) for item in value) + (f" {unit}" if unit else "")
    if value is None:
        return f"none [{unit}]" if unit else "none"
    if isinstance(value, bool):
        return str(value).lower()
    if not isinstance(value, int | float):
        return str(value)
    text = f"{value:.6g} {unit or ''}".rstrip()
    return f"{text} ({math.degrees(value):.4g} deg)" if unit == "rad" and value else text


class Quantity(click.ParamType[float]):
    """An option's type: a number with a unit of the same dimension as the SI unit `unit`."""

    def __init__(self, unit: str) -> None:
        self.unit = unit
        self.name = UNITS[unit][0]

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number in the SI unit."""
        try:
            return float(_parse_number(str(value), float, self.unit))
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Pair(click.ParamType[tuple[float, float]]):
    """An option's type: two numbers, each as of `Quantity`, with `between` between them."""

    def __init__(self, unit: str, between: str) -> None:
        self.unit = unit
        self.between = between
        self.name = f"two of {UNITS[unit][0]}"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float]:
        """Return both numbers in the SI unit."""
        ends = str(value).split(self.between)
        if len(ends) != 2:
            example = f"0.3{self.unit}{self.between}0.5{self.unit}"
            self.fail(f"must be two numbers as in {example}, got {value!r}", param, ctx)
        try:
            first, second = (float(_parse_number(end.strip(), float, self.unit)) for end in ends)
        except ValueError as error:
            self.fail(str(error), param, ctx)
        return first, second


class QuantityOrPair(click.ParamType[float | tuple[float, float]]):
    """An option's type: a number as of `Quantity`, or two with ".." between them."""

    def __init__(self, unit: str) -> None:
        self._one, self._two = Quantity(unit), Pair(unit, "..")
        self.name = f"{self._one.name}, or two of them"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | tuple[float, float]:
        """Return the number or both in the SI unit."""
        kind = self._two if ".." in str(value) else self._one
        return kind.convert(value, param, ctx)


def _parse_union(text: str, kinds: tuple[Any, ...], unit: str | None) -> object:
    if types.NoneType in kinds and text.lower() == "none":
        return None
    reasons = []
    for kind in kinds:
        if kind is not types.NoneType:
            try:
                return parse(text, kind, unit)
            except ValueError as error:
                reasons.append(error)
    raise reasons[0]


def _parse_tuple(text: str, kinds: tuple[Any, ...], unit: str | None) -> tuple[Any, ...]:
    parts = text.split(",")
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(parts)
    if len(parts) != len(kinds):
        raise ValueError(f"must be {len(kinds)} values with commas between, got {text!r}")
    return tuple(parse(part, kind, unit) for part, kind in zip(parts, kinds, strict=True))


def _parse_number(text: str, kind: type[int | float], unit: str | None) -> int | float:
    match = _QUANTITY.fullmatch(text)
    if not match:
        raise ValueError(f"must be a number{f' [{unit}]' if unit else ''}, got {text!r}")
    number = float(match[1])
    if match[2]:
        number = _to_si(number, match[2], unit, text)
    if kind is int:
        if not number.is_integer():
            raise ValueError(f"must be a whole number, got {text!r}")
        return int(number)
    return number


def _to_si(number: float, typed: str, unit: str | None, text: str) -> float:
    if typed not in UNITS:
        raise ValueError(f"has no unit {typed!r} (in {text!r}); there are: {', '.join(UNITS)}")
    dimension, convert = UNITS[typed]
    if unit is not None:  # None is an undocumented parameter: whoever types the unit must know
        wanted = UNITS[unit][0] if unit in UNITS else ""
        if dimension != wanted:
            article = "an" if wanted == "angle" else "a"
            what = f"{article} {wanted} [{unit}]" if wanted else "a number without a unit"
            article = "an" if dimension == "angle" else "a"
            raise ValueError(f"is {what}, got the {dimension} {text!r}")
    return convert(number)


def _parse_anything(text: str, unit: str | None) -> object:
    if text.lower() == "none":
        return None
    if text.lower() in BOOLEANS:
        return BOOLEANS[text.lower()]
    if "," in text:
        return tuple(_parse_anything(part.strip(), unit) for part in text.split(","))
    match = _QUANTITY.fullmatch(text)
    if not match:
        return text
    whole = match[1].lstrip("+-").isdigit() and not match[2]
    return _parse_number(text, int if whole else float, unit)
