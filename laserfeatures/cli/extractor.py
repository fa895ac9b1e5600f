"""What the commands that run an extractor share: the options, making it, running it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

import click
from click.shell_completion import CompletionItem

import laserfeatures as lf
from laserfeatures.cli import parameters, values
from laserfeatures.registry import find_factory

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

DEFAULT = "direct_hough"

Command = TypeVar("Command", bound=Callable[..., None])


def complete_names(
    _ctx: click.Context, _param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete the name of an extractor."""
    return [CompletionItem(name) for name in lf.list_extractors() if name.startswith(incomplete)]


def complete_assignments(
    ctx: click.Context, _param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete a parameter's ``name=``, of the extractor that the line names so far."""
    try:
        factory = find_factory(ctx.params.get("extractor") or DEFAULT)
        known = parameters.all_parameters(factory)
    except lf.LaserFeaturesError:
        return []  # the shell has no place for an error
    offers = {f"{name}=": parameter.meaning for name, parameter in known.items()}
    offers |= {f"{parameters.PRESET}={name}": "" for name in parameters.presets_of(factory)}
    return [
        CompletionItem(offer, help=meaning)
        for offer, meaning in offers.items()
        if offer.startswith(incomplete)
    ]


_OPTIONS = (
    click.option(
        "-e",
        "--extractor",
        metavar="NAME",
        default=DEFAULT,
        show_default=True,
        shell_complete=complete_names,
        help="One of those that 'laserfeatures extractors' lists.",
    ),
    click.option(
        "-p",
        "--param",
        "params",
        metavar="NAME=VALUE",
        multiple=True,
        shell_complete=complete_assignments,
        help=f"Set a parameter, in SI units or with one of {', '.join(values.UNITS)}: "
        "theta_step=1deg, segment_filter.max_error=3cm, preset=paper. May be repeated.",
    ),
)


def extractor_options(command: Command) -> Command:
    """Give a command the options that choose an extractor and set its parameters."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def make(name: str, assignments: tuple[str, ...]) -> "Pipeline":
    """Return an extractor with parameters as typed.

    Raises
    ------
    click.ClickException
        If a parameter is unknown or its value makes no sense.
    LaserFeaturesError
        As `get_extractor`.
    """
    try:
        return lf.get_extractor(name, **parameters.parse_assignments(name, assignments))
    except (TypeError, ValueError) as error:
        raise click.ClickException(str(error)) from error
    except (click.ClickException, lf.LaserFeaturesError):
        raise
    except Exception as error:
        raise lf.PluginError(
            f"extractor {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error


@contextmanager
def blamed(extractor: "Pipeline", index: int) -> Iterator[None]:
    """Name the extractor and scan `index` in whatever the extractor's own code raises.

    Raises
    ------
    PluginError
        If it raises.
    """
    try:
        yield
    except Exception as error:
        raise lf.PluginError(
            f"extractor {extractor.name!r} failed at scan {index}: {type(error).__name__}: {error}"
        ) from error
