"""The URG, emulated."""

import re
from collections import deque
from collections.abc import Mapping
from random import Random
from typing import ClassVar, get_args

from laserfeatures.drivers.urg.commands import Measurement, decode_measurement
from laserfeatures.emulators.device import Device
from laserfeatures.emulators.faults import Faults
from laserfeatures.emulators.feed import Feed
from laserfeatures.emulators.urg.answers import answer, scan_body, scan_frame, stream_frame
from laserfeatures.emulators.urg.models import MODELS
from laserfeatures.emulators.urg.state import Mode, State
from laserfeatures.emulators.urg.view import View
from laserfeatures.registry import near_names

STATES: tuple[Mode, ...] = get_args(Mode)
TROUBLES = ("check", "failure", "frozen", "split")
LATENCY = 0.001  # [s] of an answer while the laser is off
LATE = 3.0  # [s]; what could not be sent for so long is not sent any more
CHECK = 3  # turns that a check takes
LONGEST_COMMAND = 128
MOST_COMMANDS = 32

_LINE_END = re.compile(rb"[\r\n]")


class UrgDevice(Device):
    """A URG-04LX-UG01 or a classic URG-04LX.

    Parameters
    ----------
    feed, faults
        As `Device`.
    model : {"ug01", "classic"}
        The USB model, which begins in SCIP 2.0, or the one with a serial line at 19 200 Bd, which
        begins in SCIP 1.1.
    state : str or None
        What it is doing at first: one of `STATES`; None: what it does after power-on.
    stream : str
        The command of the stream that runs at first in the state "streaming".
    left_over : bytes
        The part of a command that another host has left in its buffer.
    baud : int or None
        Rate of the classic model's line at first [Bd]; None: as after power-on.
    clock_ms : int
        What its clock shows at first [ms]; it begins again at 16 777 216.
    troubles : mapping of str to float
        Probability that a scan meets with a trouble: "check" (status 21 instead, three turns of
        silence, status 98), "failure" (status 51 instead, laser off), "frozen" (the time stamp of
        the scan before), "split" (an answer that is due stands inside the scan).
    seed : int
        Seed of the troubles and of the error codes of no-returns.

    Raises
    ------
    ValueError
        If there is no such model, state, stream or trouble.
    """

    name: ClassVar[str] = "URG-04LX"

    def __init__(
        self,
        feed: Feed,
        faults: Faults | None = None,
        *,
        model: str = "ug01",
        state: Mode | None = None,
        stream: str = "MD0044072501000",
        left_over: bytes = b"",
        baud: int | None = None,
        clock_ms: int = 0,
        troubles: Mapping[str, float] | None = None,
        seed: int = 0,
    ) -> None:
        super().__init__(feed, faults)
        if model not in MODELS:
            raise ValueError(f"there is no model {model!r}; {near_names(model, MODELS)}")
        if state is not None and state not in STATES:
            raise ValueError(f"there is no state {state!r}; {near_names(state, STATES)}")
        for name in troubles or {}:
            if name not in TROUBLES:
                raise ValueError(f"there is no trouble {name!r}; {near_names(name, TROUBLES)}")
        self._model = MODELS[model]
        self._first = (state, decode_measurement(stream.encode()), left_over, baud, clock_ms)
        self._troubles = dict(troubles or {})
        self._random = Random(seed)  # noqa: S311 - for tests, not for secrets
        self._view = View(self._model.geometry, feed, seed)
        self._fresh = True
        self.power_on(0.0)

    def power_on(self, now: float) -> None:
        """Begin in SCIP 2.0 or 1.1; the first time in the state that the user wants."""
        self.hush()
        mode: Mode = "scip1" if self._model.old else "idle"
        self.state = State(self._model, mode, 0.0, now, baud=self._model.baud)
        self._heard = b""
        self._commands: deque[tuple[float, bytes]] = deque()
        self._answered = now  # when
        self._turn = -1  # the last one that something was done in
        self._stamp = 0
        self._split_now = False
        if self._fresh:
            self._begin_as_wanted()
        self.baud = self.state.baud

    def _begin_as_wanted(self) -> None:
        mode, stream, self._heard, baud, self.state.clock_ms = self._first
        if baud is not None and self._model.baud is not None:
            self.state.baud = baud
        if mode is not None:
            self.state.light(mode)
        if mode == "streaming":
            self.state.stream, self.state.left = stream, stream.count

    def hear(self, data: bytes, now: float) -> None:
        """Take commands; each waits until its line is whole and those before it are answered."""
        self._fresh = False
        *lines, rest = _LINE_END.split(self._heard + data)
        self._heard = rest[-LONGEST_COMMAND:]
        for line in lines:
            if line and len(self._commands) < MOST_COMMANDS:
                self._commands.append((now, line))

    def next_event(self) -> float:
        """Return when the next answer or scan is due."""
        if self.state.pending_baud is not None and not self._waiting:
            return 0.0
        if self.state.stream is not None:
            return self.state.turn_end(self._turn + 1)
        if not self._commands:
            return float("inf")
        heard = self._commands[0][0]
        if self.state.laser:  # one answer a turn
            return self.state.turn_end(max(self.state.next_turn(heard), self._turn + 1))
        return max(heard, self._answered) + LATENCY

    def advance(self, now: float) -> None:
        """Answer and send scans."""
        while (at := self.next_event()) <= now:
            if self.state.pending_baud is not None and not self._waiting:
                self.baud = self.state.baud = self.state.pending_baud
                self.state.pending_baud = None
            elif self.state.laser:
                self._end_turn(at, now)
            else:
                self._answer(at)

    def _answer(self, at: float) -> None:
        _, line = self._commands.popleft()
        self._answered = at
        before = self.state.laser
        reply = answer(self.state, line, at, self._latest)
        if self.state.laser and not before:
            self._turn = self.state.next_turn(at) - 1
        self.say(reply, at)

    def _end_turn(self, at: float, now: float) -> None:
        """Do what is due at the end of a turn: one answer, one scan."""
        self._turn = self.state.next_turn(at - self.state.period / 2)
        asked = bool(self._commands) and self._commands[0][0] <= at
        if asked and not self._splits():
            self._answer(at)
        stream = self.state.stream
        if stream is None or self._turn < self.state.begin or now - at > LATE:
            return
        if self.state.checking:
            self._check(at)
        elif (self._turn - self.state.begin) % (stream.skip + 1) == 0:
            busy = self.baud is not None and self._waiting
            if not busy:
                self._send(stream, at)

    def _send(self, stream: Measurement, at: float) -> None:
        """Send a scan, or what comes in its place."""
        if self._happens("check"):
            self.state.checking = CHECK
            self.say(stream_frame(self.state, b"21"), at)
            return
        if self._happens("failure"):
            frame = stream_frame(self.state, b"51")
            self.state.light("idle")
            self.say(frame, at)
            return
        if not self._happens("frozen"):
            self._stamp = self.state.clock(self.state.turn_begin(self._turn))
        turn = self._view.turns
        self.state.left = max(self.state.left - 1, 0)
        frame = scan_frame(self.state, self._stamp, self._view.values(self._view.look(), stream))
        if stream.count and not self.state.left:
            self.state.light("idle")
        if self._split_now:
            frame = self._split(frame, at)
        self.say(frame, at, turn)

    def _check(self, at: float) -> None:
        self.state.checking -= 1
        if not self.state.checking:
            self.say(stream_frame(self.state, b"98"), at)

    def _latest(self, measurement: Measurement) -> bytes:
        time = self.state.clock(self.state.turn_begin(self._turn))
        values = self._view.values(self._view.look(), measurement)
        return scan_body(time, values, measurement.characters)

    def _happens(self, trouble: str) -> bool:
        return self._random.random() < self._troubles.get(trouble, 0.0)

    def _splits(self) -> bool:
        """Return whether the answer that is due is to stand inside the next scan."""
        stream, line = self.state.stream, self._commands[0][1]
        self._split_now = stream is not None and line[:2] == b"II" and self._happens("split")
        return self._split_now

    def _split(self, frame: bytes, at: float) -> bytes:
        """Return a scan with the answer in its middle."""
        self._split_now = False
        _, line = self._commands.popleft()
        middle = self._random.randrange(len(frame) // 3, len(frame) - 2)
        return frame[:middle] + answer(self.state, line, at, self._latest) + frame[middle:]
