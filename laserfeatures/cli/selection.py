"""The options that choose among what was found: --real-only, --max-sigma and --min-evidence."""

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

import click

from laserfeatures.cli import values

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

Command = TypeVar("Command", bound=Callable[..., None])

_OPTIONS = (
    click.option("--real-only", is_flag=True, help="Only real corners, no virtual ones."),
    click.option(
        "--max-sigma",
        type=values.Quantity("m"),
        metavar="LENGTH",
        help="Only corners whose standard deviation along the worst direction is no larger, such "
        "as 5cm. Else what the extractor's intersections.max_sigma says.",
    ),
    click.option(
        "--min-evidence",
        type=float,
        metavar="NATS",
        help="Only lines that have so much evidence at least, such as 15, and of their corners "
        "those that have it, too; an extractor that tells none then finds nothing. Else all.",
    ),
)


def selection_options(command: Command) -> Command:
    """Give a command the options that choose among what an extractor finds."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def selected(
    pipeline: "Pipeline", real_only: bool, max_sigma: float | None, min_evidence: float | None
) -> "Pipeline":
    """Return an extractor that finds what those options choose of what another one finds.

    Raises
    ------
    click.UsageError
        If a limit makes no sense.
    """
    from laserfeatures.cli.selective import Selective  # noqa: PLC0415 - brings numba

    try:
        return Selective.of(pipeline, real_only, max_sigma, min_evidence)
    except ValueError as error:
        raise click.UsageError(str(error)) from error
