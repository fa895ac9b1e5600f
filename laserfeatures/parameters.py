"""What all parameters of extractors and stages are checked for alike: their types."""

import re
from dataclasses import fields
from numbers import Integral, Real
from typing import Any

import numpy as np

_NAMED: dict[Any, Any] = {
    "int": int, "bool": bool, "float": float, "float | None": float | None,
    "Optional[float]": float | None,
}  # fmt: skip
BITS = 31  # of a whole number, unless its field's metadata tell other "bits": OpenCV takes no more


def settle(owner: Any) -> None:
    """Check the fields of a dataclass by their annotations, and make them Python's own numbers.

    So kernels are compiled for no other types, and NumPy's unsigned numbers cannot wrap. Fields of
    any other type are the owner's business, and so are limits: they are checked next.

    Raises
    ------
    ValueError
        If a field is no whole number, no number, or neither true nor false, as it is to be.
    """
    for field in fields(owner):
        value = getattr(owner, field.name)
        kind = _NAMED.get(field.type, field.type)  # a name after "from __future__ import .."
        if kind is int:
            value = whole(field.name, value, field.metadata.get("bits", BITS))
        elif kind is bool:
            value = _truth(field.name, value)
        elif kind is float or (kind == float | None and value is not None):
            value = _number(field.name, value, owner)
        object.__setattr__(owner, field.name, value)  # it may be frozen


def is_whole(value: object, bits: int = BITS) -> bool:
    """Tell whether a value is a whole number of less than 2**bits; True and False are none."""
    return not isinstance(value, bool) and isinstance(value, Integral) and int(value) < 2**bits


def whole(name: str, value: Any, bits: int = BITS) -> int:
    """Return a parameter as an int.

    Raises
    ------
    ValueError
        If it is no whole number, or too large.
    """
    if not is_whole(value, bits):
        raise ValueError(f"{name} must be a whole number under 2**{bits}, got {value!r}")
    return int(value)


def number(name: str, value: Any, owner: Any) -> float:
    """Return a number of what has been measured, such as a scan's range limit, as a float.

    Raises
    ------
    ValueError
        If it is none.
    """
    if type(value) is float:  # most are: that is quick
        return value
    if isinstance(value, np.ndarray) and not value.ndim:  # out of a file of NumPy's
        value = value[()]
    return _number(name, value, owner)


def _number(name: str, value: Any, owner: Any) -> float:
    if not isinstance(value, bool) and isinstance(value, Real):
        try:
            return float(value)
        except OverflowError:  # of an int of more digits than a float holds
            pass
    raise ValueError(f"{name} must be a number{_unit(owner, name)}, got {value!r}")


def _unit(owner: Any, name: str) -> str:
    """Return a parameter's unit as its docstring tells it, " [rad]", or nothing."""
    for kind in type(owner).__mro__:
        entry = re.search(
            rf"^( *)(?:\w+, )*{re.escape(name)}(?:, \w+)* :.*\n((?:\1 +\S.*\n)+)",
            kind.__doc__ or "",
            re.MULTILINE,
        )
        if entry:
            unit = re.search(r"\[[a-zA-Z][^\],]*\]", " ".join(entry[2].split()))
            return f" {unit[0]}" if unit else ""
    return ""


def _truth(name: str, value: Any) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise ValueError(f"{name} must be True or False, got {value!r}")
