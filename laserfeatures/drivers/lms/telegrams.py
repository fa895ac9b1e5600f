"""Telegrams of a SICK LMS2xx: their frame and its checksum."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from laserfeatures.errors import ProtocolError

STX = 0x02
ACK = 0x06
NAK = 0x15
BROADCAST = 0x00
FROM_SCANNER = 0x80  # added to the scanner's address; also to the command that a reply answers
REPLY_ADDRESSES = (0x80, 0x81)
OK = 0x10  # status byte of a scanner without a fault
LARGEST = 814  # bytes: 401 values and two indices
ENVELOPE = 6  # bytes around what LEN counts
POLYNOMIAL = 0x8005


class Message:
    """What a scanner sends: an `Answer` or a `Telegram`."""


@dataclass(frozen=True)
class Answer(Message):
    """The byte before a reply: whether the request's checksum was right."""

    good: bool


@dataclass(frozen=True)
class Telegram(Message):
    """What a scanner sent.

    Parameters
    ----------
    command : int
        Of the request that it answers, + 0x80.
    data : bytes
        What stands between the command and the status byte.
    status : int
        The status byte.
    address : int
        0x80 + the scanner's own.
    """

    command: int
    data: bytes
    status: int = OK
    address: int = FROM_SCANNER


def crc(data: bytes) -> int:
    """Return the checksum of a telegram from STX to the last byte of data or status.

    It is linear, so that each byte adds a share that depends on nothing but its value and its
    distance from the end; the shares are looked up. It tells every change of one byte, and any
    other damage but once in 65536 times. Of two flipped bits it misses those that are as many
    bytes as places apart: bit 3 of a byte and bit 4 of the next.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 107.
    """
    shares, offsets = _shares()
    values = np.frombuffer(data, dtype=np.uint8)
    return int(np.bitwise_xor.reduce(shares[offsets[LARGEST - len(data) :] + values]))


@cache
def _shares() -> tuple[NDArray[np.uint16], NDArray[np.intp]]:
    """Return the share of each byte value at each distance, and where the distances begin."""
    values = np.arange(256, dtype=np.uint16)
    table = np.empty((LARGEST, 256), dtype=np.uint16)
    table[0] = values
    table[1] = values << 1 ^ values << 8  # shifted once, and mixed in as the byte before
    for row in range(2, LARGEST):
        last = table[row - 1]
        table[row] = last << 1 ^ np.where(last & 0x8000, POLYNOMIAL, 0).astype(np.uint16)
    return table.ravel(), np.arange(LARGEST - 1, -1, -1) * 256


def _enveloped(address: int, content: bytes) -> bytes:
    head = bytes([STX, address]) + len(content).to_bytes(2, "little") + content
    return head + crc(head).to_bytes(2, "little")


def pack_request(command: int, data: bytes = b"", address: int = BROADCAST) -> bytes:
    """Return the bytes of a request.

    Examples
    --------
    >>> pack_request(0x31).hex(" ")
    '02 00 01 00 31 15 12'
    """
    return _enveloped(address, bytes([command]) + data)


def pack(telegram: Telegram) -> bytes:
    """Return the bytes of a scanner's telegram.

    Examples
    --------
    >>> pack(Telegram(0xA0, bytes([0]))).hex(" ")
    '02 80 03 00 a0 00 10 16 0a'
    """
    content = bytes([telegram.command]) + telegram.data + bytes([telegram.status])
    return _enveloped(telegram.address, content)


def parse_request(data: bytes) -> tuple[int, bytes]:
    """Return the command and the data of a request.

    Raises
    ------
    ProtocolError
        If it is none, or its checksum is wrong.
    """
    address, content = _content(data, least=1)
    if address & FROM_SCANNER:
        raise ProtocolError(f"byte 1: expected the address of a scanner, got 0x{address:02X}")
    return content[0], content[1:]


def parse(data: bytes) -> Telegram:
    """Return the telegram of a scanner.

    Raises
    ------
    ProtocolError
        If it is none, or its checksum is wrong.
    """
    address, content = _content(data, least=2)
    if address not in REPLY_ADDRESSES:
        raise ProtocolError(f"byte 1: expected the address 0x80 or 0x81, got 0x{address:02X}")
    return Telegram(content[0], content[1:-1], content[-1], address)


def _content(data: bytes, least: int) -> tuple[int, bytes]:
    """Return the address of a telegram, and what its LEN counts."""
    if not ENVELOPE + least <= len(data) <= LARGEST or data[0] != STX:
        raise ProtocolError(f"expected a telegram, got {data[:8].hex(' ')} ({len(data)} bytes)")
    length = int.from_bytes(data[2:4], "little")
    if length + ENVELOPE != len(data):
        raise ProtocolError(
            f"byte 2: expected the length {len(data) - ENVELOPE} in a telegram of {len(data)} "
            f"bytes, got {length}"
        )
    got, wanted = int.from_bytes(data[-2:], "little"), crc(data[:-2])
    if got != wanted:
        raise ProtocolError(f"telegram: expected the checksum {wanted:04X}, got {got:04X}")
    return data[1], data[4:-2]
