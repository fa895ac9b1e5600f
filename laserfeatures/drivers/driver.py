"""What all drivers share: a context manager that iterates the scans of a device on a port."""

import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import ClassVar, Self, TypeVar

from laserfeatures.drivers.decoder import Decoder, Event, Halt, Sweep
from laserfeatures.drivers.identify import ask_around, identify, is_known
from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.port import Port
from laserfeatures.drivers.reader import Reader, Tap
from laserfeatures.drivers.usb import UsbIdentity, find_port, usb_identity
from laserfeatures.errors import DeviceLostError, DriverError, DriverTimeoutError, ProtocolError
from laserfeatures.scan import LaserScan

Reply = TypeVar("Reply")

RESTARTS = 3  # in a row without a scan between them, then the device is given up
PAUSE = 0.5  # [s] between two tries to open a lost port again

log = logging.getLogger("laserfeatures.drivers")
log.addHandler(logging.NullHandler())  # who wants to see it asks for it


@dataclass(kw_only=True, eq=False)
class Driver(ABC):
    """A laser rangefinder on a port: opens it, starts the sweep, and iterates the scans.

    Nothing happens before `open`, or the ``with`` statement, which also stops the sweep at its end,
    whatever ends it. Scans are read in a thread of their own.

    Parameters
    ----------
    port : str
        Device file such as ``/dev/ttyACM0``, or what pyserial opens by URL: ``socket://host:port``.
    baud : int or None
        Rate of the port [Bd]; None: the protocol's usual one, or found by trying.
    reconnect : bool
        Whether to wait for a device that is gone, and go on, instead of raising an error. A USB
        device with a serial number is found again under whatever name it comes back.
    buffer : int
        How many scans are kept for a user who is busy; then the oldest is dropped and counted.
    tap : callable or None
        Called with "open", "rx" or "tx", the bytes and their time [s since the epoch], to record.

    Attributes
    ----------
    losses : Losses
        What has been lost so far.
    arrival : float
        When the first byte of the scan yielded last came [s since the epoch].

    Raises
    ------
    ValueError
        If a parameter makes no sense.
    """

    protocol: ClassVar[str]
    usual_baud: ClassVar[int]

    port: str
    baud: int | None = None
    reconnect: bool = False
    buffer: int = 64
    tap: Tap | None = None
    losses: Losses = field(init=False, default_factory=Losses)
    arrival: float = field(init=False, default=float("nan"))
    _reader: Reader | None = field(init=False, default=None, repr=False)
    _usb: UsbIdentity | None = field(init=False, default=None, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        if self.baud is not None and not self.baud > 0:
            raise ValueError(f"baud must be > 0, got {self.baud}")
        if not self.buffer >= 1:
            raise ValueError(f"buffer must be >= 1, got {self.buffer}")

    # What a protocol's driver brings.

    @abstractmethod
    def decoder(self) -> Decoder:
        """Return a new decoder for this driver's parameters, which counts in `losses`."""

    @abstractmethod
    def _start(self) -> None:
        """Bring the device, whatever its state, to send scans.

        Raises
        ------
        DriverError
            If it cannot; silence is a DriverTimeoutError.
        """

    @abstractmethod
    def _stop(self) -> None:
        """Stop the sweep and the laser, and put back what was changed for the session."""

    @property
    @abstractmethod
    def patience(self) -> float:
        """How long the next scan may take before something is wrong [s]."""

    @property
    def doubt(self) -> str | None:
        """What a user should know of the device that these parameters may be meant for."""
        return None

    # What its user calls.

    def open(self) -> None:
        """Open the port and start the sweep.

        Raises
        ------
        DriverError
            If the port cannot be opened; the message says why and what to do.
        DriverTimeoutError
            If no device answers in time.
        ProtocolError
            If something else than this device answers; the message names it.
        """
        if self._reader is not None:
            raise DriverError(f"{self.port}: this driver is open already; make a second one")
        self._connect()

    def close(self) -> None:
        """Stop the sweep and the laser and close the port; does nothing if it is closed."""
        if self._reader is None:
            return
        try:
            with suppress(DriverError):  # a device that is gone or stuck cannot be stopped
                self._stop()
        finally:
            self._disconnect()

    def __enter__(self) -> Self:
        """Open it."""
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def __iter__(self) -> Iterator[LaserScan]:
        """Return itself: scans come once, in order."""
        return self

    def __next__(self) -> LaserScan:
        """Wait for the next scan.

        Raises
        ------
        DeviceLostError
            If the device is gone and `reconnect` is not set.
        DriverTimeoutError
            If the device is silent, and starting it again did not help.
        """
        failures = 0
        while True:
            if self._reader is None:
                raise StopIteration
            try:
                event = self._reader.event(self.patience)
                if isinstance(event, Sweep):
                    self.arrival = event.arrival
                    return event.scan
                failures += 1
                self._recover(event, failures)
            except DriverError as error:
                if not self.reconnect:
                    raise
                self._reconnect(error)
                failures = 0

    # What its protocol's driver uses.

    @property
    def reader(self) -> Reader:
        """The open port's reader.

        Raises
        ------
        DriverError
            If the driver is closed.
        """
        if self._reader is None:
            raise DriverError(f"{self.port}: the driver is closed; open it first")
        return self._reader

    def _ask(
        self,
        request: bytes,
        match: Callable[[object], Reply | None],
        timeout: float,
        *,
        tries: int = 3,
        gap: float = 0.0,
    ) -> Reply | None:
        """Send a request until a reply matches; None if none does within `timeout` [s] a try."""
        for _ in range(tries):
            self.reader.forget()
            self.reader.write(request, gap)
            reply = self.reader.reply(match, timeout)
            if reply is not None:
                return reply
        return None

    def _no_answer(self, wanted: str) -> DriverError:
        """Return the error for a device that does not answer as `wanted`; it names what does."""
        heard = bytes(self.reader.heard)
        if not heard:
            return DriverTimeoutError(
                f"{self.port}: expected {wanted}, got silence: check that it has power, that the "
                "cable is the right one and that this is its port"
            )
        return ProtocolError(f"{self.port}: expected {wanted}, got {identify(heard)}")

    # How it is done.

    def _connect(self) -> None:
        name = self.port if self._usb is None else find_port(self._usb) or self.port
        port = Port(name, self.baud or self.usual_baud)
        self._usb = self._usb or usb_identity(name)
        self._reader = Reader(port, self.decoder(), self.buffer, self.tap)
        try:
            self._start()
        except (DriverTimeoutError, ProtocolError) as error:
            other = None if self.losses.frames else self._other_device()
            self.close()
            if other is None:
                raise
            raise ProtocolError(
                f"{self.port}: expected a device for {self.protocol}:, got {other}"
            ) from error
        except BaseException:
            self.close()
            raise

    def _other_device(self) -> str | None:
        """Name the device of another protocol that is at the port; None: not there, or named."""
        before = bytes(self.reader.heard)
        if is_known(before):
            return None
        try:
            name = ask_around(self.reader)
        except DriverError:
            return None
        known = name is not None and is_known(bytes(self.reader.heard))
        if before and not known:  # what it said unasked tells more
            return None
        return None if name is None or f"({self.protocol}:)" in name else name

    def _disconnect(self) -> None:
        reader, self._reader = self._reader, None
        if reader is not None:
            reader.stop()

    def _recover(self, event: Event | None, failures: int) -> None:
        """Start a silent or halted device again without opening its port anew."""
        if isinstance(event, Halt):
            reason = event.reason
        else:
            reason = f"no scan for {self.patience:.1f} s"
            self.losses.silences += 1
        self.losses.problem = reason
        if failures > RESTARTS:
            raise self._no_answer(f"scans ({reason})")
        log.warning("%s: %s: starting the sweep again", self.port, reason)
        self.losses.restarts += 1
        self.reader.forget()
        self.reader.heard.clear()
        try:
            self._start()
        except DeviceLostError:
            raise
        except DriverError:
            if failures == RESTARTS:
                raise

    def _reconnect(self, error: DriverError) -> None:
        """Wait until the device is back, then go on with it."""
        self.losses.problem = str(error)
        log.warning("%s: waiting for the device", error)
        while True:
            self._disconnect()
            time.sleep(PAUSE)
            try:
                self._connect()
            except DriverError as still:
                log.debug("%s: still waiting", still)
                continue
            self.losses.reconnects += 1
            return
