"""What a log, a port and a recording that is played have in common: their scans, once, in order."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from typing import Self

from laserfeatures.data import LaserScan
from laserfeatures.sources.log import Poses


class Source(ABC):
    """An open log or port: an iterator of its scans, and a context manager that closes it.

    `open_source` makes it.

    Attributes
    ----------
    name : str
        What was opened, as it was given.
    path : Path or None
        The file or folder; None for a port.
    format : str
        The format's name; of a port, its protocol's.
    """

    name: str
    path: Path | None
    format: str

    @property
    def poses(self) -> Poses:
        """What the scans' poses are: "none", raw "odometry", or "corrected" by a SLAM program."""
        return "none"

    @property
    def passed_over(self) -> dict[str, int]:
        """How many records that are no scans there were so far, by their first word."""
        return {}

    @property
    def no_return(self) -> float | None:
        """The least range [m] so far that is no return because it comes again and again."""
        return None

    @property
    def notices(self) -> tuple[str, ...]:
        """What is worth knowing of the log so far; each was also told as a warning."""
        return ()

    @property
    @abstractmethod
    def skipped(self) -> int:
        """Number of broken records left out so far; of a port, of damaged frames."""

    @property
    @abstractmethod
    def first_error(self) -> str | None:
        """What was wrong with the first of them: where, expected, got."""

    def __iter__(self) -> Iterator[LaserScan]:
        """Return itself: scans are read once, in order."""
        return self

    @abstractmethod
    def __next__(self) -> LaserScan:
        """Return the next scan."""

    def __enter__(self) -> Self:
        """Return itself; it is open already."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    @abstractmethod
    def close(self) -> None:
        """Close it; there are no more scans then."""
