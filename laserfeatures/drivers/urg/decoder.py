"""From a sensor's bytes to scans and replies."""

from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.drivers.decoder import Event, Halt, Sweep
from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.urg import statuses
from laserfeatures.drivers.urg.clock import WRAP, Clock
from laserfeatures.drivers.urg.commands import Measurement, decode_measurement
from laserfeatures.drivers.urg.framing import Framer
from laserfeatures.drivers.urg.ranges import block_size, decode_block, decode_time, time_of
from laserfeatures.drivers.urg.scip import KEYED, LF, Reply, decode_line, decode_reply
from laserfeatures.drivers.urg.sensor import Geometry, decode_fields, decode_geometry, with_speed
from laserfeatures.errors import ProtocolError
from laserfeatures.scan import LaserScan

LEAP = 10.0  # [s] that a sensor's clock may go farther than the host's from scan to scan
STUCK = 3  # scans in a row with an impossible time
STATUS_LINE = 4  # bytes: two characters, sum, line feed
TIME_LINE = 6
LONGEST_COMMAND = 64


@dataclass(frozen=True)
class RawScan:
    """A scan as the sensor sends it.

    Parameters
    ----------
    measurement : Measurement
        The command that it answers.
    time : int
        The sensor's clock [ms] at step 0.
    values : (N,) int array
        Ranges [mm] and error codes.
    """

    measurement: Measurement
    time: int
    values: IntArray


def decode_scan(frame: bytes) -> RawScan:
    """Return the scan that a reply with data, from its echo to its empty line, holds.

    Raises
    ------
    ProtocolError
        If it is none, a sum is wrong, or it has another number of values than its echo says.
    """
    echo, _, rest = frame.partition(LF)
    measurement = decode_measurement(echo)
    status = statuses.DATA if measurement.streams else statuses.ACCEPTED
    if decode_line(rest[: STATUS_LINE - 1], 2) != status or rest[3:4] != LF:
        raise ProtocolError(f"SCIP scan: expected status {status!r}, got {rest[:STATUS_LINE]!r}")
    size = block_size(measurement.values, measurement.characters)
    wanted = STATUS_LINE + TIME_LINE + size + 1
    if len(rest) != wanted or not rest.endswith(LF + LF):
        raise ProtocolError(f"SCIP scan {echo!r}: expected {wanted} bytes, got {len(rest)}")
    time = decode_time(rest[STATUS_LINE : STATUS_LINE + TIME_LINE - 1])
    if rest[STATUS_LINE + TIME_LINE - 1 : STATUS_LINE + TIME_LINE] != LF:
        raise ProtocolError(f"SCIP scan {echo!r}: expected a line feed after the time")
    block = rest[STATUS_LINE + TIME_LINE : -1]
    values = decode_block(block, measurement.values, measurement.characters)
    return RawScan(measurement, time, values)


def decode_message(frame: bytes) -> RawScan | Reply:
    """Return the scan or other reply that a frame holds.

    Raises
    ------
    ProtocolError
        If it is none.
    """
    head, _, rest = frame.partition(LF)
    if head[:2] in {b"MD", b"MS", b"GD", b"GS"}:
        status = statuses.DATA if head[:1] == b"M" else statuses.ACCEPTED
        if rest[:2] == status:
            return decode_scan(frame)
    reply = decode_reply(frame)
    if reply.lines and reply.echo[:2] not in (KEYED | {b"TM"}) and len(reply.status) > 1:
        raise ProtocolError(f"SCIP reply {reply.echo[:40]!r}: expected no lines in it")
    return reply


