"""A page of the testbench on a terminal."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest

import click

from laserfeatures.comparison.document import Heading, Table
from laserfeatures.testbench.pages import Page

WIDTH = 100  # columns of a terminal
GAP = "  "


def print_page(page: Page) -> None:
    """Print the title of a page, its headings and tables; the text is in its file.

    A table that is wider than a terminal goes on below, with the names of its rows again.
    """
    click.echo(page.document.title)
    for block in page.document.blocks:
        if isinstance(block, Heading):
            click.echo(f"\n{block.text}")
        elif isinstance(block, Table):
            click.echo("\n\n".join("\n".join(_aligned(part)) for part in _parts(block)))
    click.echo()


def _parts(table: Table) -> Iterator[Table]:
    """Yield tables that are no wider than a terminal, each with the columns of text."""
    widths = _widths(_rows(table))
    named = sorted(table.text)
    room = WIDTH - sum(widths[column] + len(GAP) for column in named) + len(GAP)
    columns, used = list(named), 0
    for column in range(len(widths)):
        if column in table.text:
            continue
        needed = widths[column] + len(GAP)
        if used + needed > room and columns != named:
            yield _part(table, columns)
            columns, used = list(named), 0
        columns.append(column)
        used += needed
    yield _part(table, columns)


def _part(table: Table, columns: list[int]) -> Table:
    """Return a table of those columns, in their old order."""
    columns = sorted(columns)
    return Table(
        [table.header[column] for column in columns],
        [[row[column] for column in columns] for row in table.rows],
        frozenset(columns.index(column) for column in table.text),
    )


def _rows(table: Table) -> list[Sequence[str]]:
    """Return the rows of a table; each word of the header has a line of its own."""
    heads = [head.split() for head in table.header]
    words = [list(row) for row in zip_longest(*heads, fillvalue="")]
    return [*words, *table.rows]


def _widths(rows: list[Sequence[str]]) -> list[int]:
    return [max(map(len, column)) for column in zip(*rows, strict=True)]


def _aligned(table: Table) -> list[str]:
    """Return the lines of a table."""
    rows = _rows(table)
    widths = _widths(rows)
    return [GAP.join(_cells(row, widths, table.text)).rstrip() for row in rows]


def _cells(row: Sequence[str], widths: Sequence[int], text: frozenset[int]) -> list[str]:
    return [
        f"{cell:<{width}}" if column in text else f"{cell:>{width}}"
        for column, (cell, width) in enumerate(zip(row, widths, strict=True))
    ]
