"""Requests, descriptors and replies of an RPLIDAR, as bytes and as values.

References
----------
Slamtec, "RPLIDAR interface protocol and application notes"; Slamtec/rplidar_sdk,
``sdk/include/sl_lidar_cmd.h``.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import reduce
from operator import xor

from laserfeatures.errors import ProtocolError

SYNC = 0xA5
ANSWER = b"\xa5\x5a"
DESCRIPTOR = 7  # bytes
HAS_PAYLOAD = 0x80
LONGEST_PAYLOAD = 255

INFO = struct.Struct("<BBBB16s")
HEALTH = struct.Struct("<BH")
SAMPLE_RATE = struct.Struct("<HH")
U16, U32 = struct.Struct("<H"), struct.Struct("<I")


class Command(IntEnum):
    """What a host may ask."""

    SCAN = 0x20
    FORCE_SCAN = 0x21
    STOP = 0x25
    RESET = 0x40
    INFO = 0x50
    HEALTH = 0x52
    SAMPLE_RATE = 0x59
    EXPRESS_SCAN = 0x82
    CONFIGURATION = 0x84
    MOTOR_SPEED = 0xA8
    MOTOR_PWM = 0xF0
    BOARD_FLAGS = 0xFF


class Answer(IntEnum):
    """Types of answers; those from 0x81 on are streams of measurements."""

    INFO = 0x04
    HEALTH = 0x06
    SAMPLE_RATE = 0x15
    CONFIGURATION = 0x20
    NODES = 0x81
    CAPSULES = 0x82
    ULTRA_CAPSULES = 0x84
    DENSE_CAPSULES = 0x85
    BOARD_FLAGS = 0xFF


LENGTHS = {
    Answer.INFO: INFO.size,
    Answer.HEALTH: HEALTH.size,
    Answer.SAMPLE_RATE: SAMPLE_RATE.size,
    Answer.BOARD_FLAGS: U32.size,
    Answer.NODES: 5,
    Answer.CAPSULES: 84,
    Answer.ULTRA_CAPSULES: 132,
    Answer.DENSE_CAPSULES: 84,
}
"""Bytes of each answer whose length is fixed; of a stream, of one node or capsule."""

STREAMS = {
    Answer.NODES,
    Answer.CAPSULES,
    Answer.ULTRA_CAPSULES,
    Answer.DENSE_CAPSULES,
}
LONGEST_CONFIGURATION = 256  # bytes; a longer one is no answer but noise


class Key(IntEnum):
    """What a configuration request may ask for."""

    DESIRED_SPEED = 0x01
    LEAST_SPEED = 0x04
    LARGEST_SPEED = 0x05
    MODES = 0x70
    SAMPLE_TIME = 0x71
    MAX_DISTANCE = 0x74
    ANSWER_TYPE = 0x75
    TYPICAL_MODE = 0x7C
    NAME = 0x7F


class Status(IntEnum):
    """State of health."""

    GOOD = 0
    WARNING = 1
    ERROR = 2


@dataclass(frozen=True)
class Descriptor:
    """The head of an answer: type, bytes of its body, whether bodies follow without end."""

    kind: Answer
    length: int

    @property
    def stream(self) -> bool:
        """Whether bodies follow without end."""
        return self.kind in STREAMS


@dataclass(frozen=True)
class Info:
    """Which device it is."""

    model: int
    firmware: tuple[int, int]
    hardware: int
    serial: str

    @property
    def series(self) -> int:
        """High nibble of the model: 1 to 3 are A1 to A3, 4 and 5 C, 6 to 8 S, 9 to 11 T."""
        return self.model >> 4


@dataclass(frozen=True)
class Health:
    """How it is; after status 2 it measures no more until it is reset."""

    status: int
    code: int


@dataclass(frozen=True)
class SampleRate:
    """Time that a measurement takes [s], in the standard and in the express scan."""

    standard: float
    express: float


@dataclass(frozen=True)
class Configuration:
    """The value of a configuration key, as bytes."""

    key: int
    value: bytes


@dataclass(frozen=True)
class BoardFlags:
    """What the accessory board can do."""

    pwm: bool


Reply = Info | Health | SampleRate | Configuration | BoardFlags


def checksum(data: bytes) -> int:
    """Return all bytes XORed.

    Examples
    --------
    >>> hex(checksum(bytes.fromhex("A5F0029402")))
    '0xc1'
    """
    return reduce(xor, data, 0)


def request(command: Command, payload: bytes = b"") -> bytes:
    """Return a request as bytes.

    Parameters
    ----------
    command : Command
        What is asked.
    payload : bytes
        Its parameters; only commands from 0x80 on have some.

    Examples
    --------
    >>> request(Command.MOTOR_PWM, U16.pack(660)).hex(" ")
    'a5 f0 02 94 02 c1'
    """
    if not command & HAS_PAYLOAD:
        return bytes((SYNC, command))
    body = bytes((SYNC, command, len(payload))) + payload
    return body + bytes((checksum(body),))


def ask_configuration(key: Key, mode: int | None = None) -> bytes:
    """Return the request for a configuration key, of a scan mode where the key has modes."""
    payload = U32.pack(key) + (b"" if mode is None else U16.pack(mode))
    return request(Command.CONFIGURATION, payload)


def descriptor(kind: Answer, length: int | None = None) -> bytes:
    """Return the head of an answer whose body has `length` bytes."""
    size = LENGTHS[kind] if length is None else length
    return ANSWER + U32.pack(size | (kind in STREAMS) << 30) + bytes((kind,))


def parse_descriptor(data: bytes) -> Descriptor:
    """Return what the first 7 bytes of an answer say.

    Raises
    ------
    ProtocolError
        If it is no descriptor, or none that is known here.
    """
    shown = data[:DESCRIPTOR].hex(" ")
    if len(data) < DESCRIPTOR or data[:2] != ANSWER:
        raise ProtocolError(f"expected a descriptor (a5 5a and 5 bytes), got {shown or 'nothing'}")
    length, mode = U32.unpack_from(data, 2)[0] & 0x3FFFFFFF, data[5] >> 6
    try:
        kind = Answer(data[6])
    except ValueError as error:
        raise ProtocolError(f"expected the type of an answer, got {data[6]:#x}: {shown}") from error
    fits = LENGTHS.get(kind, length) == length <= LONGEST_CONFIGURATION and length >= U32.size - 1
    if not fits or mode != (kind in STREAMS):
        raise ProtocolError(f"expected a descriptor of type {kind:#x}, got one of {length} bytes "
                            f"and mode {mode}: {shown}")  # fmt: skip
    return Descriptor(kind, length)


def parse_reply(kind: Answer, body: bytes) -> Reply:
    """Return what the body of a single answer says.

    Raises
    ------
    ProtocolError
        If its length is wrong, or it is a stream.
    """
    if len(body) != LENGTHS.get(kind, len(body)) or kind in STREAMS or len(body) < HEALTH.size:
        raise ProtocolError(f"expected the answer {kind.name}, got {len(body)} bytes")
    if kind is Answer.INFO:
        model, minor, major, hardware, serial = INFO.unpack(body)
        return Info(model, (major, minor), hardware, serial.hex().upper())
    if kind is Answer.HEALTH:
        return Health(*HEALTH.unpack(body))
    if kind is Answer.SAMPLE_RATE:
        standard, express = SAMPLE_RATE.unpack(body)
        return SampleRate(standard / 1e6, express / 1e6)
    if kind is Answer.BOARD_FLAGS:
        return BoardFlags(bool(U32.unpack(body)[0] & 1))
    if len(body) < U32.size:
        raise ProtocolError(f"expected a configuration of 4 bytes or more, got {len(body)}")
    return Configuration(U32.unpack_from(body)[0], body[U32.size :])


def build_reply(reply: Reply) -> bytes:
    """Return an answer as bytes: its descriptor and its body."""
    if isinstance(reply, Info):
        major, minor = reply.firmware
        serial = bytes.fromhex(reply.serial)
        body = INFO.pack(reply.model, minor, major, reply.hardware, serial)
        return descriptor(Answer.INFO) + body
    if isinstance(reply, Health):
        return descriptor(Answer.HEALTH) + HEALTH.pack(reply.status, reply.code)
    if isinstance(reply, SampleRate):
        times = (round(reply.standard * 1e6), round(reply.express * 1e6))
        return descriptor(Answer.SAMPLE_RATE) + SAMPLE_RATE.pack(*times)
    if isinstance(reply, BoardFlags):
        return descriptor(Answer.BOARD_FLAGS) + U32.pack(reply.pwm)
    body = U32.pack(reply.key) + reply.value
    return descriptor(Answer.CONFIGURATION, len(body)) + body


def next_request(data: bytes) -> tuple[int, bytes | None, int] | None:
    """Find the first request in the bytes of a host.

    Returns
    -------
    tuple or None
        Command, payload (None if its checksum is wrong), and how many bytes it and what is before
        it take; None if there is no whole one yet.
    """
    start = data.find(SYNC)
    if start < 0 or len(data) < start + 2:
        return None
    command = data[start + 1]
    if not command & HAS_PAYLOAD:
        return command, b"", start + 2
    if len(data) < start + 3 or len(data) < start + 4 + data[start + 2]:
        return None
    end = start + 3 + data[start + 2]
    right = checksum(data[start:end]) == data[end]
    return command, data[start + 3 : end] if right else None, end + 1
