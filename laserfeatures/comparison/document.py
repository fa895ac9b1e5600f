"""What a report is made of, whatever it is written as."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Heading:
    """The title of a section."""

    text: str


@dataclass(frozen=True)
class Paragraph:
    """Some sentences."""

    text: str


@dataclass(frozen=True)
class Table:
    """Cells under a header, the first of each row naming it; `text` are the columns to the left."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    text: frozenset[int] = frozenset({0})


@dataclass(frozen=True)
class Code:
    """Text to be shown as it is, under a name."""

    name: str
    text: str


@dataclass(frozen=True)
class Picture:
    """A PNG, with a name fit for a file, what it is called and what can be seen in it."""

    name: str
    caption: str
    alt: str
    png: bytes


@dataclass(frozen=True)
class Gallery:
    """Pictures side by side."""

    pictures: Sequence[Picture]


Block = Heading | Paragraph | Table | Code | Gallery


@dataclass(frozen=True)
class Document:
    """A report."""

    title: str
    blocks: Sequence[Block]

    @property
    def pictures(self) -> list[Picture]:
        """All pictures, in order."""
        return [
            picture
            for block in self.blocks
            if isinstance(block, Gallery)
            for picture in block.pictures
        ]
