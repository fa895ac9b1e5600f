"""The device of ``laserfeatures emulate``: its own parameters and faults, as typed."""

from collections.abc import Mapping
from dataclasses import is_dataclass
from typing import Any, get_args, get_type_hints

import click

from laserfeatures.cli import values
from laserfeatures.emulators import FAULTS, Device, Faults, Feed
from laserfeatures.emulators.devices import device_class
from laserfeatures.registry import near_names

USUAL_RATE = 0.01
MET: Mapping[str, Mapping[str, Mapping[str, Any]]] = {
    "left_streaming": {
        "urg": {"state": "streaming"},
        "lms": {"start": "streaming"},
        "rplidar": {"start": "streaming"},
    },
    "clock_wrap": {"urg": {"clock_ms": (1 << 24) - 10_000}, "ld19": {"clock_ms": 20_000}},
}
"""Faults that are a state in which a host meets a device: left streaming by another host, a clock
that wraps ten seconds later."""

STATES = ("state", "start")  # what devices call the state in which they are found


def make_device(
    name: str,
    feed: Feed,
    *,
    model: str | None,
    state: str | None,
    faults: tuple[str, ...],
    params: tuple[str, ...],
    seed: int,
) -> Device:
    """Return an emulated device.

    Parameters
    ----------
    name : str
        One of `DEVICES`.
    feed : Feed
        What it sees.
    model, state : str or None
        Its parameters of these names.
    faults : tuple of str
        ``NAME`` or ``NAME=RATE``: faults of all devices, and those of its own.
    params : tuple of str
        ``NAME=VALUE``: other parameters of its own.
    seed : int
        Seed of the faults, and its own.

    Raises
    ------
    click.UsageError
        If something makes no sense.
    """
    kind: Any = device_class(name)
    known = get_type_hints(kind.__init__)
    for ours in ("feed", "faults", "return"):
        known.pop(ours, None)
    common, own = _split(faults)
    typed = dict(_split_assignment(text) for text in params)
    if model is not None:
        typed["model"] = model
    if state is not None:
        typed[next((word for word in STATES if word in known), "state")] = state
    options = {"seed": seed} if "seed" in known else {}
    options |= _parsed(name, typed, known) | _own_faults(name, own, known)
    try:
        made: Device = kind(feed, Faults(common, seed=seed), **options)
    except (TypeError, ValueError) as error:
        raise click.UsageError(f"{name}: {error}") from error
    return made


def _split(faults: tuple[str, ...]) -> tuple[dict[str, float], dict[str, float | None]]:
    """Return the rates of the faults that all devices have, and of the others."""
    common: dict[str, float] = {}
    own: dict[str, float | None] = {}
    for text in faults:
        name, equals, rate = text.partition("=")
        try:
            number = float(rate) if equals else None
        except ValueError:
            raise click.UsageError(
                f"--fault {name}: the rate must be a number, got {rate!r}"
            ) from None
        if name in FAULTS:
            common[name] = USUAL_RATE if number is None else number
        else:
            own[name] = number
    return common, own


def _own_faults(
    device: str, faults: Mapping[str, float | None], known: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the parameters that bring a device's own faults about."""
    options: dict[str, Any] = {}
    troubles: dict[str, float] = {}
    for name, rate in faults.items():
        if device in MET.get(name, {}):
            options |= MET[name][device]
        elif name in known:
            options[name] = _as(known[name], rate)
        elif "troubles" in known:
            troubles[name] = USUAL_RATE if rate is None else rate
            if rate is not None and "trouble_rate" in known:
                options["trouble_rate"] = rate
        else:
            own = [each for each, devices in MET.items() if device in devices]
            offers = near_names(name, [*FAULTS, *own])
            raise click.UsageError(f"--fault: {device} has no fault {name!r}; {offers}")
    return options | ({"troubles": troubles} if troubles else {})


def _as(kind: Any, rate: float | None) -> float | bool:
    if kind is bool:
        return bool(1 if rate is None else rate)
    number = USUAL_RATE if rate is None else rate
    return number if float in {kind, *get_args(kind)} else int(number)


def _split_assignment(text: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not (name and equals):
        raise click.UsageError(f"--param takes name=value, got {text!r}")
    return name, value


def _parsed(device: str, typed: Mapping[str, str], known: Mapping[str, Any]) -> dict[str, Any]:
    """Return typed parameters as their kinds; ``part.name`` is a field of a parameter's own."""
    options: dict[str, Any] = {}
    parts: dict[str, dict[str, str]] = {}
    for name, text in typed.items():
        part, dot, field = name.partition(".")
        if dot and part in known:
            parts.setdefault(part, {})[field] = text
            continue
        if name not in known:
            offers = near_names(name, known)
            raise click.UsageError(f"{device} has no parameter {name!r}; {offers}")
        try:
            options[name] = _value(text, known[name])
        except ValueError as error:
            raise click.UsageError(f"{name} {error}") from error
    for part, fields in parts.items():
        kind = next((k for k in (known[part], *get_args(known[part])) if is_dataclass(k)), None)
        if not isinstance(kind, type):
            raise click.UsageError(f"{device}: {part} has no parts")
        options[part] = kind(**_parsed(f"{device}: {part}", fields, get_type_hints(kind)))
    return options


def _value(text: str, kind: Any) -> object:
    return text.encode() if kind is bytes else values.parse(text, kind)
