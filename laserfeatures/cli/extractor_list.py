"""Several extractors at once, as typed after ``--extractors``."""

import re
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

import laserfeatures as lf
from laserfeatures.cli import extractor as one
from laserfeatures.comparison import Failure

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

# A comma ends an extractor where a name follows; else it stands inside a value, such as 11,21.
_COMMA = re.compile(r"\s*,\s*(?=[^\W\d]\w*\s*(?:[:,]|$))")


def make_all(text: str | None) -> dict[str, "Pipeline | Failure"]:
    """Return extractors by what they were called, or why one cannot be had.

    Parameters
    ----------
    text : str or None
        Names with commas between, each with its parameters after colons:
        ``ransac,direct_hough:preset=paper:theta_step=2deg``. None stands for all extractors.

    Raises
    ------
    click.ClickException
        If a parameter is unknown or its value makes no sense, or one is named twice.
    UnknownExtractorError
        If a name is unknown; the message names the near ones.
    """
    labels = lf.list_extractors() if text is None else _COMMA.split(text.strip())
    if len(labels) > len(set(labels)):
        twice = next(label for label in labels if labels.count(label) > 1)
        raise click.UsageError(f"--extractors names {twice!r} twice")
    return {label: _make(label) for label in labels}


def complete(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    """Complete the last of the names."""
    before, comma, last = incomplete.rpartition(",")
    names = one.complete_names(ctx, param, last)
    return [CompletionItem(f"{before}{comma}{name.value}") for name in names]


def _make(label: str) -> "Pipeline | Failure":
    name, *assignments = (part.strip() for part in label.split(":"))
    try:
        return one.make(name, tuple(assignments))
    except lf.PluginError as error:
        return Failure(error=error)
    except click.ClickException as error:
        if assignments:
            raise
        return Failure(error=error)  # not even its defaults make sense: that is its own fault
