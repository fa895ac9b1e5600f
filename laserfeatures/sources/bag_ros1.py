"""ROS 1 bags, version 2.0, walked through record by record (wiki.ros.org/Bags/Format/2.0)."""

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from laserfeatures.sources.bag_file import BagFile, Channel, Chunk, Message

MAGIC = b"#ROSBAG V2.0\n"
A_MESSAGE, A_HEADER, AN_INDEX, A_CHUNK, CHUNK_INFO, CONNECTION = (
    bytes([code]) for code in (2, 3, 4, 5, 6, 7)
)
ENTRY = {AN_INDEX: 12, CHUNK_INFO: 8}  # bytes; old writers give other lengths of the whole
LENGTH = struct.Struct("<I")
LONGEST = 1 << 24  # bytes of a header
MIDDLE = "/msg/"


def walk_ros1(path: Path) -> BagFile:
    """Return what is where in a ROS 1 bag.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is none, is encrypted, or its records make no sense.
    """
    bag = BagFile(path, _inside)
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError(f"expected a bag that starts with {MAGIC!r}, got another")
        _walk(bag, file)
    return bag


class _Found:
    """What was found so far besides the chunks and messages."""

    def __init__(self) -> None:
        self.connections: int | None = None  # that an index should name
        self.begins: dict[int, int] = {}
        self.stated: dict[int, int] = {}
        self.starts: list[int] = []


def _walk(bag: BagFile, file: BinaryIO) -> None:
    end = os.fstat(file.fileno()).st_size
    found = _Found()
    while (start := file.tell()) < end:
        head = _sized(file, end)
        length = file.read(LENGTH.size)
        if head is None or len(length) < LENGTH.size:
            bag.cut = (
                f"byte {start}: the recording was cut here, within a record; what is whole was read"
            )
            break
        fields = _fields(head)
        kind = fields.get(b"op", b"\0")[:1]
        (size,) = LENGTH.unpack(length)
        if kind in ENTRY and b"count" in fields:
            size = ENTRY[kind] * _number(fields, b"count")
        at, left = file.tell(), end - file.tell()
        if kind == A_CHUNK:
            compression = fields.get(b"compression", b"none").decode("ascii", "backslashreplace")
            unpacked = _number(fields, b"size")
            bag.chunks.append(Chunk(at, min(size, left), compression, unpacked, 0))
            found.starts.append(start)
        if size > left:
            bag.cut = (
                f"byte {start}: the recording was cut here, {left} bytes into a record of {size}; "
                "what is whole was read"
            )
            break
        _take(bag, file, found, fields, size)
        file.seek(at + size)
    if set(found.begins) == set(found.starts):  # else the order of the file has to do
        begins = [found.begins[start] for start in found.starts]
        bag.chunks = [c._replace(begin=b) for c, b in zip(bag.chunks, begins, strict=True)]
        bag.stated = found.stated
    bag.complete = found.connections is not None and len(bag.channels) >= found.connections


def _take(
    bag: BagFile, file: BinaryIO, found: _Found, fields: dict[bytes, bytes], size: int
) -> None:
    """Take in a record that is no chunk."""
    kind = fields.get(b"op", b"\0")[:1]
    if kind == A_HEADER:
        if fields.get(b"encryptor"):
            raise ValueError("expected a bag that is not encrypted, got an encrypted one")
        if _number(fields, b"index_pos"):
            found.connections = _number(fields, b"conn_count")
    elif kind == A_MESSAGE:
        row = (_time(fields, b"time"), _number(fields, b"conn"), file.tell(), size)
        bag.loose.extend(row)
    elif kind == CONNECTION and size <= LONGEST:
        bag.channels.setdefault(*_channel(fields, file.read(size)))
    elif kind == CHUNK_INFO and size <= LONGEST:
        found.begins[_number(fields, b"chunk_pos")] = _time(fields, b"start_time")
        for channel, count in struct.iter_unpack("<II", file.read(size)):
            found.stated[channel] = found.stated.get(channel, 0) + count


def _sized(file: BinaryIO, end: int) -> bytes | None:
    """Return the bytes that stand after their number, None if the file ends before."""
    length = file.read(LENGTH.size)
    if len(length) < LENGTH.size:
        return None
    (size,) = LENGTH.unpack(length)
    if size > end - file.tell():
        return None
    if size > LONGEST:
        raise ValueError(f"byte {file.tell() - 4}: expected a record's header, got {size} bytes")
    return file.read(size)


def _fields(head: bytes) -> dict[bytes, bytes]:
    fields = {}
    at = 0
    while at + LENGTH.size <= len(head):
        (size,) = LENGTH.unpack_from(head, at)
        at += LENGTH.size
        name, mark, value = head[at : at + size].partition(b"=")
        if not mark or at + size > len(head):
            raise ValueError(f"expected name=value in a record's header, got {name[:20]!r}")
        fields[name] = value
        at += size
    return fields


def _number(fields: dict[bytes, bytes], name: bytes) -> int:
    if name not in fields or len(fields[name]) > 8:
        raise ValueError(f"expected the field {name.decode()} in a record's header, got none")
    return int.from_bytes(fields[name], "little")


def _time(fields: dict[bytes, bytes], name: bytes) -> int:
    both = _number(fields, name)
    return (both & 0xFFFFFFFF) * 10**9 + (both >> 32)


def _channel(fields: dict[bytes, bytes], data: bytes) -> tuple[int, Channel]:
    inner = _fields(data)

    def text(name: bytes) -> str:
        return inner.get(name, b"").decode("utf-8", "backslashreplace")

    topic = fields.get(b"topic", b"").decode("utf-8", "backslashreplace")
    kind = text(b"type")
    if MIDDLE not in kind:
        kind = kind.replace("/", MIDDLE, 1)
    channel = Channel(topic, kind, "ros1", "ros1msg", text(b"message_definition"))
    return _number(fields, b"conn"), channel


def _inside(content: bytes) -> Iterator[Message | tuple[int, Channel]]:
    at = 0
    while at < len(content):
        head, at = _part(content, at)
        data, at = _part(content, at)
        fields = _fields(head)
        kind = fields.get(b"op", b"\0")[:1]
        if kind == A_MESSAGE:
            yield Message(_time(fields, b"time"), _number(fields, b"conn"), data)
        elif kind == CONNECTION:
            yield _channel(fields, data)


def _part(content: bytes, at: int) -> tuple[bytes, int]:
    start = at + LENGTH.size
    end = start + (LENGTH.unpack_from(content, at)[0] if start <= len(content) else 1)
    if end > len(content):
        raise ValueError("expected a whole record in a chunk, got the end of it")
    return content[start:end], end
