"""``laserfeatures extractors``: what extractors there are and what can be set."""

import functools
import inspect
from collections.abc import Callable, Iterable
from typing import Any

import click

import laserfeatures as lf
from laserfeatures.cli.extractor import complete_names
from laserfeatures.cli.parameters import Parameter, parameters_of, presets_of, stages_of
from laserfeatures.registry import find_factory


@click.command()
@click.argument("name", required=False, shell_complete=complete_names)
@click.option("--preset", help="Show the parameters of this variant of NAME.")
def extractors(name: str | None, preset: str | None) -> None:
    """List the extractors, or the parameters of NAME.

    Each parameter is listed with default, unit and meaning, as --param of the other commands
    takes it.
    """
    if name is None:
        if preset:
            raise click.UsageError("--preset needs the NAME of an extractor")
        click.echo("\n".join(lf.list_extractors()))
        return
    try:
        factory = find_factory(name, preset)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
    text = click.HelpFormatter(width=100)
    text.write_text(f"{name}{f', preset {preset}' if preset else ''}: {_summary(factory)}")
    _write_parameters(text, "Parameters", parameters_of(factory).values())
    presets = presets_of(factory)
    if presets:
        with text.section("preset=NAME"):
            text.write_dl([(key, _summary(variant)) for key, variant in presets.items()])
    for stage, (kind, defaults) in stages_of(factory).items():
        _write_parameters(
            text,
            f"{stage}.NAME: {_summary(kind)}",
            parameters_of(kind, defaults).values(),
        )
    click.echo(text.getvalue(), nl=False)


def _write_parameters(
    text: click.HelpFormatter, title: str, parameters: Iterable[Parameter]
) -> None:
    rows = [(parameter.title, parameter.meaning) for parameter in parameters]
    if rows:
        with text.section(title):
            text.write_dl(rows, col_max=44)


def _summary(factory: Callable[..., Any]) -> str:
    source = factory.func if isinstance(factory, functools.partial) else factory
    return (inspect.getdoc(source) or "no description").splitlines()[0].removesuffix(".")
