"""The driver of SCIP 2.0 sensors."""

import logging
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import ClassVar

from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.port import URL_MARK
from laserfeatures.drivers.urg import statuses
from laserfeatures.drivers.urg.commands import KINDS, Kind, Measurement
from laserfeatures.drivers.urg.decoder import UrgDecoder
from laserfeatures.drivers.urg.ranges import block_size
from laserfeatures.drivers.urg.scip import LF, OLD_REFUSAL, Reply, answer_to
from laserfeatures.drivers.urg.sensor import Geometry, decode_fields, decode_geometry, with_speed
from laserfeatures.errors import DeviceLostError, DriverError, DriverTimeoutError
from laserfeatures.scan import LaserScan

RATES = (19_200, 57_600, 115_200, 250_000, 500_000, 750_000)  # [Bd] of a classic URG-04LX
BITS = 10  # on the line for a byte
ANSWER = 0.25  # [s]; a sensor answers once a turn, and two turns are 0.2 s
LARGEST_REPLY = 2200  # bytes; a scan that is on its way comes before the answer
TRIES = 4
SPEEDS = {*range(11), 99}
OK = frozenset({statuses.ACCEPTED})

log = logging.getLogger("laserfeatures.drivers")


@dataclass(kw_only=True, eq=False)
class Urg(Driver):
    """A Hokuyo that speaks SCIP 2.0: URG-04LX-UG01, URG-04LX and later ones.

    Geometry and limits are what the sensor tells. Opening takes it over in any state: idle,
    measuring, streaming, in time stamp mode, in SCIP 1.1, at another baud rate.

    Parameters
    ----------
    mode : {"MD", "MS", "GD", "GS"}
        MD streams scans; MS, too, in less bytes, with ranges below 4.095 m. GD and GS fetch one
        whenever the next is asked for.
    first, last : int or None
        First and last step, both included; None: all that the sensor measures.
    cluster : int
        How many neighbouring steps become one beam, with the shortest of their ranges; 1 to 99.
    skip : int
        How many turns are left out after each scan, 0 to 9.
    high_sensitivity : bool or None
        Whether weak returns count, too; None: as it is.
    motor_speed : int or None
        0 the usual speed, 1 to 10 ever slower, 99 as at power-on; None: as it is.
    reset : bool
        Whether to put the sensor's speed, rate, sensitivity and clock to their defaults first.
    clock_samples : int
        How often its clock is read to find the offset to the host's; 0: scans are timed by their
        arrival.

    Attributes
    ----------
    geometry : Geometry or None
        What the sensor says of itself (PP), when it is open.
    version : dict of str to str
        Its maker, product, firmware, protocol and serial number (VV).

    Raises
    ------
    ValueError
        If a parameter makes no sense.

    References
    ----------
    Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B.
    """

    protocol: ClassVar[str] = "urg"
    usual_baud: ClassVar[int] = 115_200

    mode: Kind = "MD"
    first: int | None = None
    last: int | None = None
    cluster: int = 1
    skip: int = 0
    high_sensitivity: bool | None = None
    motor_speed: int | None = None
    reset: bool = False
    clock_samples: int = 11
    geometry: Geometry | None = field(init=False, default=None, repr=False)
    version: dict[str, str] = field(init=False, default_factory=dict, repr=False)
    _taken: bool = field(init=False, default=False, repr=False)
    _home: int | None = field(init=False, default=None, repr=False)  # rate to put back [Bd]
    _fetching: bool = field(init=False, default=False, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        if self.mode not in KINDS:
            raise ValueError(f"mode must be one of {', '.join(KINDS)}, got {self.mode!r}")
        for name, low, high in (("cluster", 1, 99), ("skip", 0, 9), ("clock_samples", 0, 64)):
            if not low <= getattr(self, name) <= high:
                raise ValueError(f"{name} must be in {low}..{high}, got {getattr(self, name)}")
        for name in ("first", "last"):
            step = getattr(self, name)
            if step is not None and not 0 <= step <= 9999:
                raise ValueError(f"{name} must be in 0..9999, got {step}")
        if None not in {self.first, self.last} and not (self.first or 0) <= (self.last or 0):
            raise ValueError(f"last must be >= first, got {self.last} < {self.first}")
        if self.motor_speed is not None and self.motor_speed not in SPEEDS:
            raise ValueError(f"motor_speed must be in 0..10 or 99, got {self.motor_speed}")

    def decoder(self) -> UrgDecoder:
        """Return a new decoder."""
        return UrgDecoder(self.losses)

    @property
    def patience(self) -> float:
        """How long the next scan may take [s]: some turns, and its way over the line."""
        period = self.geometry.period if self.geometry else 0.1
        scan = self._measurement()
        way = block_size(scan.values, scan.characters) * BITS / self.reader.port.baud
        return max(1.0, 4 * (self.skip + 1) * period) + 2 * way

    def __next__(self) -> LaserScan:
        """Wait for the next scan; with GD and GS fetch it."""
        if self._reader is not None and not self._measurement().streams and not self._fetching:
            with suppress(DeviceLostError):  # waiting for the scan says so
                self._fetch()
        try:
            return super().__next__()
        finally:
            self._fetching = False

    def _start(self) -> None:
        self._take_over()
        if self.reset:
            self._command(b"RS", {statuses.ACCEPTED})
            self._take_over()
        self.version = self._told(b"VV")
        log.info("%s: %s", self.port, self.version)
        self.geometry = decode_geometry(self._command(b"PP").lines)
        self._set_rate()
        self._set_motor(self.geometry)
        if self.high_sensitivity is not None:
            self._command(b"HS%d" % self.high_sensitivity, {statuses.ACCEPTED, b"02"})
        self._read_clock()
        if self._measurement().streams:
            self._stream()
        else:
            self._command(b"BM", {statuses.ACCEPTED, b"02"})
            self._fetch()

    def _stop(self) -> None:
        if not self._taken:
            return
        self._taken = False
        home, self._home = self._home, None
        if self._quit() is not None and home is not None:
            self._command(b"SS%06d" % home)

    # Taking it over.

    def _take_over(self) -> None:
        """Find the rate at which the sensor listens, and bring it to wait for commands."""
        for rate in self._rates():
            if rate != self.reader.port.baud:
                self.reader.port.baud = rate
            if self._quit() is not None:
                self._taken = True
                return
        raise self._no_answer("a Hokuyo that answers QT and VV")

    def _rates(self) -> Iterator[int]:
        rate = self.reader.port.baud
        yield rate
        if URL_MARK not in self.port:
            yield from (other for other in RATES if other != rate)

    def _quit(self) -> Reply | None:
        """Stop all that the sensor does, whatever it is; None: no answer.

        A stream is not waited for: it may never pause.
        """
        for _ in range(TRIES):
            reply = self._ask(b"QT" + LF, answer_to(b"QT"), self._answer_time, tries=2)
            if reply is None or reply.status == statuses.ACCEPTED:
                return reply
            # Each of them is tried until it works; the next QT tells.
            wake = b"SCIP2.0" if reply.status == OLD_REFUSAL else b"TM2"
            self._ask(wake + LF, answer_to(wake), self._answer_time, tries=1)
        return None

    @property
    def _answer_time(self) -> float:
        """How long an answer may take [s]: a turn, and a scan that is on its way."""
        return ANSWER + LARGEST_REPLY * BITS / self.reader.port.baud

    # Setting it up.

    def _command(self, command: bytes, accepted: Collection[bytes] = OK) -> Reply:
        """Send a command and return its reply.

        Raises
        ------
        DriverError
            If it is refused; silence is a DriverTimeoutError, nonsense a ProtocolError.
        """
        reply = self._ask(command + LF, answer_to(command), self._answer_time, tries=TRIES)
        if reply is None:
            raise self._no_answer(f"a Hokuyo that answers {command.decode()}")
        if reply.status not in accepted:
            raise self._refusal(command, reply)
        return reply

    def _told(self, command: bytes) -> dict[str, str]:
        """Return what VV or II tells: nothing where it makes no sense, for only PP is needed."""
        try:
            return decode_fields(self._command(command).lines)
        except DeviceLostError:
            raise
        except DriverError as error:
            log.warning("%s: going on without what %s tells", error, command.decode())
            return {}

    def _refusal(self, command: bytes, reply: Reply) -> DriverError:
        if command[:1] != b"M":  # those the decoder counts
            self.losses.refusals += 1
        status, text = reply.status.decode("latin-1"), statuses.meaning(command, reply.status)
        message = f"{self.port}: the sensor answers {command.decode()} with status {status}: {text}"
        if self.geometry is not None and command[:1] in {b"M", b"G"}:
            message += f" (its steps are {self.geometry.first}..{self.geometry.last})"
        return DriverError(message)

    def _set_rate(self) -> None:
        """Bring sensor and port to the rate that the user wants."""
        port = self.reader.port
        if self.baud is None or port.baud == self.baud:
            return
        found = port.baud
        self._command(b"SS%06d" % self.baud, {statuses.ACCEPTED, b"03"})
        port.baud = self.baud
        self._home = self._home or found
        if self._quit() is None:
            raise DriverTimeoutError(
                f"{self.port}: the sensor answered at {found} Bd and accepted {self.baud} Bd, but "
                f"is silent there: leave out baud={self.baud}, or choose a slower rate"
            )

    def _set_motor(self, geometry: Geometry) -> None:
        if self.motor_speed is not None:
            self._command(b"CR%02d" % self.motor_speed, {statuses.ACCEPTED, b"03"})
            self.geometry = with_speed(geometry, self._told(b"II"))

    def _read_clock(self) -> None:
        """Let the decoder learn the offset of the sensor's clock, which needs time stamp mode."""
        if not self.clock_samples:
            return
        try:
            self._command(b"TM0", {statuses.ACCEPTED, b"02"})
            for _ in range(self.clock_samples):
                self._command(b"TM1")
        except DriverTimeoutError:
            raise
        except DriverError as error:
            log.warning("%s; the times of its scans are those of their arrival", error)
        self._ask(b"TM2" + LF, answer_to(b"TM2"), self._answer_time, tries=1)
        self._quit()  # which leaves that mode, too, should the answer have got lost

    def _measurement(self) -> Measurement:
        whole = self.geometry
        first, last = (whole.first, whole.last) if whole else (0, 9999)
        return Measurement(
            self.mode,
            first if self.first is None else self.first,
            last if self.last is None else self.last,
            self.cluster,
            self.skip if self.mode[0] == "M" else 0,
        )

    def _stream(self) -> None:
        """Start the stream; should only the answer have got lost, stop it and start it again."""
        command = self._measurement().encode()
        for _ in range(TRIES):
            reply = self._ask(command + LF, answer_to(command), self._answer_time, tries=1)
            if reply is None:
                self._quit()
            elif statuses.is_accepted_stream(reply.status):
                return
            else:
                raise self._refusal(command, reply)
        raise self._no_answer(f"a Hokuyo that answers {command.decode()}")

    def _fetch(self) -> None:
        self._fetching = True
        self.reader.write(replace(self._measurement(), count=0).encode() + LF)
