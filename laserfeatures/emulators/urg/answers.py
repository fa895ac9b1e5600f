"""How a sensor answers commands.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B.
"""

import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import cast

from laserfeatures.arrays import IntArray
from laserfeatures.drivers.urg.commands import Measurement, decode_measurement
from laserfeatures.drivers.urg.ranges import encode_block, encode_time
from laserfeatures.drivers.urg.scip import LONGEST_STRING, encode_reply, with_key_sum
from laserfeatures.emulators.urg.models import MAKER, RATES, Model
from laserfeatures.emulators.urg.state import State

Scan = Callable[[Measurement], bytes]
Answer = tuple[bytes, bytes]  # status and body

OK: Answer = (b"00", b"")
SLOWEST, AS_AT_POWER_ON = 10, 99
LENGTHS = {b"VV": 2, b"PP": 2, b"II": 2, b"BM": 2, b"QT": 2, b"RS": 2, b"TM": 3, b"SS": 8}
LENGTHS |= {b"CR": 4, b"HS": 3, b"MD": 15, b"MS": 15, b"GD": 12, b"GS": 12}
_STRING = re.compile(rb"[A-Za-z0-9 ._+@]*")
# Where the numbers of a scan's command stand, and the status for each that is none.
_NUMBERS = ((2, 6, b"01"), (6, 10, b"02"), (10, 12, b"03"), (12, 13, b"06"), (13, 15, b"07"))


def answer(state: State, line: bytes, time: float, scan: Scan) -> bytes:
    """Obey a command and return the reply.

    Parameters
    ----------
    state : State
        Of the sensor; is changed.
    line : bytes
        The command, with its string, without its line feed.
    time : float
        When it is answered [s].
    scan : callable
        Returns the time and data lines of the latest scan, for GD and GS.
    """
    if state.mode == "scip1":
        return _answer_old(state, line)
    command, _, string = line.partition(b";")
    if len(string) > LONGEST_STRING:
        return encode_reply(line, b"0G")
    if not _STRING.fullmatch(string):
        return encode_reply(line, b"0H")
    status, body = _obey(state, command, time, scan)
    if state.mode == "streaming" and command[:1] == b"M" and status == b"00":
        state.echo_string = line[len(command) :]
    return encode_reply(line, status, body)


def _obey(state: State, command: bytes, time: float, scan: Scan) -> Answer:
    letters = command[:2]
    length = LENGTHS.get(letters)
    if length is None or len(command) > length or (state.mode == "tm" and letters != b"TM"):
        return b"0E", b""
    if len(command) < length:
        return b"0C", b""
    if letters in {b"GD", b"GS", b"MD", b"MS"}:
        return _measure(state, command, time, scan)
    return _SIMPLE[letters](state, command[2:], time)


def _answer_old(state: State, line: bytes) -> bytes:
    """Answer in SCIP 1.1: a status of one character, no sums."""
    if line == b"SCIP2.0":
        state.light("idle")
        return encode_reply(line, b"0")
    if line == b"V":
        body = b"".join(text + b"\n" for text in _version(state.model))
        return encode_reply(line, b"0", body)
    return encode_reply(line, b"E")


def _measure(state: State, command: bytes, time: float, scan: Scan) -> Answer:
    for begin, end, status in _NUMBERS:
        if not command[begin:end].isdigit() and command[begin:end]:
            return status, b""
    first, last = int(command[2:6]), int(command[6:10])
    if last > state.model.largest_step:
        return b"04", b""
    if last < first:
        return b"05", b""
    measurement = decode_measurement(command)
    if not measurement.streams:
        return (b"00", scan(measurement)) if state.laser else (b"10", b"")
    if state.stream is not None:
        return b"0B", b""
    state.light("streaming")
    state.stream, state.left = measurement, measurement.count
    state.begin = state.next_turn(time)
    return OK


def scan_frame(state: State, milliseconds: int, values: IntArray) -> bytes:
    """Return a scan of the stream, and count it.

    Parameters
    ----------
    state : State
        Of the sensor.
    milliseconds : int
        Its clock at step 0.
    values : (N,) int array
        Ranges [mm] and error codes.
    """
    stream = cast("Measurement", state.stream)
    return stream_frame(state, b"99", scan_body(milliseconds, values, stream.characters))


