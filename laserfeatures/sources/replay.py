"""A recording of a port, played in the time in which it was made: ``replay:FILE?speed=1``."""

import time
from collections.abc import Iterator
from pathlib import Path

from laserfeatures.data import LaserScan
from laserfeatures.drivers import Losses
from laserfeatures.drivers.host_clock import now
from laserfeatures.errors import SourceError
from laserfeatures.sources.live import Limits, LiveSource, limits_of, split_query
from laserfeatures.sources.log import Log, OnError
from laserfeatures.sources.recording import Player

SCHEME = "replay:"
LONGEST = 1e6  # [s] that can be slept
OWN = ("speed", "scans", "seconds")


class ReplaySource(LiveSource):
    """A recording that is being played.

    Parameters
    ----------
    address : str
        ``replay:FILE?speed=K``, K times as fast as it was made, 1 if left out; ``scans=N`` and
        ``seconds=T`` end it early.
    on_error : {"raise", "skip"}
        What to do about a broken line.
    range_max : float or None
        Overrides the sensor's limit [m].

    Raises
    ------
    SourceError
        If the address makes no sense, or the file is no recording.
    """

    def __init__(
        self, address: str, *, on_error: OnError = "raise", range_max: float | None = None
    ) -> None:
        file, self._speed, limits = _parse(address)
        self._log = Log(Path(file), on_error)
        self.path = self._log.path
        self._player = Player(self._log)
        self._arrival = float("nan")
        super().__init__(address, self._player.protocol, limits, range_max)
        self._scans = self._play()

    @property
    def losses(self) -> Losses:
        """What the decoder has thrown away so far."""
        return self._player.losses

    @property
    def arrival(self) -> float:
        """When the first byte of the last scan was played, on the clock of `now` [s]."""
        return self._arrival

    @property
    def skipped(self) -> int:
        """Number of damaged frames and lines so far."""
        return self._log.skipped

    @property
    def first_error(self) -> str | None:
        """What was wrong with the first of them."""
        return self._log.first_error

    def _wait(self) -> LaserScan:
        return next(self._scans)

    def _play(self) -> Iterator[LaserScan]:
        first: float | None = None
        began = now()
        for entry in self._player.entries:
            first = entry.time if first is None else first
            due = began + (entry.time - first) / self._speed
            time.sleep(min(max(due - now(), 0.0), LONGEST))
            for sweep in self._player.play(entry):
                self._arrival = began + (sweep.arrival - first) / self._speed
                yield sweep.scan

    def close(self) -> None:
        """Close the file; there are no more scans then."""
        self._scans = iter(())


def _parse(address: str) -> tuple[str, float, Limits]:
    try:
        rest, numbers = split_query(address.removeprefix(SCHEME), OWN)
        return _file(rest), _speed(numbers), limits_of(numbers)
    except ValueError as error:
        raise SourceError(f"{address}: {error}") from error


def _file(rest: str) -> str:
    file, mark, query = rest.partition("?")
    if mark or not file:
        got = f"?{query}" if mark else "no file"
        raise ValueError(f"expected replay:FILE with {', '.join(OWN)} after a '?', got {got}")
    return file


def _speed(numbers: dict[str, float]) -> float:
    speed = numbers.get("speed", 1.0)
    if not speed > 0:
        raise ValueError(f"speed must be > 0, got {speed:g}")
    return speed
