"""Scans that come in their own time, and when to stop waiting for them."""

import math
from abc import abstractmethod
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import parse_qsl, urlencode

from laserfeatures.data import LaserScan
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.losses import Losses
from laserfeatures.sources.source import Source


@dataclass(frozen=True)
class Limits:
    """When a source that has no end of its own ends.

    Parameters
    ----------
    scans : int or None
        After so many scans.
    seconds : float or None
        After this time [s].

    Raises
    ------
    ValueError
        If a limit is not positive.
    """

    scans: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        """Check them."""
        if self.scans is not None and not self.scans >= 1:
            raise ValueError(f"scans must be >= 1, got {self.scans}")
        if self.seconds is not None and not 0 < self.seconds < math.inf:
            raise ValueError(f"seconds must be > 0 s, got {self.seconds}")


class LiveSource(Source):
    """A source whose scans come in their own time.

    Parameters
    ----------
    name : str
        What was opened.
    format_ : str
        Its protocol.
    limits : Limits
        When it ends.
    range_max : float or None
        Overrides the sensor's limit [m].
    """

    path: Path | None = None

    def __init__(self, name: str, format_: str, limits: Limits, range_max: float | None) -> None:
        self.name, self.format = name, format_
        self._limits, self._range_max = limits, range_max
        self._began = now()
        self._given = 0
        self._waiting = self._interrupted = False
        self._first_error: str | None = None

    @property
    @abstractmethod
    def losses(self) -> Losses:
        """What has been lost so far."""

    @property
    @abstractmethod
    def arrival(self) -> float:
        """When the first byte of the last scan came, on `drivers.host_clock` [s]."""

    @abstractmethod
    def _wait(self) -> LaserScan:
        """Wait for the next scan; raise StopIteration if there is none."""

    @property
    def skipped(self) -> int:
        """Number of damaged frames so far."""
        return self.losses.damaged

    @property
    def first_error(self) -> str | None:
        """What was wrong with the first damaged frame."""
        if self._first_error is None and self.losses.damaged:
            problem = self.losses.problem or "a damaged frame"
            self._first_error = f"{self.name.partition('?')[0]}: {problem}"
        return self._first_error

    @property
    def time_left(self) -> float | None:
        """How long it goes on [s]; None: without a limit."""
        if self._limits.seconds is None:
            return None
        return max(self._began + self._limits.seconds - now(), 0.0)

    def interrupt(self) -> None:
        """End as a log ends, now if the next scan is being waited for: for a signal's handler."""
        self._interrupted = True
        if self._waiting:
            raise KeyboardInterrupt

    def __next__(self) -> LaserScan:
        """Wait for the next scan.

        Raises
        ------
        DriverError
            As `Driver`, for a port.
        """
        try:
            self._waiting = True
            if self._interrupted or self._ended(now()):
                raise StopIteration
            scan = self._wait()
            self._waiting = False
        except KeyboardInterrupt:
            if self._interrupted:
                raise StopIteration from None
            raise
        finally:
            self._waiting = False
        _ = self.first_error  # noted while it is the last
        if self._ended(self.arrival):
            raise StopIteration
        self._given += 1
        return scan if self._range_max is None else replace(scan, range_max=self._range_max)

    def _ended(self, time: float) -> bool:
        scans, seconds = self._limits.scans, self._limits.seconds
        if scans is not None and self._given >= scans:
            return True
        return seconds is not None and time >= self._began + seconds


def split_query(address: str, own: Collection[str]) -> tuple[str, dict[str, float]]:
    """Take the numbers of some names out of the query of an address.

    Parameters
    ----------
    address : str
        Such as ``urg:///dev/ttyACM0?skip=1&scans=10``.
    own : collection of str
        The names to take out.

    Returns
    -------
    (str, dict)
        The address without them, and the numbers.

    Raises
    ------
    ValueError
        If the text after one of the names is no number.
    """
    rest, _, query = address.partition("?")
    numbers, others = {}, []
    for name, text in parse_qsl(query, keep_blank_values=True):
        if name not in own:
            others.append((name, text))
            continue
        try:
            numbers[name] = float(text)
        except ValueError:
            raise ValueError(f"{name} must be a number, got {text!r}") from None
    return f"{rest}?{urlencode(others)}" if others else rest, numbers


def limits_of(numbers: dict[str, float]) -> Limits:
    """Return the limits of a source, taken out of its address.

    Raises
    ------
    ValueError
        If one makes no sense.
    """
    scans = numbers.get("scans")
    if scans is not None and not scans.is_integer():
        raise ValueError(f"scans must be a whole number, got {scans}")
    return Limits(None if scans is None else int(scans), numbers.get("seconds"))
