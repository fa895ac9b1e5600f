"""The parameters of extractors and stages, read from their signatures and docstrings.

What a parameter is called, its default, unit and meaning are written once: in the signature and in
the numpydoc section "Parameters" of the docstring, where the unit stands in brackets.
"""

import functools
import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

import click

from laserfeatures.cli import values
from laserfeatures.registry import find_factory, near_names

PRESET = "preset"

_SECTION = re.compile(
    r"^Parameters\n-{3,}\n(.*?)(?=^\S[^\n]*\n-{3,}$|\Z)", re.MULTILINE | re.DOTALL
)
_UNIT = re.compile(r"\s*\[([a-z][^\],]*)\]", re.IGNORECASE)


@dataclass(frozen=True)
class Parameter:
    """One parameter of an extractor or a stage."""

    name: str
    kind: object
    default: object
    unit: str | None
    meaning: str

    @property
    def title(self) -> str:
        """Name and default, with the unit."""
        if self.default is inspect.Parameter.empty:
            return f"{self.name} (required)"
        return f"{self.name} = {values.describe(self.default, self.unit)}"


def parameters_of(
    factory: Callable[..., Any], defaults: Mapping[str, Any] | None = None
) -> dict[str, Parameter]:
    """Return the parameters of a factory by name; `defaults` take the place of its own.

    They come in the order of the docstring, own ones before inherited ones; what no docstring
    explains comes last.
    """
    source = factory.func if isinstance(factory, functools.partial) else factory
    documented = _documented(source)
    kinds = _annotations(source)
    defaults = defaults or {}
    found = {}
    for name, parameter in inspect.signature(factory).parameters.items():
        if parameter.kind in {parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL}:
            continue
        default = defaults.get(name, parameter.default)
        text = documented.get(name)
        unit = _UNIT.search(text or "")
        found[name] = Parameter(
            name=name,
            kind=kinds.get(name, Any),
            default=default,
            unit=None if text is None else unit[1] if unit else "",
            meaning=_UNIT.sub("", text or "", count=1),
        )
    order = [name for name in documented if name in found]
    return {name: found[name] for name in dict.fromkeys([*order, *found])}


def all_parameters(factory: Callable[..., Any]) -> dict[str, Parameter]:
    """Return the parameters of a factory and, as ``stage.name``, of the shared stages."""
    found = parameters_of(factory)
    for stage, (kind, defaults) in stages_of(factory).items():
        for parameter in parameters_of(kind, defaults).values():
            found[f"{stage}.{parameter.name}"] = parameter
    return found


def presets_of(factory: Callable[..., Any]) -> Mapping[str, Callable[..., Any]]:
    """Return the variants that an extractor offers by name."""
    presets: Mapping[str, Callable[..., Any]] = getattr(factory, "presets", {})
    return presets


def stages_of(factory: Callable[..., Any]) -> dict[str, tuple[type, Mapping[str, Any]]]:
    """Return each shared stage's class, and the defaults that the extractor asks of it."""
    from laserfeatures.pipeline import Pipeline  # noqa: PLC0415 - brings numba, listing must not

    asked: Mapping[str, Mapping[str, Any]] = getattr(factory, "stages", {})
    return {stage: (kind, asked.get(stage, {})) for stage, kind in Pipeline.STAGES.items()}


def parse_assignments(name: str, assignments: tuple[str, ...]) -> dict[str, Any]:
    """Return what `get_extractor` takes for ``name=value`` as typed after ``--param``.

    Raises
    ------
    click.ClickException
        If one is not of that form, or names no parameter, or its value does not fit; the message
        says what would.
    UnknownExtractorError, PluginError
        As `find_factory`.
    """
    typed: dict[str, str] = {}
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not (key.strip() and equals and value.strip()):
            raise click.UsageError(f"--param takes name=value, got {assignment!r}")
        typed[key.strip()] = value
    preset = typed.pop(PRESET, None)
    chosen: dict[str, Any] = {PRESET: preset}
    factory = find_factory(name, preset)
    known = all_parameters(factory)
    stages: dict[str, dict[str, Any]] = {}
    for key, text in typed.items():
        parsed = _value(name, key, text, known)
        stage, dot, field = key.partition(".")
        if dot:
            stages.setdefault(stage, {})[field] = parsed
        else:
            chosen[key] = parsed
    for stage, (kind, defaults) in stages_of(factory).items():
        if stage in stages:
            chosen[stage] = kind(**{**defaults, **stages[stage]})
    return chosen


def _value(name: str, key: str, text: str, known: Mapping[str, Parameter]) -> object:
    if key not in known:
        raise click.ClickException(
            f"{name} has no parameter {key!r}; {near_names(key, [*known, PRESET])} "
            f"('laserfeatures extractors {name}' explains them)"
        )
    parameter = known[key]
    try:
        return values.parse(text, parameter.kind, parameter.unit)
    except ValueError as error:
        raise click.ClickException(f"{key} {error}") from error


def _documented(source: Callable[..., Any]) -> dict[str, str]:
    """Return each parameter's text in the docstrings: its own first, then of what it extends."""
    found: dict[str, str] = {}
    for owner in source.__mro__ if isinstance(source, type) else [source]:
        for name, text in _section(owner.__doc__ or "").items():
            found.setdefault(name, text)
    return found


def _section(docstring: str) -> dict[str, str]:
    """Return each parameter's text in one docstring."""
    found: dict[str, str] = {}
    section = _SECTION.search(inspect.cleandoc(docstring))
    names: list[str] = []
    for line in section[1].splitlines() if section else []:
        if line[:1].strip():  # not indented: the head of an entry, "name, name : type"
            names = [name.strip() for name in line.partition(":")[0].split(",")]
            found.update(dict.fromkeys(names, ""))
        else:
            for name in names:
                found[name] = f"{found[name]} {line.strip()}".strip()
    return found


def _annotations(source: Callable[..., Any]) -> dict[str, Any]:
    try:
        return get_type_hints(source)
    except (NameError, TypeError):  # a plugin's own business: the text's form then decides
        return {}
