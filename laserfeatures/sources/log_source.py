"""A log as a source: its first scans are looked at before it counts as opened."""

import math
from collections.abc import Iterator
from itertools import chain, islice

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.sources.formats import FORMATS
from laserfeatures.sources.log import Log, Poses, Scans
from laserfeatures.sources.readings import limited
from laserfeatures.sources.source import Source

LOOK_AHEAD = 10  # scans
SMALLER = {"centimetres": 100, "millimetres": 1000}
USUAL = 3.0  # [m]; the median range of a room
LONGEST = 100.0  # [m]; nine ranges of ten beyond this are not metres


class LogSource(Source):
    """An open log.

    Parameters
    ----------
    log : Log
        Its path and options.
    format_ : str
        Its format's name.
    """

    def __init__(self, log: Log, format_: str) -> None:
        self.name = str(log.path)
        self.path = log.path
        self.format = format_
        self._log = log
        self._reader = FORMATS[format_].read(log)
        try:
            self._scans = _look_ahead(log, format_, self._reader)
        except BaseException:
            self._reader.close()
            raise

    @property
    def poses(self) -> Poses:
        """What the scans' poses are, as the format's reader says."""
        return self._log.poses

    @property
    def skipped(self) -> int:
        """Number of broken records left out so far (with ``on_error="skip"``)."""
        return self._log.skipped

    @property
    def first_error(self) -> str | None:
        """What was wrong with the first record left out: file, line, expected, got."""
        return self._log.first_error

    @property
    def passed_over(self) -> dict[str, int]:
        """How many records that are no scans there were so far, by their first word."""
        return dict(self._log.passed_over.most_common())

    @property
    def no_return(self) -> float | None:
        """The least range [m] so far that is no return because it comes again and again."""
        return self._log.no_return

    @property
    def notices(self) -> tuple[str, ...]:
        """What is worth knowing of the log so far; each was also told as a warning."""
        return tuple(self._log.notices.values())

    def __next__(self) -> LaserScan:
        """Return the next scan."""
        return next(self._scans)

    def close(self) -> None:
        """Close the log; there are no more scans then."""
        self._scans = iter(())
        self._reader.close()


def _look_ahead(log: Log, format_: str, reader: Scans) -> Iterator[LaserScan]:
    """Return an iterator of the reader's scans, once the first ones have come and make sense."""
    first: list[LaserScan] = []
    error = None
    try:
        for scan in islice(reader, LOOK_AHEAD):
            first.append(scan)  # noqa: PERF402 - what came before an error must be kept
    except SourceError as broken:
        error = broken
    if error and not first:
        raise error
    if not first:
        raise SourceError(
            f"{log.path}: no scan could be read; {log.skipped} records are broken, the first: "
            f"{log.first_error}"
            if log.skipped
            else f"{log.path}: expected laser scans, got none; check the file and its format"
        )
    _check_poses(log)
    if log.range_max is None:
        _check_unit(log, format_, first)
    scans = chain(first, _rest(reader, error))
    if log.range_max is None and FORMATS[format_].open_limit:
        return limited(log, scans)
    return scans


def _rest(reader: Scans, error: SourceError | None) -> Iterator[LaserScan]:
    if error:
        raise error
    yield from reader


def _check_poses(log: Log) -> None:
    """Raise a SourceError if the poses are not those that were asked for."""
    if log.wanted in {None, log.poses}:
        return
    names = {"none": "no poses", "odometry": "raw odometry", "corrected": "corrected poses only"}
    wanted = "raw odometry" if log.wanted == "odometry" else "poses that are more than odometry"
    raise SourceError(f"{log.path}: expected a log with {wanted}, got one with {names[log.poses]}")


def _check_unit(log: Log, format_: str, scans: list[LaserScan]) -> None:
    """Raise a SourceError if the ranges cannot be metres."""
    ranges = np.concatenate([scan.ranges for scan in scans])
    ranges = ranges[np.isfinite(ranges) & (ranges > 0)]
    ranges = ranges[ranges < ranges.max(initial=0)]  # the largest may say "no return"
    if not ranges.size or np.quantile(ranges, 0.1) <= LONGEST:
        return
    middle, top = float(np.median(ranges)), float(np.max(ranges))
    units = [(name, scale) for name, scale in SMALLER.items() if top / scale <= LONGEST]
    units.sort(key=lambda unit: abs(math.log(middle / unit[1] / USUAL)))
    likely = " or ".join(f"{name} ({middle / scale:.3g} m)" for name, scale in units)
    scales = " or ".join(str(scale) for _, scale in units)
    how = f"divide them by {scales}" if units else "convert them"
    if "range_unit" in FORMATS[format_].options:
        how += ", or say which with range_unit= (--range-unit)"
    raise SourceError(
        f"{log.path}: expected ranges in metres, got a median of {middle:.0f}, which looks like "
        f"{likely or 'none'}; {how}, or give range_max= (--range-max) if they are metres"
    )