class UrgDecoder:
    """Decodes what a sensor sends.

    Parameters
    ----------
    losses : Losses
        Where damage is counted.

    Attributes
    ----------
    geometry : Geometry or None
        As the sensor told it last.
    """

    def __init__(self, losses: Losses) -> None:
        self.losses = losses
        self._framer = Framer(losses)
        self._clock = Clock()
        self.reset()

    def reset(self) -> None:
        """Forget what is half received and what is known of the sensor."""
        self._framer.reset()
        self._clock.forget()
        self._outgoing = bytearray()
        self.geometry: Geometry | None = None
        self._angles: tuple[Measurement, Geometry, FloatArray] | None = None
        self._command: Measurement | None = None
        self._begin()

    def _begin(self) -> None:
        """Begin a stream: the scan before it tells nothing."""
        self._last: tuple[int, float] | None = None  # time [ms] and arrival of the last scan
        self._doubtful = 0

    def sent(self, data: bytes, time: float) -> None:
        """Take note of the commands that the host sent."""
        self._outgoing += data
        *lines, rest = self._outgoing.split(LF)
        self._outgoing = rest[-LONGEST_COMMAND:]
        for line in lines:
            self._note(bytes(line), time)

    def _note(self, command: bytes, time: float) -> None:
        letters = command[:2]
        if letters in {b"MD", b"MS", b"GD", b"GS"}:
            try:
                self._command = decode_measurement(command)
            except ProtocolError:  # the host's error, which the sensor will answer
                self._command = None
            if letters[:1] == b"M":
                self._begin()
        elif letters in {b"QT", b"RS", b"RT"}:
            self._command = None
        elif command == b"TM0":
            self._clock.forget()
        elif command == b"TM1":
            self._clock.ask(time)

    def received(self, data: bytes, time: float) -> list[Event | Reply | RawScan]:
        """Return the scans, halts and replies that have become whole."""
        found: list[Event | Reply | RawScan] = []
        for message, arrival in self._framer.take(data, time, decode_message):
            if isinstance(message, RawScan):
                found += self._scan(message, arrival)
            else:
                found += self._reply(message, arrival)
        return found

    def _reply(self, reply: Reply, arrival: float) -> list[Event | Reply | RawScan]:
        letters = reply.echo[:2]
        try:
            if reply.status == statuses.ACCEPTED:
                self._learn(letters, reply, arrival)
        except ProtocolError as error:
            self.losses.damaged += 1
            self.losses.problem = str(error)
            return []
        if letters not in {b"MD", b"MS"} or reply.status == statuses.ACCEPTED:
            return [reply]
        return [reply, *self._interruption(reply)]

    def _learn(self, letters: bytes, reply: Reply, arrival: float) -> None:
        """Keep what a reply tells of the sensor."""
        if letters == b"PP":
            self.geometry = decode_geometry(reply.lines)
        elif letters == b"II" and self.geometry is not None:
            self.geometry = with_speed(self.geometry, decode_fields(reply.lines))
        elif reply.echo == b"TM1":
            if len(reply.lines) != 1:
                raise ProtocolError(f"SCIP TM1: expected one line, got {len(reply.lines)}")
            self._clock.answer(time_of(reply.lines[0]), arrival)

    def _interruption(self, reply: Reply) -> list[Event]:
        """Say whether a stream's reply without data ends it."""
        if reply.status == statuses.RESUMED or self._command is None:
            return []
        self.losses.refusals += 1
        meaning = statuses.meaning(reply.echo, reply.status)
        self.losses.problem = f"status {reply.status.decode('latin-1')}: {meaning}"
        return [Halt(self.losses.problem)] if statuses.is_fault(reply.status) else []

    def _scan(self, raw: RawScan, arrival: float) -> list[Event | Reply | RawScan]:
        """Make a scan of what answers our command; another host's is a reply like any."""
        if self.geometry is None or self._command is None:
            return [raw]
        if not raw.measurement.answers(self._command):
            return [raw]
        if raw.measurement.last - raw.measurement.first >= self.geometry.steps:
            return [raw]
        if raw.measurement.streams:
            doubt = self._doubt(raw.time, arrival)
            if doubt:
                return self._refuse(doubt)
            self._count_missed(raw)
            self._doubtful = 0
            self._last = (raw.time, arrival)
        return [self._sweep(raw, arrival, self.geometry)]

    def _doubt(self, time: int, arrival: float) -> str | None:
        """Say why a scan cannot have this time [ms]; None: it can."""
        if self._last is None:
            return None
        passed = _passed(self._last[0], time) / 1000
        if passed == 0:
            return "its clock stands still: the same time stamp came again"
        if not 0 < passed <= arrival - self._last[1] + LEAP:
            return f"a time stamp {passed:+.3f} s after the one before"
        return None

    def _refuse(self, doubt: str) -> list[Event | Reply | RawScan]:
        self.losses.damaged += 1
        self.losses.problem = doubt
        self._doubtful += 1
        if self._doubtful < STUCK:
            return []
        self._begin()
        return [Halt(f"{doubt} ({STUCK} times in a row)")]

    def _count_missed(self, raw: RawScan) -> None:
        """Count the scans that the sensor has made since the last one that came."""
        if self._last is not None and self.geometry is not None:
            passed = _passed(self._last[0], raw.time) / 1000
            every = self.geometry.period * (raw.measurement.skip + 1)
            self.losses.missed += max(round(passed / every) - 1, 0)

    def _sweep(self, raw: RawScan, arrival: float, geometry: Geometry) -> Sweep:
        measurement = raw.measurement
        self._clock.guess(raw.time, arrival - measurement.last * geometry.step_time)
        turned = self._clock.host_time(raw.time, arrival)
        self._clock.follow(turned, arrival)
        ranges = np.where(raw.values < geometry.shortest, np.nan, raw.values / 1000)
        scan = LaserScan(
            angles=self._angles_of(measurement, geometry),
            ranges=ranges,
            range_min=geometry.shortest / 1000,
            range_max=geometry.range_max(measurement),
            stamp=turned + measurement.first * geometry.step_time,
        )
        return Sweep(scan, arrival)

    def _angles_of(self, measurement: Measurement, geometry: Geometry) -> FloatArray:
        """Return the angles [rad] of a scan, one array for all scans of a stream."""
        if self._angles is None or self._angles[:2] != (measurement, geometry):
            angles = geometry.angles(measurement)
            angles.flags.writeable = False
            self._angles = (measurement, geometry, angles)
        return self._angles[2]


def _passed(before: int, now: int) -> int:
    """Return the time [ms] between two readings of a clock that wraps, negative if it went back."""
    return (now - before + WRAP // 2) % WRAP - WRAP // 2
