"""Replies of SCIP 2.0 (and 1.1): an echo, a status, lines, each with a sum of its own.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B, pages 9 and 23.
"""

import logging
from collections.abc import Callable
from dataclasses import dataclass

from laserfeatures.drivers.urg.statuses import BUSY
from laserfeatures.errors import ProtocolError

log = logging.getLogger("laserfeatures.drivers")

LF = b"\n"
OLD_REFUSAL = b"E"  # status of SCIP 1.1 for a command that it does not know
KEYED = frozenset({b"VV", b"PP", b"II"})  # whose lines are ``KEY:VALUE``
TOLD = frozenset({b"VV", b"II"})  # of which nothing is needed to measure
MARK = b"<-"  # begins a remark such as "<-Default", which some sensors do not sum
LONGEST_STRING = 16
SHOWN = 40  # bytes of a bad line in a message


@dataclass(frozen=True)
class Reply:
    """What a sensor answers.

    Parameters
    ----------
    echo : bytes
        The command, with its string.
    status : bytes
        Two characters; one in SCIP 1.1.
    lines : tuple of bytes
        The lines behind it, without their sums.
    """

    echo: bytes
    status: bytes
    lines: tuple[bytes, ...] = ()


def sum_of(text: bytes) -> bytes:
    """Return the sum character of a line.

    Examples
    --------
    >>> sum_of(b"99")
    b'b'
    """
    return bytes([(sum(text) & 0x3F) + 0x30])


def with_sum(text: bytes) -> bytes:
    """Return a line of data as it is sent, with its sum and line feed."""
    return text + sum_of(text) + LF


def with_key_sum(text: bytes) -> bytes:
    r"""Return a line ``KEY:VALUE`` as it is sent: the semicolon is not summed.

    Examples
    --------
    >>> with_key_sum(b"DMIN:20")
    b'DMIN:20;4\n'
    """
    return text + b";" + sum_of(text) + LF


def encode_reply(echo: bytes, status: bytes, body: bytes = b"") -> bytes:
    """Return a reply as it is sent; `body` is lines with their sums and line feeds."""
    line = status + LF if len(status) == 1 else with_sum(status)
    return echo + LF + line + body + LF


def decode_reply(frame: bytes) -> Reply:
    """Return the reply that a frame, from its echo to its empty line, holds.

    Raises
    ------
    ProtocolError
        If it is none, or a sum is wrong.
    """
    if not frame.endswith(LF + LF):
        raise ProtocolError(f"SCIP reply: expected two line feeds at its end, got {frame[-2:]!r}")
    echo, *rest = frame[:-2].split(LF)
    if not echo or not rest:
        raise ProtocolError(f"SCIP reply: expected an echo and a status, got {frame[:SHOWN]!r}")
    status, *lines = rest
    if len(status) == 1:
        return Reply(echo, status, tuple(lines))
    decode = decode_key_line if echo[:2] in KEYED else decode_line
    if echo[:2] in TOLD:
        decode = _as_told
    return Reply(echo, decode_line(status, 2), tuple(decode(line) for line in lines))


def decode_line(line: bytes, length: int | None = None) -> bytes:
    """Return a line without its sum.

    Parameters
    ----------
    line : bytes
        The line without its line feed.
    length : int, optional
        How many characters it must have without the sum.

    Raises
    ------
    ProtocolError
        If the sum or the length is wrong, or a character is none that SCIP has.
    """
    text = _text(line)
    if length is not None and len(text) != length:
        raise ProtocolError(f"SCIP line {line[:SHOWN]!r}: expected {length} characters and a sum")
    if line[-1:] != sum_of(text):
        raise _wrong_sum(line, text)
    return text


def decode_key_line(line: bytes) -> bytes:
    """Return a line ``KEY:VALUE;S`` without semicolon and sum, whether it is summed or not.

    Raises
    ------
    ProtocolError
        If the sum is wrong, or a character is none that SCIP has.
    """
    text = _text(line)
    bare = text.removesuffix(b";")
    if line[-1:] not in {sum_of(text), sum_of(bare), sum_of(bare.partition(MARK)[0] + MARK)}:
        raise _wrong_sum(line, bare)
    return bare


def _as_told(line: bytes) -> bytes:
    """Return a line ``KEY:VALUE;S``, be its sum wrong: some sensors sum single ones wrongly."""
    try:
        return decode_key_line(line)
    except ProtocolError:
        bare = _text(line).removesuffix(b";")
        if b":" not in bare:
            raise
        log.warning("a line of the sensor's has a wrong sum: %r", line[:SHOWN])
        return bare


def _text(line: bytes) -> bytes:
    text = line[:-1]
    if not text or not text.isascii() or min(text) < 0x20:
        raise ProtocolError(f"SCIP line {line[:SHOWN]!r}: expected printable characters and a sum")
    return text


def _wrong_sum(line: bytes, text: bytes) -> ProtocolError:
    return ProtocolError(
        f"SCIP line {line[:SHOWN]!r}: expected the sum {sum_of(text)!r}, got {line[-1:]!r}"
    )


def answer_to(command: bytes) -> Callable[[object], Reply | None]:
    """Match the reply to a command, but not one that says "later"."""

    def match(reply: object) -> Reply | None:
        if not isinstance(reply, Reply) or reply.echo != command:
            return None
        return None if reply.status in BUSY else reply

    return match
