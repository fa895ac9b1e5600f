"""Recording what goes over a driver's port, and the scans that come out.

A recording is a text file of JSON objects, one a line. The first line is the `header`; the others
have a time ``t`` [s since the epoch] and one of

- ``"open": true``: the port was opened, anew after a reconnect;
- ``"rx": base64`` or ``"tx": base64``: bytes that came from the device or went to it;
- ``"scan": {..}``: a scan that its user got, with ``angles`` where they differ from the last one's;
- ``"losses": {..}``: the counters of `Losses`, when they have changed;
- ``"end": true``: the recording ended as it should.
"""

import base64
import json
import math
import queue
import threading
from collections import deque
from contextlib import suppress
from dataclasses import asdict
from types import TracebackType
from typing import Any, Self

from laserfeatures.arrays import FloatArray
from laserfeatures.drivers.address import settings_of
from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.host_clock import now
from laserfeatures.errors import DriverError
from laserfeatures.growing_file import GrowingFile
from laserfeatures.scan import LaserScan

VERSION = 1
SYNC = 1.0  # [s]; what a loss of power may take
WAITING = 100_000  # lines that may wait for a slow disk
UNHEARD = 1000  # lines kept of what was sent before the device said anything


class Recorder:
    """Writes what goes over a driver's port into a file, from the first byte of the device on.

    Make it before the driver is opened, and leave it after the driver is closed.

    Parameters
    ----------
    file : GrowingFile
        Where to write.
    driver : Driver
        Whose bytes; its `tap` is taken.

    Attributes
    ----------
    scans : int
        Number of scans written.

    Examples
    --------
    ``with GrowingFile("run.rec") as file, Recorder(file, driver) as recorder, driver:`` and then
    ``recorder.add(scan)`` for each scan of the driver.
    """

    def __init__(self, file: GrowingFile, driver: Driver) -> None:
        self.scans = 0
        self._file, self._driver = file, driver
        self._lines: queue.Queue[bytes] = queue.Queue(WAITING)
        self._header: dict[str, Any] | None = header(driver)  # None: it is written
        self._unheard: deque[dict[str, Any]] = deque(maxlen=UNHEARD)
        self._angles: FloatArray | None = None
        self._counted: dict[str, Any] = asdict(driver.losses)
        self._error: OSError | None = None
        self._ending = False
        self._thread = threading.Thread(target=self._run, name=f"write {file.path}", daemon=True)
        driver.tap = self._tap

    def add(self, scan: LaserScan) -> None:
        """Write a scan that the driver has given.

        Raises
        ------
        OSError
            If something could not be written, be it this scan or what came before.
        """
        if self._error:
            raise self._error
        record = {
            "stamp": _finite(scan.stamp),
            "arrival": _finite(self._driver.arrival),
            "range_min": scan.range_min,
            "range_max": _finite(scan.range_max),
            "ranges": [_finite(r) for r in scan.ranges.tolist()],
        }
        if self._angles is None or not _same(scan.angles, self._angles):
            self._angles = scan.angles
            record["angles"] = scan.angles.tolist()
        self.scans += 1
        self._put({"t": now(), "scan": record})

    def __enter__(self) -> Self:
        """Begin."""
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Write what is still to be written.

        Raises
        ------
        OSError
            If that cannot be done.
        """
        self._driver.tap = None
        if self._header is None:
            self._put({"t": now(), "losses": asdict(self._driver.losses)})
            self._put({"t": now(), "end": True} | ({"error": str(error)} if error else {}))
        self._ending = True
        with suppress(queue.Full):
            self._lines.put_nowait(b"")  # wakes the thread
        self._thread.join()
        if self._error and error is None:
            raise self._error

    def _tap(self, kind: str, data: bytes, time: float) -> None:
        plain = not data and kind not in {"rx", "tx"}  # "open"
        record = {"t": time, kind: True if plain else base64.b64encode(data).decode()}
        if self._header is None:
            self._put(record)
            return
        self._unheard.append(record)
        if kind == "rx":
            for first in (self._header, *self._unheard):
                self._put(first)
            self._header = None

    def _put(self, record: dict[str, Any]) -> None:
        if self._error:
            return
        try:
            self._lines.put_nowait(json.dumps(record, allow_nan=False).encode() + b"\n")
        except queue.Full:
            self._error = DriverError(
                f"{self._file.path}: the disk is too slow for the recording: use another one"
            )

    def _run(self) -> None:
        synced = now()
        try:
            while not (self._ending and self._lines.empty()):
                self._file.write(b"".join(self._waiting()))
                if now() >= synced + SYNC:
                    self._count()
                    self._file.sync()
                    synced = now()
        except OSError as error:
            self._error = error

    def _waiting(self) -> list[bytes]:
        """Return the lines that wait; wait a while for the first one."""
        lines = []
        with suppress(queue.Empty):
            lines.append(self._lines.get(timeout=SYNC))
            while True:
                lines.append(self._lines.get_nowait())
        return lines

    def _count(self) -> None:
        losses = asdict(self._driver.losses)
        if losses != self._counted and self._header is None:
            self._counted = losses
            self._put({"t": now(), "losses": losses})


def header(driver: Driver) -> dict[str, Any]:
    """Return the first line of a recording: what is needed to decode the rest."""
    return {
        "laserfeatures": "recording",
        "version": VERSION,
        "protocol": driver.protocol,
        "settings": settings_of(driver),
        "port": driver.port,
        "began": now(),
    }


def _same(a: FloatArray, b: FloatArray) -> bool:
    return a is b or (a.shape == b.shape and bool((a == b).all()))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
