"""The 6-bit coding of numbers, and the blocks of lines that distances come in.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B, pages 6 and 9.
"""

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import IntArray
from laserfeatures.drivers.urg.scip import LF, decode_line, sum_of, with_sum
from laserfeatures.errors import ProtocolError

Bytes = NDArray[np.uint8]

FIRST = 0x30  # the character of 0
BITS = 6
LINE = 64  # characters in a whole line of a block
SENT = LINE + 2  # with its sum and line feed
TIME_CHARACTERS = 4


def encode(values: IntArray, characters: int) -> bytes:
    """Return numbers (N,) in so many characters each, the highest bits first.

    Examples
    --------
    >>> encode(np.array([5600, 392]), 3)
    b'1GP068'
    """
    shifts = BITS * np.arange(characters - 1, -1, -1)
    digits = np.asarray(values, dtype=np.int64)[:, None] >> shifts & 0x3F
    return (digits + FIRST).astype(np.uint8).tobytes()


def decode(text: bytes, characters: int) -> IntArray:
    """Return the numbers (N,) of `characters` each that a text holds.

    Raises
    ------
    ProtocolError
        If its length is no multiple, or a character is none of the 64.

    Examples
    --------
    >>> decode(b"CB0D", 2).tolist()
    [1234, 20]
    """
    return _numbers(np.frombuffer(text, dtype=np.uint8), characters)


def encode_time(milliseconds: int) -> bytes:
    """Return a time stamp's line."""
    return with_sum(encode(np.array([milliseconds]), TIME_CHARACTERS))


def decode_time(line: bytes) -> int:
    """Return the time [ms] of a time stamp's line, given with its sum, without its line feed.

    Raises
    ------
    ProtocolError
        If it is none, or its sum is wrong.

    Examples
    --------
    >>> decode_time(b"JUGnD")
    6968830
    """
    return time_of(decode_line(line, TIME_CHARACTERS))


def time_of(text: bytes) -> int:
    """Return the time [ms] that four characters tell.

    Raises
    ------
    ProtocolError
        If they are none of the 64, or not four.
    """
    if len(text) != TIME_CHARACTERS:
        raise ProtocolError(f"SCIP time {text!r}: expected {TIME_CHARACTERS} characters")
    return int(decode(text, TIME_CHARACTERS)[0])


def encode_block(values: IntArray, characters: int) -> bytes:
    """Return the lines of numbers (N,), which go on from line to line."""
    text = encode(values, characters)
    return b"".join(with_sum(text[i : i + LINE]) for i in range(0, len(text), LINE))


def block_size(count: int, characters: int) -> int:
    """Return how many bytes the lines of `count` numbers are."""
    length = count * characters
    return length + 2 * -(-length // LINE)


def decode_block(block: bytes, count: int, characters: int) -> IntArray:
    """Return the `count` numbers (N,) of a block of lines.

    Raises
    ------
    ProtocolError
        If its length, a sum or a character is wrong.
    """
    if len(block) != block_size(count, characters):
        raise ProtocolError(
            f"SCIP data: expected {block_size(count, characters)} bytes for {count} values, "
            f"got {len(block)}"
        )
    whole, rest = divmod(count * characters, LINE)
    data = np.frombuffer(block, dtype=np.uint8)
    rows = data[: whole * SENT].reshape(whole, SENT)
    sums = (rows[:, :LINE].sum(axis=1, dtype=np.int64) & 0x3F) + FIRST
    good = (rows[:, LINE] == sums) & (rows[:, LINE + 1] == LF[0])
    if not good.all():
        line = int(np.argmin(good))
        expected = bytes([sums[line]]) + LF
        got = rows[line, LINE:].tobytes()
        raise ProtocolError(
            f"SCIP data line {line + 1}: expected the sum {expected!r}, got {got!r}"
        )
    last = data[whole * SENT :]
    if rest and last[rest:].tobytes() != sum_of(last[:rest].tobytes()) + LF:
        raise ProtocolError(f"SCIP data line {whole + 1}: wrong sum {last[rest:].tobytes()!r}")
    return _numbers(np.concatenate([rows[:, :LINE].ravel(), last[:rest]]), characters)


def _numbers(text: Bytes, characters: int) -> IntArray:
    if text.size % characters:
        raise ProtocolError(f"SCIP data: expected {characters} characters a value, got {text.size}")
    digits = text - np.uint8(FIRST)  # what is below FIRST becomes large
    if (digits > 0x3F).any():
        bad = int(np.argmax(digits > 0x3F))
        raise ProtocolError(f"SCIP data: expected characters 0x30..0x6f, got 0x{text[bad]:02x}")
    columns = digits.reshape(-1, characters)
    values = columns[:, 0].astype(np.int64)
    for i in range(1, characters):
        values = values << BITS | columns[:, i]
    return values
