"""Addresses of ports: ``urg:///dev/ttyACM0?skip=1`` names the driver, the port and parameters."""

import types
from dataclasses import fields
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal, Union, get_args, get_origin, get_type_hints
from urllib.parse import parse_qsl

from laserfeatures.errors import DriverError
from laserfeatures.registry import near_names

if TYPE_CHECKING:
    from laserfeatures.drivers.driver import Driver

DRIVERS = {
    "urg": ("laserfeatures.drivers.urg", "Urg"),
    "lms": ("laserfeatures.drivers.lms", "Lms"),
    "rplidar": ("laserfeatures.drivers.rplidar", "RPLidar"),
    "ld19": ("laserfeatures.drivers.ld19", "Ld19"),
}
"""The drivers by protocol: module and class."""

NOT_IN_AN_ADDRESS = {"port", "tap"}
TRUTHS = {"1": True, "true": True, "yes": True, "on": True}
TRUTHS |= {"0": False, "false": False, "no": False, "off": False}


def is_address(text: str) -> bool:
    """Return whether `text` is the address of a port: starts with a protocol and a colon."""
    scheme, colon, rest = text.partition(":")
    return bool(colon and rest) and scheme in DRIVERS


def driver_class(protocol: str) -> "type[Driver]":
    """Return the driver of a protocol.

    Raises
    ------
    DriverError
        If there is none.
    """
    if protocol not in DRIVERS:
        raise DriverError(f"there is no driver {protocol!r}; {near_names(protocol, DRIVERS)}")
    module, name = DRIVERS[protocol]
    found: type[Driver] = getattr(import_module(module), name)
    return found


def make_driver(address: str, **parameters: Any) -> "Driver":
    """Return the driver of an address, not opened.

    Parameters
    ----------
    address : str
        ``protocol://port?name=value&name=value``, such as ``urg:///dev/ttyACM0?skip=1``,
        ``lms:///dev/ttyUSB0?baud=38400`` or ``urg:socket://192.168.0.10:10940``.
    **parameters
        More parameters of the driver.

    Raises
    ------
    DriverError
        If it is no such address, or names no driver, or a parameter is unknown or makes no sense;
        the message says what would.
    """
    protocol, _, rest = address.partition(":")
    kind = driver_class(protocol)
    port, _, query = rest.partition("?")
    port = port.removeprefix("//") if port.startswith("///") else port
    if not port.strip("/"):
        raise DriverError(
            f"{address}: expected a port after {protocol}:, as in {protocol}:///dev/ttyUSB0"
        )
    typed = parse_qsl(query, keep_blank_values=True)
    try:
        given = {name: _value(kind, name, text) for name, text in typed}
        return kind(port=port, **given, **parameters)
    except (TypeError, ValueError) as error:
        raise DriverError(f"{address}: {error}") from error


def settings_of(driver: "Driver") -> dict[str, Any]:
    """Return the parameters of a driver that an address can hold, by name."""
    names = [f.name for f in fields(driver) if f.init and f.name not in NOT_IN_AN_ADDRESS]
    return {name: getattr(driver, name) for name in names}


def _value(kind: "type[Driver]", name: str, text: str) -> Any:
    known = {f.name for f in fields(kind) if f.init} - NOT_IN_AN_ADDRESS
    if name not in known:
        raise ValueError(f"there is no parameter {name!r}; {near_names(name, known)}")
    for type_ in _choices(get_type_hints(kind)[name]):
        try:
            return _parse(type_, text)
        except ValueError:
            continue
    raise ValueError(f"{name} cannot be {text!r}: expected {_expected(get_type_hints(kind)[name])}")


def _choices(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) in {Union, types.UnionType}:
        return tuple(kind for kind in get_args(hint) if kind is not type(None))
    return (hint,)


def _parse(kind: Any, text: str) -> Any:
    if get_origin(kind) is Literal:
        for choice in get_args(kind):
            if str(choice) == text:
                return choice
        raise ValueError(text)
    if kind is bool:
        if text.lower() not in TRUTHS:
            raise ValueError(text)
        return TRUTHS[text.lower()]
    return kind(text)


def _expected(hint: Any) -> str:
    names = []
    for kind in _choices(hint):
        if get_origin(kind) is Literal:
            names += [str(choice) for choice in get_args(kind)]
        else:
            names.append(
                {"int": "a whole number", "float": "a number", "bool": "0 or 1"}.get(
                    kind.__name__, kind.__name__
                )
            )
    return " or ".join(names)
