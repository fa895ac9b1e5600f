"""A report as Markdown, with tables as GitHub reads them."""

import re
from collections.abc import Callable, Sequence

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

ABREAST = 2  # pictures

# Signs that would be read as markup; an underscore inside a word is none.
_SIGNS = re.compile(r"[\\`*\[\]<>|&~#]|(?<!\w)_|_(?!\w)")

Link = Callable[[Picture], str]


def to_markdown(document: Document, link: Link) -> str:
    """Return a document as Markdown.

    Parameters
    ----------
    document : Document
        The document.
    link : callable
        From a picture to the path of its file, as seen from the document's.
    """
    parts = [f"# {_plain(document.title)}", *(_block(block, link) for block in document.blocks)]
    return "\n\n".join(parts) + "\n"


def _block(block: Block, link: Link) -> str:
    match block:
        case Heading():
            return f"## {_plain(block.text)}"
        case Paragraph():
            return _plain(block.text)
        case Table():
            return _table(
                block.header, [[_plain(c) for c in row] for row in block.rows], block.text
            )
        case Code():
            return f"{_plain(block.name)}:\n\n```text\n{block.text}\n```"
        case Gallery():
            return _gallery(block.pictures, link)


def _gallery(pictures: Sequence[Picture], link: Link) -> str:
    shown = [f"![{_plain(p.alt)}](<{link(p)}>)" for p in pictures]
    if len(shown) == 1:
        return shown[0]
    tables = []
    for first in range(0, len(shown), ABREAST):
        row = slice(first, first + ABREAST)
        captions = [picture.caption for picture in pictures[row]]
        tables.append(_table(captions, [shown[row]], frozenset(range(ABREAST))))
    return "\n\n".join(tables)


def _table(header: Sequence[str], rows: Sequence[Sequence[str]], text: frozenset[int]) -> str:
    rule = ["---" if column in text else "---:" for column in range(len(header))]
    lines = [[_plain(cell) for cell in header], rule, *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _plain(text: str) -> str:
    return _SIGNS.sub(r"\\\g<0>", text)
