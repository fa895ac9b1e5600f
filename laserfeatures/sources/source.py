"""`open_source`: the one way from a file to its scans."""

import math
import re
from collections.abc import Iterator
from itertools import chain, islice
from os import PathLike, fspath
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.sources.formats import FORMATS, find_format
from laserfeatures.sources.log import Log, OnError, Poses, Scans

URL = re.compile(r"[a-z][a-z0-9+]+:/")
LOOK_AHEAD = 10  # scans
LONGEST = 100.0  # [m]; nine ranges of ten beyond this are not metres


class Source:
    """An open log: an iterator of its scans, and a context manager that closes it.

    `open_source` makes it.

    Attributes
    ----------
    path : Path
        The file or folder.
    format : str
        The format's name.
    """

    def __init__(self, log: Log, format_: str) -> None:
        self.path = log.path
        self.format = format_
        self._log = log
        self._reader = FORMATS[format_].read(log)
        try:
            self._scans = _look_ahead(log, self._reader)
        except BaseException:
            self._reader.close()
            raise

    @property
    def poses(self) -> Poses:
        """What the scans' poses are: "none", raw "odometry", or "corrected" by a SLAM program."""
        return self._log.poses

    @property
    def skipped(self) -> int:
        """Number of broken records left out so far (with ``on_error="skip"``)."""
        return self._log.skipped

    @property
    def first_error(self) -> str | None:
        """What was wrong with the first record left out: file, line, expected, got."""
        return self._log.first_error

    def __iter__(self) -> Iterator[LaserScan]:
        """Return itself: scans are read once, in order."""
        return self

    def __next__(self) -> LaserScan:
        """Return the next scan."""
        return next(self._scans)

    def __enter__(self) -> Self:
        """Return itself; the log is open already."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the log."""
        self.close()

    def close(self) -> None:
        """Close the log; there are no more scans then."""
        self._scans = iter(())
        self._reader.close()


def open_source(
    path: str | PathLike[str],
    *,
    format: str | None = None,  # noqa: A002 - the natural name for a user
    on_error: OnError = "raise",
    topic: str | None = None,
    range_max: float | None = None,
    field_of_view: float | None = None,
    slice_band: tuple[float, float] | None = None,
    slice_origin: tuple[float, float] | None = None,
) -> Source:
    r"""Open a log, table or bag of laser scans, a point cloud, or a plan for a simulated robot.

    Parameters
    ----------
    path : str or PathLike
        A file, gzip or not, or the folder of a ROS 2 bag.
    format : str, optional
        "carmen", "gfs", "breezyslam", "brenner", "urg_csv", "rplidar", "csv", "npz", "rosbag1",
        "rosbag2", "mcap", "point_cloud" or "plan"; told by the content if left out.
    on_error : {"raise", "skip"}
        What to do about a broken record: stop, or leave it out and count it in `Source.skipped`.
    topic : str, optional
        Which topic of a bag to read; needed if several hold laser scans.
    range_max : float, optional
        Range at and beyond which there is no return [m], instead of the log's or sensor's own.
    field_of_view : float, optional
        Angle from the first to the last beam [rad], symmetric about the front, for the logs that
        do not say (carmen, gfs).
    slice_band : (float, float), optional
        The heights ``low <= z < high`` [m] of a point cloud to scan; needed for one.
    slice_origin : (float, float), optional
        Where in a point cloud the scanner stands [m], looking along x; its own origin if left out.

    Returns
    -------
    Source
        An iterator of `LaserScan`, to be used in a ``with`` statement.

    Raises
    ------
    SourceError
        If the file is missing, empty, of no known format, or holds no scan; and, here or from the
        iterator, if a record is broken.
    MissingDependencyError
        If a bag is to be read and rosbags is not installed, a point cloud and Open3D is not, or a
        plan and mujoco is not.
    ValueError
        If an option makes no sense, or is none of this format's.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> log = Path(tempfile.mkdtemp(), "two_beams.csv")
    >>> _ = log.write_text("stamp,-0.1,0.1\n5.0,2.0,\n")
    >>> with open_source(log) as scans:
    ...     for scan in scans:
    ...         print(scan.stamp, scan.valid.tolist())
    5.0 [True, False]
    """
    name = fspath(path)
    if URL.match(name):
        raise SourceError(f"{name}: expected a file or folder; ports are not supported here")
    if on_error not in {"raise", "skip"}:
        raise ValueError(f"on_error must be 'raise' or 'skip', got {on_error!r}")
    if range_max is not None and not range_max > 0:
        raise ValueError(f"range_max must be > 0 m, got {range_max!r}")
    if field_of_view is not None and not 0 < field_of_view <= 2 * math.pi:
        raise ValueError(f"field_of_view must be in (0, 2 pi] rad, got {field_of_view!r}")
    if slice_band is not None and not slice_band[0] < slice_band[1]:
        low, high = slice_band
        raise ValueError(f"slice_band must be low < high [m], got {low!r} and {high!r}")
    log = Log(Path(name), on_error, topic, range_max, field_of_view, slice_band, slice_origin)
    found = find_format(log.path, format)
    for option in ("topic", "field_of_view", "slice_band", "slice_origin"):
        if getattr(log, option) is not None and option not in FORMATS[found].options:
            raise ValueError(f"{name}: {option} does not apply to the format {found!r}")
    return Source(log, found)


def _look_ahead(log: Log, reader: Scans) -> Iterator[LaserScan]:
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
    if log.range_max is None:
        _check_unit(log, first)
    return chain(first, _rest(reader, error))


def _rest(reader: Scans, error: SourceError | None) -> Iterator[LaserScan]:
    if error:
        raise error
    yield from reader


def _check_unit(log: Log, scans: list[LaserScan]) -> None:
    """Raise a SourceError if the ranges cannot be metres."""
    ranges = np.concatenate([scan.ranges for scan in scans])
    ranges = ranges[np.isfinite(ranges) & (ranges > 0)]
    ranges = ranges[ranges < ranges.max(initial=0)]  # the largest may say "no return"
    if ranges.size and np.quantile(ranges, 0.1) > LONGEST:
        raise SourceError(
            f"{log.path}: expected ranges in metres, got a median of {np.median(ranges):.0f}, "
            "which looks like millimetres; divide them by 1000, or give range_max= (--range-max) "
            "if they are metres"
        )
