"""Recordings of ports (`drivers.recorder`), played through the decoder that the port had."""

import base64
import json
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

from laserfeatures.drivers import Sweep
from laserfeatures.drivers.address import driver_class
from laserfeatures.drivers.recorder import VERSION
from laserfeatures.errors import DriverError, SourceError
from laserfeatures.sources.log import Log, Scans

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

HEAD = b'{"laserfeatures": "recording"'
KINDS = ("open", "rx", "tx", "scan", "losses", "end")


class Entry(NamedTuple):
    """A line of a recording."""

    number: int
    time: float  # [s since the epoch]
    kind: str
    content: Any  # bytes of "rx" and "tx", of "end" the error if there was one


@dataclass(frozen=True)
class Header:
    """The first line of a recording."""

    protocol: str
    settings: dict[str, Any]


def is_recording(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a recording of a port."""
    return head.startswith(HEAD)


def read_recording(log: Log) -> Scans:
    """Yield the scans that the decoder makes of a recording's bytes.

    Raises
    ------
    SourceError
        If the header is broken; and if another line is, unless broken ones are to be skipped. A
        last line that is cut, as by a loss of power, is counted only. If there is no scan since
        the recording ended with an error, which is told.
    """
    player = Player(log)
    seen = False
    for entry in player.entries:
        if entry.kind == "end" and entry.content and not seen:
            raise SourceError(f"{log.path}: no scan is in it, for it ended with: {entry.content}")
        for sweep in player.play(entry):
            seen = True
            scan = sweep.scan
            yield scan if log.range_max is None else replace(scan, range_max=log.range_max)


class Player:
    """Plays a recording through the decoder of its protocol.

    Parameters
    ----------
    log : Log
        The file and what to do about broken lines; damaged frames are counted there, too.

    Attributes
    ----------
    protocol : str
        Whose bytes these are.
    entries : iterator of Entry
        The lines after the header.
    losses : Losses
        What the decoder has thrown away.

    Raises
    ------
    SourceError
        If the header is broken.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._number = 0
        lines = log.records(self._parse)
        header = next(lines, None)
        if not isinstance(header, Header):
            raise SourceError(f"{log.path}: expected a recording of a port, got no header")
        self.protocol = header.protocol
        self.entries: Iterator[Entry] = (line for line in lines if isinstance(line, Entry))
        try:
            kind = driver_class(header.protocol)
            self._driver = kind(port=str(log.path), **header.settings)
        except (DriverError, TypeError, ValueError) as error:
            raise SourceError(f"{log.path}:1: {error}") from error
        self.losses = self._driver.losses
        self._decoder = self._driver.decoder()
        if self._driver.doubt is not None:
            log.notice("device", self._driver.doubt)

    def play(self, entry: Entry) -> list[Sweep]:
        """Return the scans that become whole with an entry."""
        damaged = self.losses.damaged
        messages: Sequence[object] = ()
        if entry.kind == "open":
            self._decoder = self._driver.decoder()
        elif entry.kind == "tx":
            self._decoder.sent(entry.content, entry.time)
        elif entry.kind == "rx":
            messages = self._decoder.received(entry.content, entry.time)
        if self.losses.damaged > damaged:
            problem = self.losses.problem or "a damaged frame"
            self._skip(self.losses.damaged - damaged, f"{entry.number}: {problem}")
        return [message for message in messages if isinstance(message, Sweep)]

    def _skip(self, count: int, problem: str) -> None:
        self._log.skipped += count
        self._log.first_error = self._log.first_error or f"{self._log.path}:{problem}"

    def _parse(self, line: bytes) -> Header | Entry | None:
        self._number += 1
        try:
            content = json.loads(line)
            if self._number == 1:
                return _header(content)
            return _entry(self._number, content)
        except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
            if self._number == 1:
                raise SourceError(f"{self._log.path}:1: {_expected_header(error)}") from error
            if not line.endswith(b"\n"):
                self._skip(1, f"{self._number}: the last line is cut, as by a loss of power")
                return None
            raise ValueError(
                f'expected a JSON object such as {{"t": 12.5, "rx": "base64"}}, got {line[:24]!r}'
            ) from error


def _expected_header(error: Exception) -> str:
    return (
        f'expected a header such as {HEAD.decode()}, "version": {VERSION}, "protocol": '
        f'"urg", "settings": {{..}}}}, got something else ({type(error).__name__}: {error})'
    )


def _header(content: Any) -> Header:
    if content["version"] != VERSION:
        raise ValueError(f"version {content['version']}")
    return Header(str(content["protocol"]), dict(content["settings"]))


def _entry(number: int, content: Any) -> Entry | None:
    """Return a line's entry, None if it has none of the known kinds: of a later version."""
    time = float(content["t"])
    if not math.isfinite(time):
        raise ValueError("t is not finite")
    for kind in KINDS:
        if kind in content:
            value = content.get("error") if kind == "end" else content[kind]
            return Entry(number, time, kind, _content(kind, value))
    return None


def _content(kind: str, value: Any) -> Any:
    if kind not in {"rx", "tx"}:
        return value
    if value is True:  # no bytes, as recorders wrote it at first
        return b""
    return base64.b64decode(value, validate=True)
