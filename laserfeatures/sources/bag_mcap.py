"""MCAP files, walked through record by record (mcap.dev/spec)."""

import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from laserfeatures.sources.bag_file import BagFile, Channel, Chunk, Message

MAGIC = b"\x89MCAP0\r\n"
RECORD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")
CHUNK = struct.Struct("<QQQI")
FOOTER, SCHEMA, CHANNEL, A_MESSAGE, A_CHUNK, STATISTICS = 2, 3, 4, 5, 6, 11
LONGEST = 1 << 24  # bytes of a record that is looked at whole


class _Reader:
    """Reads the fields of a record.

    Raises
    ------
    ValueError
        If it is too short.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    def take(self, size: int) -> bytes:
        part = self._data[self._at : self._at + size]
        if len(part) != size:
            raise ValueError(f"expected {size} more bytes in a record, got {len(part)}")
        self._at += size
        return part

    def unpack(self, form: str) -> tuple[int, ...]:
        return struct.unpack(form, self.take(struct.calcsize(form)))

    def text(self) -> str:
        return self.take(self.unpack("<I")[0]).decode("utf-8", "backslashreplace")


class _Schemas:
    """The schemas that were met, and the channels that name them."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[str, str, str]] = {}

    def add(self, data: bytes) -> None:
        fields = _Reader(data)
        (number,) = fields.unpack("<H")
        self._known.setdefault(number, (fields.text(), fields.text(), fields.text()))

    def channel(self, data: bytes) -> tuple[int, Channel]:
        fields = _Reader(data)
        number, schema = fields.unpack("<HH")
        kind, form, definition = self._known.get(schema, ("", "", ""))
        topic, encoding = fields.text(), fields.text()
        return number, Channel(topic, kind, encoding, form, definition)


def walk_mcap(path: Path) -> BagFile:
    """Return what is where in an MCAP file.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is none.
    """
    schemas = _Schemas()

    def inside(content: bytes) -> Iterator[Message | tuple[int, Channel]]:
        at = 0
        while at < len(content):
            if at + RECORD.size > len(content):
                raise ValueError("expected a record in a chunk, got the end of it")
            kind, size = RECORD.unpack_from(content, at)
            at += RECORD.size
            if at + size > len(content):
                raise ValueError(f"expected a record of {size} bytes, got {len(content) - at}")
            if kind == SCHEMA:
                schemas.add(content[at : at + size])
            elif kind == CHANNEL:
                yield schemas.channel(content[at : at + size])
            elif kind == A_MESSAGE and size >= MESSAGE.size:
                channel, _, time, _ = MESSAGE.unpack_from(content, at)
                yield Message(time, channel, content[at + MESSAGE.size : at + size])
            at += size

    bag = BagFile(path, inside)
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError("expected an MCAP file, got another")
        _walk(bag, file, schemas)
    return bag


def _walk(bag: BagFile, file: BinaryIO, schemas: _Schemas) -> None:
    end = os.fstat(file.fileno()).st_size
    channels = None
    while True:
        start = file.tell()
        head = file.read(RECORD.size)
        kind, size = RECORD.unpack(head) if len(head) == RECORD.size else (0, 0)
        left = end - file.tell()
        if not kind or (size > left and kind != A_CHUNK):
            bag.cut = (
                f"byte {start}: the recording was cut here, within a record; what is whole was read"
            )
            break
        if kind == FOOTER:
            break
        if kind == A_CHUNK:
            _chunk(bag, file, min(size, left))
        elif kind == A_MESSAGE and size >= MESSAGE.size:
            channel, _, time, _ = MESSAGE.unpack(file.read(MESSAGE.size))
            bag.loose.extend((time, channel, file.tell(), size - MESSAGE.size))
        elif kind in {SCHEMA, CHANNEL, STATISTICS} and size <= LONGEST:
            data = file.read(size)
            if kind == SCHEMA:
                schemas.add(data)
            elif kind == CHANNEL:
                bag.channels.setdefault(*schemas.channel(data))
            else:
                channels, bag.stated = _statistics(data)
        if size > left:
            bag.cut = (
                f"byte {start}: the recording was cut here, {left} bytes into a chunk of {size}; "
                "what is whole was read"
            )
            break
        file.seek(start + RECORD.size + size)
    bag.complete = channels is not None and len(bag.channels) >= channels


def _chunk(bag: BagFile, file: BinaryIO, size: int) -> None:
    """Note where a chunk's content is; `size` bytes of it and its head are there."""
    start = file.tell()
    head = _Reader(file.read(min(size, 1 << 12)))
    try:
        begin, _, unpacked, crc = head.unpack("<QQQI")
        compression = head.text()
        (packed,) = head.unpack("<Q")
    except ValueError:
        if size > 1 << 12:
            raise
        return  # cut within its head
    at = start + CHUNK.size + 4 + len(compression.encode()) + 8
    packed = min(packed, start + size - at)
    bag.chunks.append(Chunk(at, packed, compression, unpacked, begin, crc))


def _statistics(data: bytes) -> tuple[int, dict[int, int]]:
    """Return the number of channels, and of each one's messages."""
    fields = _Reader(data)
    channels = fields.unpack("<QHIIIIQQ")[2]
    counts = _Reader(fields.take(fields.unpack("<I")[0]))
    found: dict[int, int] = {}
    while True:
        try:
            channel, count = counts.unpack("<HQ")
        except ValueError:
            return channels, found
        found[channel] = count