def stream_frame(state: State, status: bytes, body: bytes = b"") -> bytes:
    """Return a reply of the stream; the echo says how many scans are still to come."""
    stream = cast("Measurement", state.stream)
    echo = replace(stream, count=state.left).encode() + state.echo_string
    return encode_reply(echo, status, body)


def scan_body(milliseconds: int, values: IntArray, characters: int) -> bytes:
    """Return the time and data lines of a scan."""
    return encode_time(milliseconds) + encode_block(values, characters)


def _version(model: Model) -> list[bytes]:
    fields = {
        "VEND": MAKER,
        "PROD": model.product,
        "FIRM": model.firmware,
        "PROT": "SCIP 2.0",
        "SERI": model.serial,
    }
    return [f"{key}:{value}".encode() for key, value in fields.items()]


def _vv(state: State, _rest: bytes, _time: float) -> Answer:
    return b"00", _key_lines(_version(state.model))


def _pp(state: State, _rest: bytes, _time: float) -> Answer:
    geometry = state.model.geometry
    fields = {
        "MODL": geometry.model,
        "DMIN": geometry.shortest,
        "DMAX": geometry.longest,
        "ARES": geometry.steps,
        "AMIN": geometry.first,
        "AMAX": geometry.last,
        "AFRT": geometry.front,
        "SCAN": geometry.speed,
    }
    return b"00", _key_lines(f"{key}:{value}".encode() for key, value in fields.items())


def _ii(state: State, _rest: bytes, time: float) -> Answer:
    usual = "<-Default setting by user"
    speed = f"{state.speed:.0f}[rpm]"
    fields = {
        "MODL": state.model.geometry.model,
        "LASR": "ON" if state.laser else "OFF",
        "SCSP": speed if state.motor else f"Initial({speed}){usual}",
        "MESM": "CLASSIC" if state.laser else "IDLE",
        "SBPS": f"{state.baud}[bps]{usual}" if state.baud else f"USB only{usual}",
        "TIME": f"{state.clock(time):06X}",
        "STAT": "Sensor works well.",
    }
    return b"00", _key_lines(f"{key}:{value}".encode() for key, value in fields.items())


def _key_lines(lines: Iterable[bytes]) -> bytes:
    return b"".join(map(with_key_sum, lines))


def _bm(state: State, _rest: bytes, _time: float) -> Answer:
    if state.laser:
        return b"02", b""
    state.light("laser on")
    return OK


def _qt(state: State, _rest: bytes, _time: float) -> Answer:
    state.light("idle")
    return OK


def _rs(state: State, _rest: bytes, time: float) -> Answer:
    state.light("idle")
    state.set_motor(0, time)
    state.sensitive = False
    state.clock_ms, state.since = 0.0, time
    if state.baud is not None:
        state.pending_baud = state.model.baud
    return OK


def _tm(state: State, rest: bytes, time: float) -> Answer:
    inside = state.mode == "tm"
    if rest == b"0":
        state.light("tm")
        return (b"02", b"") if inside else OK
    if rest == b"1":
        return (b"00", encode_time(state.clock(time))) if inside else (b"04", b"")
    if rest == b"2":
        if inside:
            state.light("idle")
        return OK if inside else (b"03", b"")
    return b"01", b""


def _ss(state: State, rest: bytes, _time: float) -> Answer:
    if not rest.isdigit():
        return b"01", b""
    if int(rest) not in RATES:
        return b"02", b""
    if state.baud is None:  # USB: taken, and of no effect
        return OK
    if int(rest) == state.baud:
        return b"03", b""
    state.pending_baud = int(rest)
    return OK


def _cr(state: State, rest: bytes, time: float) -> Answer:
    if not rest.isdigit():
        return b"01", b""
    motor = 0 if int(rest) == AS_AT_POWER_ON else int(rest)
    if motor > SLOWEST:
        return b"02", b""
    if motor == state.motor:
        return b"03", b""
    state.set_motor(motor, time)
    return OK


def _hs(state: State, rest: bytes, _time: float) -> Answer:
    if rest not in {b"0", b"1"}:
        return b"01", b""
    if state.sensitive == (rest == b"1"):
        return b"02", b""
    state.sensitive = rest == b"1"
    return OK


_SIMPLE = {
    b"VV": _vv,
    b"PP": _pp,
    b"II": _ii,
    b"BM": _bm,
    b"QT": _qt,
    b"RS": _rs,
    b"TM": _tm,
    b"SS": _ss,
    b"CR": _cr,
    b"HS": _hs,
}
