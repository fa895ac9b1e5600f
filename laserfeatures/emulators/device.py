"""An emulated rangefinder: a state machine that has neither a port nor a clock of its own."""

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator
from typing import ClassVar

from laserfeatures.emulators.faults import Faults
from laserfeatures.emulators.feed import Feed

BITS = 10  # on the wire for a byte: start, eight, stop
CHUNK = 0.002  # [s]; bytes on a slow line come in pieces of this length
SILENCING = {"stuck", "restart", "unplug"}  # faults that lose whole frames
GARBLED = 0x5A  # what a byte is mixed with when both ends differ in their baud rates


class Device(ABC):
    """One emulated rangefinder.

    A link (`emulators.link`) gives it the host's bytes and fetches its own; times are seconds on
    the link's clock, from 0.

    Parameters
    ----------
    feed : callable
        What it sees: from the angles of a turn to the ranges.
    faults : Faults
        What goes wrong with its frames.

    Attributes
    ----------
    baud : int or None
        Rate of its line now [Bd]; None: USB, where a rate has no meaning.
    frames : deque of (int, str or None)
        The scan frames sent: number of the turn, and the name of the fault that damaged it.
    """

    name: ClassVar[str]

    def __init__(self, feed: Feed, faults: Faults | None = None) -> None:
        self.feed = feed
        self.faults = faults or Faults()
        self.baud: int | None = None
        self.frames: deque[tuple[int, str | None]] = deque(maxlen=100_000)
        self._waiting: deque[tuple[float, bytes]] = deque()
        self._line_free = 0.0
        self._stuck_until = 0.0

    # What a protocol's device brings.

    @abstractmethod
    def power_on(self, now: float) -> None:
        """Begin as after power-on: forget every state that is not permanent."""

    @abstractmethod
    def hear(self, data: bytes, now: float) -> None:
        """Take bytes that the host sent at its own baud rate."""

    @abstractmethod
    def advance(self, now: float) -> None:
        """Do what is due by now, such as sending a scan; scans that are late are left out."""

    @abstractmethod
    def next_event(self) -> float:
        """Return the time at which `advance` has something to do; inf if only the host can tell."""

    # What it uses.

    def say(self, frame: bytes, at: float, turn: int | None = None) -> None:
        """Send a frame, as soon as the line is free after `at`.

        Parameters
        ----------
        frame : bytes
            What to send.
        at : float
            When its first byte is ready [s].
        turn : int, optional
            Number of the turn, if the frame is (part of) a scan.
        """
        stuck = at < self._stuck_until
        sent, lost = (frame, "stuck") if stuck else self.faults.damage(frame)
        if turn is not None:  # a first byte doubled, or garbage before it, leaves a frame whole
            whole = lost not in SILENCING and frame in sent
            self.frames.append((turn, None if whole else lost))
        if lost == "restart":
            self.power_on(at)
        elif lost == "stuck":
            self._stuck_until = max(self._stuck_until, at + self.faults.stuck_time * (not stuck))
            self._waiting.clear()
        else:
            self._waiting.append((at, sent))

    def hush(self) -> None:
        """Cut off what is being sent and drop what waits."""
        self._waiting.clear()

    # What a link calls.

    def due(self, now: float) -> float:
        """Return when `exchange` should be called next."""
        if not self._waiting:
            return self.next_event()
        at, frame = self._waiting[0]
        if self.baud is None:
            return min(at, self.next_event())
        begin = max(at, self._line_free)
        whole = begin + len(frame) * BITS / self.baud
        return min(whole, max(now, begin) + CHUNK, self.next_event())

    def take(self, now: float, host_baud: int | None = None) -> bytes:
        """Return the bytes that have gone over the line by now.

        Parameters
        ----------
        now : float
            The time [s].
        host_baud : int or None
            The rate at which the host listens; at another one than the device's it gets garbage.
        """
        self.advance(now)
        out = b"".join(self._sent_by(now))
        return bytes(byte ^ GARBLED for byte in out) if self._wrong(host_baud) else out

    def give(self, data: bytes, now: float, host_baud: int | None = None) -> None:
        """Take bytes from the host; at a wrong rate or while stuck they are lost."""
        if not self._wrong(host_baud) and now >= self._stuck_until:
            self.hear(data, now)

    def _wrong(self, host_baud: int | None) -> bool:
        return None not in {self.baud, host_baud} and host_baud != self.baud

    def _sent_by(self, now: float) -> Iterator[bytes]:
        while self._waiting and self._waiting[0][0] <= now:
            at, frame = self._waiting[0]
            if self.baud is None:
                self._waiting.popleft()
                yield frame
                continue
            begin = max(at, self._line_free)
            whole = int((now - begin) * self.baud / BITS)
            if whole <= 0:
                return
            piece, rest = frame[:whole], frame[whole:]
            self._line_free = begin + len(piece) * BITS / self.baud
            yield piece
            self._waiting.popleft()
            if rest:
                self._waiting.appendleft((at, rest))
                return
