"""An emulated SICK LMS2xx: power, modes, rates and what it answers."""

import heapq
import math
from collections.abc import Callable
from random import Random
from typing import ClassVar, Literal

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.telegrams import (
    ACK,
    FROM_SCANNER,
    NAK,
    OK,
    Telegram,
    pack,
    parse_request,
)
from laserfeatures.emulators.device import BITS, Device
from laserfeatures.emulators.faults import Faults
from laserfeatures.emulators.feed import Feed
from laserfeatures.emulators.lms.answers import Answers, Reply, State
from laserfeatures.emulators.lms.hearing import Hearing
from laserfeatures.emulators.lms.measuring import Measuring, Order
from laserfeatures.emulators.lms.memory import Memory
from laserfeatures.errors import ProtocolError

RESET_TIME = 0.01  # [s] from the reply to the reset
SWITCHING = 0.002  # [s] between a reply and the change of the rate that it agrees to
UNCHANGED = 0.05  # [s]; what the EEPROM takes to be written with what it holds: a real one did
LATE = 0.1  # [s]; scans later than that are left out
EVERY = 1e-9  # of a scan time: what rounding may add

Start = Literal["idle", "booting", "streaming", "half_telegram", "installation"]


class LmsDevice(Device):
    """An LMS200, LMS211, LMS220, LMS221 or LMS291 (type 6) at the end of a serial line.

    Parameters
    ----------
    feed : callable
        What it sees: from the angles of a turn to the ranges.
    faults : Faults
        What goes wrong with its telegrams.
    memory : Memory
        Its type, and its EEPROM with the counter of writes.
    start : str
        In what state it is found: "idle"; "booting"; "streaming" or in "installation" mode, left so
        by an earlier host; "half_telegram": it stopped in the middle of one.
    baud : int or None
        Rate of its line when found [Bd]; None: that of power-on.
    start_up : float
        Time from power-on to the telegram 90 [s]; about 30 for a real one, 60 at most.
    ack_delay : float
        Time from a request to its 06 [s]; a real one takes 10 to 60 ms.
    reply_delay : float
        Time from the 06 to the reply [s].
    write_time : float
        What a change of the EEPROM takes beside [s]; a real one up to 7.
    byte_gap : float
        Time between two bytes of the host after which a half request is dropped [s].
    deaf : float
        Probability that it misses a request, as it may.
    status : int
        The status byte: 0x10 all is well, 0x11 to 0x14 info to fatal error, with 0x40 for
        implausible values and 0x80 for a dirty window.
    address : int
        Its own, which it obeys beside the broadcast.
    reply_address : int
        In its telegrams: 0x80, or 0x81 as some are said to send.
    bad_crc : float
        Probability that a telegram of values has a wrong checksum.
    lookalike : bool
        Whether the bytes of a whole reply stand among the values.
    glued : bool
        Whether two telegrams of values always come in one piece.
    hangs_after : int or None
        After so many telegrams of values half of one comes, then no more until the next request.
    seed : int
        Of its randomness.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, 2006; timing of a real LMS200-S18063.
    """

    name: ClassVar[str] = "LMS2xx"

    def __init__(
        self,
        feed: Feed,
        faults: Faults | None = None,
        *,
        memory: Memory | None = None,
        start: Start = "idle",
        baud: int | None = None,
        start_up: float = 0.5,
        ack_delay: float = 0.012,
        reply_delay: float = 0.045,
        write_time: float = 0.2,
        byte_gap: float = 0.006,
        deaf: float = 0.0,
        status: int = OK,
        address: int = 1,
        reply_address: int = FROM_SCANNER,
        bad_crc: float = 0.0,
        lookalike: bool = False,
        glued: bool = False,
        hangs_after: int | None = None,
        seed: int = 0,
    ) -> None:
        super().__init__(feed, faults)
        self.memory = memory or Memory()
        self.status = status
        self._start, self._first_baud = start, baud
        self._start_up = start_up
        self._ack_delay, self._reply_delay, self._write_time = ack_delay, reply_delay, write_time
        self._deaf, self._bad_crc, self._glued = deaf, bad_crc, glued
        self._reply_address, self._hangs_after = reply_address, hangs_after
        self._random = Random(seed)  # noqa: S311 - for tests, not for secrets
        self._hearing = Hearing(byte_gap, address)
        self._answers = Answers(self.memory)
        self._measuring = Measuring(feed, self.memory, lookalike=lookalike)
        self._events: list[tuple[float, int, Callable[[float], None]]] = []
        self._lives = self._count = self._turns = self._values_waiting = 0
        self._booting = False
        self.mode = requests.ON_REQUEST
        self._next_scan = math.inf
        self.baud: int = self.memory.baud

    def power_on(self, now: float) -> None:
        """Start up; the first time, be found in the state that was asked for."""
        start, baud = self._start, self._first_baud
        self._start, self._first_baud = "booting", None
        self._lives += 1
        self._events.clear()
        self.hush()
        self._hearing.forget()
        self.mode, self._next_scan = requests.ON_REQUEST, math.inf
        self.baud = baud or self.memory.baud
        self._booting = start == "booting"
        if self._booting:
            self._later(now + self._start_up, self._started_up)
        elif start == "installation":
            self.mode = requests.INSTALLATION
        elif start == "streaming":
            self._enter(requests.STREAM, now, Order())
        elif start == "half_telegram":
            telegram = self._packed(self._measuring.telegram(now, self.status))
            self.say(telegram[: len(telegram) // 2], now)

    def hear(self, data: bytes, now: float) -> None:
        """Take bytes of the host."""
        if self._booting:
            return
        for request in self._hearing.take(data, now):
            if self._random.random() >= self._deaf:
                self._obey(request, now + len(request) * BITS / self.baud)

    def advance(self, now: float) -> None:
        """Send the scans that are due, and change what is to change after a reply."""
        while (time := self.next_event()) <= now:
            if self._events and self._events[0][0] == time:
                _, _, action = heapq.heappop(self._events)
                action(time)
            elif now - time > LATE:
                self._schedule(now)
            else:
                self._send_scan(time)

    def next_event(self) -> float:
        """Return when something is due."""
        return min(self._next_scan, self._events[0][0] if self._events else math.inf)

    # Power and events.

    def _later(self, at: float, action: Callable[[float], None]) -> None:
        self._count += 1
        heapq.heappush(self._events, (at, self._count, action))

    def _started_up(self, now: float) -> None:
        self._booting = False
        name = Telegram(requests.POWERED_ON, self.memory.device_type, self.status)
        self.say(self._packed(name), now)

    def _packed(self, telegram: Telegram) -> bytes:
        return pack(Telegram(telegram.command, telegram.data, telegram.status, self._reply_address))

    # Requests.

    def _obey(self, request: bytes, now: float) -> None:
        """Answer a request; it cuts off whatever is being sent."""
        self._cut_off()
        self._next_scan = math.inf
        life, answer_at = self._lives, now + self._ack_delay
        try:
            command, data = parse_request(request)
        except ProtocolError:
            self.say(bytes([NAK]), answer_at)
            self._go_on(answer_at)
            return
        reply = self._answers.to(command, data, State(self.mode, self.baud, self._measuring.fits))
        self.say(bytes([ACK]), answer_at)
        writing = self._write_time if reply.changes else UNCHANGED if reply.writes else 0.0
        at = answer_at + self._reply_delay + writing
        self.memory.writes += reply.writes
        if reply.measures is not None:
            self._measuring.begin(reply.measures)
            at += self._measuring.scan_time
            self._send_values(at, at)
            return
        telegram = self._packed(Telegram(reply.command, reply.data, self.status))
        self.say(telegram, at)
        if life == self._lives:  # it has not lost its power while it spoke
            self._later(at + len(telegram) * BITS / self.baud, lambda end: self._after(reply, end))

    def _after(self, reply: Reply, now: float) -> None:
        """Do what was agreed to."""
        if (reply.baud is not None or reply.resets) and self._waiting:  # it is still being said
            self._later(now + SWITCHING, lambda later: self._after(reply, later))
            return
        if reply.baud is not None:
            self.baud = reply.baud
        if reply.resets:
            self._later(now + RESET_TIME, self.power_on)
        if reply.mode is not None:
            self._enter(reply.mode, now, reply.order)
        else:
            self._go_on(now)

    def _enter(self, mode: int, now: float, order: Order | None) -> None:
        self.mode, self._next_scan = mode, math.inf
        if order is not None:
            self._measuring.begin(order)
            self._schedule(now + self._measuring.scan_time)

    def _go_on(self, now: float) -> None:
        """Go on with the stream that a request has interrupted."""
        if self.mode in requests.STREAMS:
            self._schedule(now)

    def _cut_off(self) -> None:
        waiting = min(len(self._waiting), self._values_waiting)
        for i in range(1, waiting + 1):
            self.frames[-i] = (self.frames[-i][0], "cut off by a request")
        self.hush()
        self._values_waiting = 0

    # Scans.

    def _schedule(self, now: float) -> None:
        """Let the next scan begin to go out when a scan is complete."""
        period = self._measuring.scan_time
        self._next_scan = math.ceil(now / period - EVERY) * period

    def _send_scan(self, at: float) -> None:
        """Send the scan that is complete, and wait for the first one after the line is free."""
        if at < self._stuck_until:
            self._schedule(self._stuck_until)
            return
        life, period = self._lives, self._measuring.scan_time
        pieces = [at - period, at] if self._glued else [at]
        size = sum(self._send_values(piece, at) for piece in pieces)
        if life != self._lives:  # it has lost its power while it sent
            return
        whole = math.ceil(size * BITS / self.baud / period - EVERY)
        self._next_scan = at + max(whole, len(pieces)) * period
        if self._hangs_after is not None and self._turns > self._hangs_after:
            self._next_scan, self._hangs_after = math.inf, None

    def _send_values(self, measured: float, at: float) -> int:
        """Send what was measured until a time; return the size."""
        data = self._packed(self._measuring.telegram(measured, self.status))
        own_fault = None
        if self._random.random() < self._bad_crc:
            data, own_fault = data[:-1] + bytes([data[-1] ^ 1]), "bad_crc"
        if self._turns == self._hangs_after:
            data, own_fault = data[: len(data) // 2], "hangs"
        self.say(data, at, self._turns)
        if own_fault:
            self.frames[-1] = (self._turns, own_fault)
        self._turns += 1
        self._values_waiting = 2 if self._glued else 1
        return len(data)
