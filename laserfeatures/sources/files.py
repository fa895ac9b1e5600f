"""Opening files: plain or gzip is told by the first bytes, never by the name."""

import gzip
import zlib
from pathlib import Path
from typing import BinaryIO, cast

from laserfeatures.errors import SourceError

GZIP_MAGIC = b"\x1f\x8b"
MARK = b"\xef\xbb\xbf"  # the byte-order mark of UTF-8, which is no content
WIDE_MARKS = (b"\xff\xfe", b"\xfe\xff")
LONGEST_LINE = 1 << 22  # bytes; a scan of 100,000 beams takes 1 MB
MOST_BEAMS = 1_000_000  # of a scan that is put together from lines
LARGE, SWOLLEN = 1 << 26, 200  # bytes; times: logs unpack to 3 to 30 times their size
HEAD_BYTES = 1 << 16  # enough for the longest preamble seen (171 PARAM lines)
DAMAGE = (EOFError, OSError, zlib.error)  # what reading a damaged gzip file raises


def check_regular(path: Path) -> None:
    """Refuse what cannot be read twice or has no end, without opening it: that might block.

    Raises
    ------
    SourceError
        If there is something at `path` that is neither a file nor a folder.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise SourceError(
            f"{path}: expected a file or folder, got a pipe or device, which cannot be read twice; "
            "write it to a file first"
        )


def is_gzip(path: Path) -> bool:
    """Return whether the file at `path` is gzip data."""
    try:
        with path.open("rb") as file:
            return file.read(2) == GZIP_MAGIC
    except OSError as error:
        raise cannot_open(path, error) from error


def open_stream(path: Path) -> BinaryIO:
    """Open the file at `path` for reading bytes, unpacked if it is gzip data."""
    packed = is_gzip(path)
    try:
        return cast("BinaryIO", gzip.open(path, "rb")) if packed else path.open("rb")
    except OSError as error:
        raise cannot_open(path, error) from error


def is_bomb(unpacked: int, packed: int) -> bool:
    """Return whether so many bytes out of so many packed ones are no data that anybody measured."""
    return unpacked > LARGE and unpacked > SWOLLEN * packed


def read_head(path: Path) -> bytes:
    """Return the first bytes of the file at `path`, unpacked, as far as they can be unpacked.

    Raises
    ------
    SourceError
        If the file cannot be opened or is empty.
    """
    try:
        with path.open("rb") as file:
            raw = file.read(HEAD_BYTES)
    except OSError as error:
        raise cannot_open(path, error) from error
    if not raw:
        raise SourceError(f"{path}: the file is empty; expected a log, table or bag of laser scans")
    head = _unpack(raw) if raw.startswith(GZIP_MAGIC) else raw
    if not head:
        raise SourceError(
            f"{path}: the gzip data hold no content, or are damaged at the start; "
            "fetch or write the file again"
        )
    if head.startswith(WIDE_MARKS):
        raise SourceError(f"{path}: expected text in UTF-8, got UTF-16; write it as UTF-8")
    return head.removeprefix(MARK)


def _unpack(raw: bytes) -> bytes:
    """Unpack the start of gzip data; unlike the gzip module, give what comes before a damage."""
    unpacker = zlib.decompressobj(wbits=31)
    head = b""
    try:
        for start in range(0, len(raw), 512):
            head += unpacker.decompress(raw[start : start + 512], HEAD_BYTES)
    except zlib.error:
        pass  # the reader meets the damage again, and says where
    return head[:HEAD_BYTES]


def cannot_open(path: Path, error: OSError) -> SourceError:
    """Say in one line why the file at `path` cannot be opened."""
    return SourceError(f"{path}: cannot be opened: {error.strerror or error}")
