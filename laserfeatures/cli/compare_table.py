"""A comparison as tables for a terminal."""

import textwrap
from collections.abc import Iterable, Iterator

import click

from laserfeatures.comparison import Comparison, Run
from laserfeatures.comparison.tables import agreement_rows, cells

WIDTH = 100  # columns
GAP = "  "


def print_tables(comparison: Comparison, source: str, scans: int) -> None:
    """Print what was measured, and the agreement where there are two to agree."""
    lines = [*_results(comparison), *_legend(comparison, source, scans)]
    if len(comparison.runs) > 1:
        lines += ["", *_agreement(comparison)]
    for line in lines:
        click.echo(line.rstrip())


def _results(comparison: Comparison) -> Iterator[str]:
    shown = {
        name: cells(run, comparison.repeatability[name]) for name, run in comparison.runs.items()
    }
    header = next(iter(shown.values())).keys()
    widths = [max(len(head), *(len(row[head]) for row in shown.values())) for head in header]
    names = _numbered(comparison)
    head = _aligned(header, widths)
    width = _width(names.values(), head)
    yield from _row("  extractor", width, [head])
    for key, outcome in comparison.outcomes.items():
        if isinstance(outcome, Run):
            yield from _row(names[key], width, [_aligned(shown[key].values(), widths)])
        else:
            text = textwrap.wrap(str(outcome), WIDTH - width - len(GAP))
            yield from _row(names[key], width, text)


def _legend(comparison: Comparison, source: str, scans: int) -> list[str]:
    again = (
        "again: share of the corners in the next scan's view (so many were judged) that are found "
        f"there within {comparison.tolerance:g} m; in sight: of those that nothing hides."
        if comparison.posed
        else "again, in sight: not known, since no two scans in a row have poses."
    )
    return textwrap.wrap(
        f"{source}: {scans} scan{'s' * (scans > 1)}. median, p99: time of a scan [us]; lines, "
        f"corners, real corners: mean a scan; blind: scans without a corner; {again}",
        WIDTH,
    )


def _agreement(comparison: Comparison) -> Iterator[str]:
    yield f"Share of the row's corners that the column has within {comparison.tolerance:g} m:"
    every = _numbered(comparison)
    names = [every[key] for key in comparison.runs]
    widths = [4] * len(names)
    head = _aligned([name.split()[0] for name in names], widths)
    width = _width(names, head)
    yield from _row("", width, [head])
    for name, row in zip(names, agreement_rows(comparison), strict=True):
        yield from _row(name, width, [_aligned(row, widths)])


def _numbered(comparison: Comparison) -> dict[str, str]:
    """Return each name with a number, which stands for it where names have no place."""
    return {name: f"{i} {name}" for i, name in enumerate(comparison.outcomes, 1)}


def _width(names: Iterable[str], beside: str) -> int:
    """Return the columns for names beside such text; a longer one gets a line of its own."""
    room = WIDTH - len(GAP) - len(beside)
    return max((len(name) for name in names if len(name) <= room), default=room)


def _row(name: str, width: int, texts: list[str]) -> Iterator[str]:
    """Yield the lines of a row: a name, and beside it, or below if it is long, some text."""
    if len(name) > width:
        yield name
        name = ""
    for text in texts:
        yield f"{name:<{width}}{GAP}{text}"
        name = ""


def _aligned(texts: Iterable[str], widths: Iterable[int]) -> str:
    return GAP.join(f"{text:>{width}}" for text, width in zip(texts, widths, strict=True))
