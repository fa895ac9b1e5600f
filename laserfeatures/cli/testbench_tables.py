"""A page of the testbench on a terminal."""

from collections.abc import Sequence
from itertools import zip_longest

import click

from laserfeatures.comparison.document import Heading, Table
from laserfeatures.testbench.pages import Page


def print_page(page: Page) -> None:
    """Print the title of a page, its headings and tables; the text is in its file."""
    click.echo(page.document.title)
    for block in page.document.blocks:
        if isinstance(block, Heading):
            click.echo(f"\n{block.text}")
        elif isinstance(block, Table):
            click.echo("\n".join(_aligned(block)))
    click.echo()


def _aligned(table: Table) -> list[str]:
    """Return the lines of a table; each word of the header has a line of its own."""
    heads = [head.split() for head in table.header]
    words = [list(row) for row in zip_longest(*heads, fillvalue="")]
    rows: list[Sequence[str]] = [*words, *table.rows]
    widths = [max(len(row[column]) for row in rows) for column in range(len(table.header))]
    return ["  ".join(_cells(row, widths, table.text)).rstrip() for row in rows]


def _cells(row: Sequence[str], widths: Sequence[int], text: frozenset[int]) -> list[str]:
    return [
        f"{cell:<{width}}" if column in text else f"{cell:>{width}}"
        for column, (cell, width) in enumerate(zip(row, widths, strict=True))
    ]
