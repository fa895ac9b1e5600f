"""What an emulated LMS2xx answers to each request, in which state."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.configuration import MEASURING_MODE, UNIT
from laserfeatures.drivers.lms.ranges import LAYOUTS
from laserfeatures.drivers.lms.requests import word
from laserfeatures.drivers.lms.status import BAUD_CODES, write_status
from laserfeatures.drivers.lms.telegrams import FROM_SCANNER
from laserfeatures.emulators.lms.measuring import Order, order_of
from laserfeatures.emulators.lms.memory import AT_DELIVERY, Memory

VARIANTS = {(180, 100), (180, 50), (100, 100), (100, 50), (100, 25)}
FAST_TYPE = b"S14"
OPEN_MODES = {
    requests.INSTALLATION: requests.PASSWORD,
    requests.DIAGNOSIS: b"",
    requests.ON_REQUEST: b"",
}
"""The modes without a stream, and what must follow to enter them."""

DONE, FAILED = b"\x00", b"\x01"  # in an A0
RATES = {code: baud for baud, code in requests.BAUDS.items()}


@dataclass(frozen=True, kw_only=True)
class Reply:
    """A reply, and what comes of it.

    Parameters
    ----------
    command : int
        Of the reply.
    data : bytes
        Of the reply.
    mode : int or None
        The operating mode from then on.
    order : Order or None
        What streams from then on.
    measures : Order or None
        What the reply itself is to carry.
    baud : int or None
        The rate from then on [Bd].
    resets : bool
        Whether the scanner resets itself.
    writes : bool
        Whether the EEPROM is written.
    changes : bool
        Whether it then holds something else.
    """

    command: int
    data: bytes = b""
    mode: int | None = None
    order: Order | None = None
    measures: Order | None = None
    baud: int | None = None
    resets: bool = False
    writes: bool = False
    changes: bool = False


REFUSED = Reply(command=requests.REFUSED)


@dataclass(frozen=True)
class State:
    """In what state a request comes.

    Parameters
    ----------
    mode : int
        Operating mode.
    baud : int
        Rate of the line [Bd].
    fits : callable
        Whether an order can be done.
    """

    mode: int
    baud: int
    fits: Callable[[Order], bool]


class Answers:
    """Answers requests.

    Parameters
    ----------
    memory : Memory
        What is read and written.
    """

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self._known: dict[int, Callable[[bytes, State], Reply]] = {
            requests.MODE: self._mode,
            requests.VALUES: partial(self._values, requests.VALUES),
            requests.MEAN: partial(self._values, requests.MEAN),
            requests.SUB_RANGE: partial(self._values, requests.SUB_RANGE),
            requests.VARIANT: self._variant,
            requests.WRITE_CONFIGURATION: self._write,
            requests.POWER_ON_BAUD: self._keep_baud,
        }

    def to(self, command: int, data: bytes, state: State) -> Reply:
        """Return the answer to the command and the data of a request."""
        if command in self._known:
            return self._known[command](data, state)
        simple = {
            requests.STATUS: self._status(state),
            requests.ERRORS: self.memory.errors,
            requests.TYPE: self.memory.device_type,
            requests.READ_CONFIGURATION: self.memory.configuration,
        }
        if command == requests.RESET and not data:
            return Reply(command=requests.RESETTING, resets=True, mode=requests.ON_REQUEST)
        return _reply(command, simple[command]) if command in simple and not data else REFUSED

    def _mode(self, data: bytes, state: State) -> Reply:
        mode, rest = (data[0], data[1:]) if data else (-1, b"")
        order = order_of(mode, rest)
        done: Reply | None = None
        if mode in RATES and not rest:
            done = _reply(requests.MODE, DONE, baud=RATES[mode])
        elif rest == OPEN_MODES.get(mode):
            done = _reply(requests.MODE, DONE, mode=mode)
        elif order is not None and state.fits(order):
            done = _reply(requests.MODE, DONE, mode=mode, order=order)
        if done is None and (order is not None or mode == requests.INSTALLATION):
            return _reply(requests.MODE, FAILED)
        return done or REFUSED

    def _values(self, command: int, data: bytes, state: State) -> Reply:
        order = None
        if command == requests.VALUES and data in {b"\1", b"\x08"}:
            order = Order(partial=data[0] == requests.ONE_PARTIAL_SCAN)
        elif command == requests.MEAN:
            order = order_of(requests.STREAM_MEAN, data)
        elif command == requests.SUB_RANGE:
            order = order_of(requests.STREAM_SUB_RANGE, data)
        if order is None or not state.fits(order) or state.mode in requests.STREAMS:
            return REFUSED
        return _reply(command, measures=order)

    def _keep_baud(self, data: bytes, state: State) -> Reply:
        if data not in {b"\0", b"\1"}:
            return REFUSED
        self.memory.keeps_baud = data == b"\1"
        self.memory.baud = state.baud if self.memory.keeps_baud else AT_DELIVERY
        return _reply(requests.POWER_ON_BAUD, b"\1" + data, writes=True)

    def _status(self, state: State) -> bytes:
        memory = self.memory
        return write_status(
            memory.status,
            mode=state.mode,
            measuring_mode=memory.configuration[MEASURING_MODE],
            angle=memory.angle,
            resolution=memory.resolution,
            baud_code=BAUD_CODES[state.baud],
            keeps_baud=memory.keeps_baud,
            unit=memory.configuration[UNIT],
        )

    def _variant(self, data: bytes, _state: State) -> Reply:
        memory = self.memory
        if FAST_TYPE in memory.device_type or len(data) != 4:
            return REFUSED
        wanted = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:], "little")
        taken = wanted in VARIANTS
        changes = taken and wanted != (memory.angle, memory.resolution)
        if taken:
            memory.angle, memory.resolution = wanted
        now_there = word(memory.angle) + word(memory.resolution)
        return _reply(
            requests.VARIANT,
            bytes([taken]) + now_there,
            writes=taken,
            changes=changes,
            mode=requests.ON_REQUEST,  # a stream ends with it
        )

    def _write(self, data: bytes, state: State) -> Reply:
        memory = self.memory
        if len(data) != len(memory.configuration) or state.mode != requests.INSTALLATION:
            return REFUSED
        taken = data[MEASURING_MODE] in {*LAYOUTS, 0x3F} and data[UNIT] in {0, 1}
        changes = taken and data != memory.configuration
        if taken:
            memory.configuration = data
        result = bytes([taken]) + memory.configuration
        return _reply(requests.WRITE_CONFIGURATION, result, writes=taken, changes=changes)


def _reply(
    command: int,
    data: bytes = b"",
    *,
    mode: int | None = None,
    order: Order | None = None,
    measures: Order | None = None,
    baud: int | None = None,
    writes: bool = False,
    changes: bool = False,
) -> Reply:
    """Return the reply to a command."""
    return Reply(
        command=command + FROM_SCANNER, data=data, mode=mode, order=order, measures=measures,
        baud=baud, writes=writes, changes=changes,
    )  # fmt: skip
