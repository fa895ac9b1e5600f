"""What every reader gets: the path, the options and the bookkeeping of broken records."""

import logging
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeVar

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError, shown
from laserfeatures.sources.files import DAMAGE, LONGEST_LINE, MARK, is_bomb, is_gzip, open_stream

OnError = Literal["raise", "skip"]
Poses = Literal["none", "odometry", "corrected"]
Wanted = Literal["odometry", "corrected"]
LOGGER = logging.getLogger(__name__)
Scans = Generator[LaserScan, None, None]
Parsed = TypeVar("Parsed")


@dataclass
class Log:
    """A log being read.

    Parameters
    ----------
    path : Path
        The file or folder.
    on_error : {"raise", "skip"}
        What to do about a broken record.
    topic : str or None
        Which topic of a bag to read.
    range_max : float or None
        Overrides the sensor's limit [m].
    field_of_view : float, (float, float) or None
        Angle from the first to the last beam, or both their directions [rad], where the format does
        not say.
    slice_band : (float, float) or None
        Lowest and highest z [m] of the points of a cloud that make its scan.
    slice_origin : (float, float) or None
        Where in a cloud the scanner stands [m].
    wanted : {"odometry", "corrected"} or None
        Which poses the scans are to have, of a log that has both; None: its own choice.
    columns : tuple of str or None
        Names of the columns of a table without a header.
    angle_unit, range_unit : str or None
        Of a table, where its header does not say.
    delimiter : str or None
        What stands between the cells of a table: ",", ";", "tab" or "space".
    poses : {"none", "odometry", "corrected"}
        What the scans' poses are; a reader sets it before its first scan.
    skipped : int
        Number of broken records so far.
    first_error : str or None
        What was wrong with the first of them.
    notices : dict
        What users should know of the log and cannot see in its scans, each under a key of its own.
    no_return : float or None
        The least range [m] that was taken for no return because it comes again and again.
    passed_over : Counter
        How many records of other kinds there were, by their first word.
    """

    path: Path
    on_error: OnError = "raise"
    topic: str | None = None
    range_max: float | None = None
    field_of_view: float | tuple[float, float] | None = None
    slice_band: tuple[float, float] | None = None
    slice_origin: tuple[float, float] | None = None
    wanted: Wanted | None = None
    columns: tuple[str, ...] | None = None
    angle_unit: str | None = None
    range_unit: str | None = None
    delimiter: str | None = None
    poses: Poses = field(default="none", init=False)
    skipped: int = field(default=0, init=False)
    first_error: str | None = field(default=None, init=False)
    notices: dict[str, str] = field(default_factory=dict, init=False)
    no_return: float | None = field(default=None, init=False)
    passed_over: Counter[str] = field(default_factory=Counter, init=False)

    def notice(self, key: str, text: str, path: Path | None = None) -> None:
        """Say what a user should know of the log: the first time, as a warning of `logging`."""
        if key not in self.notices:
            self.notices[key] = text
            LOGGER.warning("%s: %s", path or self.path, text)

    def broken(
        self, where: object, problem: object, cause: BaseException, path: Path | None = None
    ) -> None:
        """Raise a broken record's error, or count it.

        Parameters
        ----------
        where : object
            Line number, message number or key.
        problem : object
            What was expected and what came.
        cause : Exception
            What found it.
        path : Path, optional
            The file, where that is not the log's own path.

        Raises
        ------
        SourceError
            Unless `on_error` is "skip".
        """
        text = shown(str(problem))
        message = f"{path or self.path}:{where}: {text}"
        if self.on_error == "raise":
            raise SourceError(
                f"{message}; on_error='skip' (--on-error skip) reads on without it"
            ) from cause
        self.skipped += 1
        self.first_error = self.first_error or message

    def records(
        self, parse: Callable[[bytes], Parsed | None], path: Path | None = None
    ) -> Iterator[Parsed]:
        """Parse the file line by line.

        Parameters
        ----------
        parse : callable
            From a line to a record, or to None where the line holds none. Raises a ValueError that
            says what was expected and what came if the line is broken.
        path : Path, optional
            The file, where that is not the log's own path.

        Yields
        ------
        Parsed
            The records in order; broken ones go to `broken`, as does the end of damaged gzip data.
        """
        for number, line in self._lines(path or self.path):
            try:
                record = parse(line)
            except ValueError as error:
                self.broken(number, error, error, path)
                continue
            if record is not None:
                yield record

    def _lines(self, path: Path) -> Iterator[tuple[int, bytes]]:
        """Yield the numbers and lines of a file, as far as it makes sense to read it."""
        packed = path.stat().st_size if is_gzip(path) else None
        number = unpacked = 0
        with open_stream(path) as stream:
            while True:
                number += 1
                problem: Exception | None = None
                line = b""
                try:
                    line = stream.readline(LONGEST_LINE + 1)
                except DAMAGE as error:
                    problem = error
                unpacked += len(line)
                if problem:
                    text = f"the file is cut or damaged from here on ({problem})"
                elif len(line) > LONGEST_LINE:
                    text = f"expected a line of at most {LONGEST_LINE} bytes, got a longer one"
                elif packed is not None and is_bomb(unpacked, packed):
                    text = f"expected a log, got {packed} packed bytes of more than {unpacked}"
                elif not line:
                    return
                else:
                    yield number, line.removeprefix(MARK) if number == 1 else line
                    continue
                self.broken(number, text, problem or ValueError(text), path)
                return
