"""A report as one HTML page that refers to nothing outside."""

import base64
import re
from collections.abc import Sequence
from html import escape

from laserfeatures.comparison.document import (
    Block,
    Code,
    Document,
    Gallery,
    Heading,
    Paragraph,
    Picture,
    Table,
)

STYLE = """
:root { color-scheme: light dark; --ink: #1c1e21; --paper: #ffffff; --rule: #d5d8dc;
  --shade: #f3f4f6; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e6e9; --paper: #16181b; --rule: #3b3f45; --shade: #22252a; } }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 1rem/1.5 system-ui, sans-serif; }
main { max-width: 72rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.5rem; line-height: 1.25; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin-top: 2.2rem; }
p { max-width: 46rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .7rem; border-bottom: 1px solid var(--rule); text-align: right;
  vertical-align: top; }
th { font-weight: 600; }
thead th { vertical-align: bottom; }
tbody th { position: sticky; left: 0; background: var(--paper);
  min-width: 6rem; }
th.text, td.text { text-align: left; }
td { white-space: nowrap; }
td.text { white-space: normal; min-width: 12rem; overflow-wrap: anywhere; }
.gallery { display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fit, minmax(min(100%, 21rem), 1fr)); }
figure { margin: 0; max-width: 44rem; }
figcaption { font-weight: 600; padding-bottom: .3rem; overflow-wrap: anywhere; }
img { display: block; width: 100%; height: auto; background: #ffffff; border-radius: .3rem; }
pre { background: var(--shade); padding: .7rem; border-radius: .3rem; white-space: pre-wrap;
  overflow-wrap: anywhere; font-size: .85rem; }
@media (max-width: 40rem) { th, td { padding: .35rem .45rem; } tbody th { max-width: 8rem; } }
"""


def to_html(document: Document) -> str:
    """Return a document as an HTML page with its pictures inside."""
    title = escape(document.title)
    return "\n".join([
        "<!DOCTYPE html>",
        '<html lang="en">',
        "<head>",
        '<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{title}</title>",
        f"<style>{STYLE}</style>",
        "</head>",
        "<body>",
        "<main>",
        f"<h1>{title}</h1>",
        *(_block(block) for block in document.blocks),
        "</main>",
        "</body>",
        "</html>",
        "",
    ])  # fmt: skip


def _block(block: Block) -> str:
    match block:
        case Heading():
            return f"<h2>{escape(block.text)}</h2>"
        case Paragraph():
            return f"<p>{escape(block.text)}</p>"
        case Table():
            return _table(block)
        case Code():
            return f"<h3>{escape(block.name)}</h3>\n<pre>{escape(block.text)}</pre>"
        case Gallery():
            figures = "\n".join(_figure(picture) for picture in block.pictures)
            return f'<div class="gallery">\n{figures}\n</div>'


def _figure(picture: Picture) -> str:
    data = base64.b64encode(picture.png).decode("ascii")
    return (
        f"<figure><figcaption>{_breakable(picture.caption)}</figcaption>"
        f'<img src="data:image/png;base64,{data}" alt="{escape(picture.alt)}"></figure>'
    )


def _table(table: Table) -> str:
    head = _row(table, table.header, first="col", rest="th")
    body = "\n".join(_row(table, row, first="row", rest="td") for row in table.rows)
    # A box that scrolls must be reachable by keyboard.
    return (
        '<div class="scroll" tabindex="0">\n<table>\n'
        f"<thead>\n{head}\n</thead>\n<tbody>\n{body}\n</tbody>\n</table>\n</div>"
    )


def _breakable(text: str) -> str:
    """Return text as HTML that may be broken inside the long names of extractors."""
    return re.sub(r"(?<=\w)[_:](?=\w)", r"\g<0><wbr>", escape(text))


def _row(table: Table, cells: Sequence[str], *, first: str, rest: str) -> str:
    parts = []
    for column, cell in enumerate(cells):
        kind = "th" if column == 0 else rest
        scope = f' scope="{first}"' if kind == "th" else ""
        text = ' class="text"' if column in table.text else ""
        parts.append(f"<{kind}{scope}{text}>{_breakable(cell)}</{kind}>")
    return f"<tr>{''.join(parts)}</tr>"
