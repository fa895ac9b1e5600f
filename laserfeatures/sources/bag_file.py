"""What files of recorded messages share: channels, chunks, and messages read without an index.

An index may be missing, be of an old writer, or cover only a part of the chunks, so none is used:
the chunks are walked through one by one, and what they hold is held against what the file says of
itself.
"""

import bz2
import heapq
import importlib
import sys
from array import array
from binascii import crc32
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import numpy as np

LARGEST_CHUNK = 1 << 27  # bytes; recorders write 1 to 50 MB
BLOCK = 1 << 16
ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


class Channel(NamedTuple):
    """A topic's connection.

    Attributes
    ----------
    topic, kind : str
        The topic and its type, as ``sensor_msgs/msg/LaserScan``.
    encoding : str
        Of its messages: "ros1", "cdr" or another.
    form, definition : str
        How the type is defined ("ros2msg", ..), and by what.
    """

    topic: str
    kind: str
    encoding: str
    form: str
    definition: str


class Message(NamedTuple):
    """A message: when it was recorded [ns], its channel's number, its bytes."""

    time: int
    channel: int
    data: bytes


class Chunk(NamedTuple):
    """Where a chunk's content is, how it is packed, when it begins [ns], if that is known."""

    at: int
    packed: int
    compression: str
    unpacked: int
    begin: int
    crc: int = 0


Report = Callable[[str, Exception], None]


@dataclass
class BagFile:
    """A file of recorded messages that was walked through.

    Attributes
    ----------
    path : Path
        The file.
    inside : callable
        From the bytes of a chunk to the messages and channels in it.
    channels : dict
        By their numbers.
    chunks : list of Chunk
        In the order of the file.
    loose : array
        Where messages are that are in no chunk; of each its time [ns], channel, place, size.
    stated : dict or None
        How many messages each channel has, as the file says of itself.
    complete : bool
        Whether the file names all its channels outside the chunks.
    cut : str or None
        Where the file ends too early, and how.
    """

    path: Path
    inside: Callable[[bytes], Iterator["Message | tuple[int, Channel]"]]
    channels: dict[int, Channel] = field(default_factory=dict)
    chunks: list[Chunk] = field(default_factory=list)
    loose: "array[int]" = field(default_factory=lambda: array("Q"))
    stated: dict[int, int] | None = None
    complete: bool = False
    cut: str | None = None

    def find_channels(self) -> None:
        """Look for channels inside the chunks, where the file does not list them."""
        if self.complete:
            return
        with self.path.open("rb") as file:
            for chunk in self.chunks:
                content, _ = self._content(file, chunk)
                try:
                    for record in self.inside(content):
                        if not isinstance(record, Message):
                            self.channels.setdefault(*record)
                except ValueError:
                    continue  # told when the messages are read

    def messages(self, wanted: set[int], report: Report) -> Iterator[Message]:
        """Yield the messages of some channels in the order of their times.

        What is damaged is told to `report`, which raises or goes on.
        """
        with self.path.open("rb") as file:
            parts = [self._part(file, chunk, wanted, report) for chunk in self.chunks]
            parts.append(self._loose(file, wanted))
            timed = all(chunk.begin for chunk in self.chunks)  # else the file's order has to do
            merged = heapq.merge(*parts, key=lambda message: message.time)
            for message in merged if timed else chain(*parts):
                if message.channel >= 0:
                    yield message

    def _loose(self, file: BinaryIO, wanted: set[int]) -> Iterator[Message]:
        rows = np.array(self.loose, dtype=np.uint64).reshape(-1, 4)
        for row in rows[np.argsort(rows[:, 0], kind="stable")]:
            time, channel, at, size = row.tolist()
            if channel in wanted:
                file.seek(at)
                yield Message(time, channel, file.read(size))

    def _part(
        self, file: BinaryIO, chunk: Chunk, wanted: set[int], report: Report
    ) -> Iterator[Message]:
        yield Message(chunk.begin, -1, b"")  # so that it is unpacked when its time has come
        content, problem = self._content(file, chunk)
        found = []
        try:
            for record in self.inside(content):
                if isinstance(record, Message) and record.channel in wanted:
                    found.append(record)  # noqa: PERF401 - what came before an error is kept
        except ValueError as error:
            problem = problem or error
        if problem and not (self.cut and chunk is self.chunks[-1]):
            report(f"byte {chunk.at}", problem)
        yield from sorted(found, key=lambda message: message.time)

    def _content(self, file: BinaryIO, chunk: Chunk) -> tuple[bytes, Exception | None]:
        """Return a chunk's bytes as far as they can be unpacked, and what is wrong with them."""
        if chunk.unpacked > LARGEST_CHUNK:
            problem = f"expected a chunk of at most {LARGEST_CHUNK} bytes, got {chunk.unpacked}"
            return b"", ValueError(problem)
        file.seek(chunk.at)
        content, error = unpacked(file.read(chunk.packed), chunk.compression, chunk.unpacked)
        if error is None and len(content) != chunk.unpacked:
            got = "more" if len(content) > chunk.unpacked else str(len(content))
            error = ValueError(f"expected a chunk of {chunk.unpacked} bytes, got {got}")
        if error is None and chunk.crc and crc32(content) != chunk.crc:
            return b"", ValueError("expected a chunk that fits its checksum, got another")
        return content[: chunk.unpacked], error


def unpacked(data: bytes, compression: str, size: int) -> tuple[bytes, Exception | None]:
    """Unpack data as far as possible, a byte more than `size` at most.

    Returns
    -------
    (bytes, Exception or None)
        What came out, and what stopped it.
    """
    if compression in {"", "none"}:
        return data[: size + 1], None
    try:
        unpacker = _unpacker(compression)
    except ValueError as error:
        return b"", error
    out = bytearray()
    at = 0
    try:
        while not unpacker.eof and len(out) <= size:
            block = data[at : at + BLOCK] if unpacker.needs_input else b""
            if unpacker.needs_input and not block:
                break
            at += len(block)
            out += unpacker.decompress(block, size + 1 - len(out))
    except Exception as error:  # noqa: BLE001 - each of the libraries has its own
        return bytes(out), ValueError(f"the {compression} data are damaged: {error}")
    return bytes(out), None


def _unpacker(compression: str) -> Any:
    if compression == "bz2":
        return bz2.BZ2Decompressor()
    if compression == "lz4":  # this and zstd come with rosbags
        return importlib.import_module("lz4.frame").LZ4FrameDecompressor()
    if compression == "zstd":
        name = "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
        return importlib.import_module(name).ZstdDecompressor()
    raise ValueError(f"expected chunks packed with bz2, lz4, zstd or not, got {compression[:40]!r}")
