"""What a PCD or PLY file says of itself, held against what it holds.

Open3D takes whatever was in memory for the points that a cut file lacks, and 0 for a word among
numbers or for numbers of a type it does not know. Files are therefore checked before it reads them.

References
----------
PCD: Point Cloud Library, "The PCD (Point Cloud Data) file format".
PLY: G. Turk, "The PLY polygon file format", 1994.
"""

import os
import struct
import warnings
from collections.abc import Iterator
from itertools import accumulate, islice
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from laserfeatures.errors import SourceError

LONGEST_HEADER = 1000  # lines
LONGEST_LINE = 4096  # bytes
PLY_SIZES = {  # bytes; of a list, what an empty one takes
    **dict.fromkeys(("char", "uchar", "int8", "uint8", "list"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "float64"), 8),
}
PCD_KINDS = {"F4", *(f"{sign}{size}" for sign in "IU" for size in (1, 2, 4))}
LZF_MOST = 88  # bytes that one packed byte can stand for
PCD_DATA = {"ascii": "text", "binary": "binary", "binary_compressed": "compressed"}


class Layout(NamedTuple):
    """Where a file has its points.

    Attributes
    ----------
    form : {"pcd", "ply"}
        The format.
    data : {"text", "binary", "compressed"}
        How they are written.
    points : int
        Number of points.
    columns : dict
        From the name of each field to its place among the numbers of a point.
    width : int
        How many numbers a point has.
    size : int
        How many bytes a point has where it is not text.
    before : int
        Lines of text, or bytes, between header and points.
    wide : bool
        Whether x, y or z is of a type that only Open3D's tensor reader may know, as float64.
    """

    form: str
    data: str
    points: int
    columns: dict[str, int]
    width: int
    size: int
    before: int = 0
    wide: bool = False


def check_file(path: Path) -> Layout:
    """Return the layout of the PCD or PLY file at `path` if it holds the points it speaks of.

    Raises
    ------
    SourceError
        If not; the message says what was expected and what came.
    """
    try:
        with path.open("rb") as file:
            return _check_content(file)
    except OSError as error:
        raise SourceError(f"{path}: cannot be opened: {error.strerror or error}") from error
    except ValueError as error:
        raise SourceError(f"{path}: {error}") from error


def is_point_cloud(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a PCD or PLY file."""
    return _form(head) is not None


def _form(head: bytes) -> str | None:
    if head.startswith((b"# .PCD", b"VERSION")):
        return "pcd"
    return "ply" if head.startswith((b"ply\n", b"ply\r\n")) else None


def _check_content(file: BinaryIO) -> Layout:
    start = file.read(8)
    file.seek(0)
    form = _form(start)
    if form is None:
        raise ValueError(f"expected a PCD or PLY file, got one that starts with {start!r}")
    layout = _pcd_layout(file) if form == "pcd" else _ply_layout(file)
    if not {"x", "y", "z"} <= layout.columns.keys():
        fields = " ".join(layout.columns)[:60]
        raise ValueError(f"expected points with x, y and z, got the fields {fields or 'none'}")
    if not layout.points:
        raise ValueError("expected points, got an empty cloud")
    if layout.data == "text":
        _check_text(file, layout)
    else:
        _check_size(file, layout)
    return layout


def _pcd_layout(file: BinaryIO) -> Layout:
    lines = {words[0]: words[1:] for words in _header(file, "DATA")}
    names = lines.get("FIELDS", [])
    sizes = _whole("SIZE", lines.get("SIZE", []), len(names))
    counts = _whole("COUNT", lines.get("COUNT", ["1"] * len(names)), len(names))
    data = " ".join(lines["DATA"])
    if data not in PCD_DATA:
        raise ValueError(f"expected DATA to be one of {', '.join(PCD_DATA)}, got {data[:40]!r}")
    types = lines.get("TYPE", ["F"] * len(names))
    kinds = {name: f"{kind}{size}" for name, kind, size in zip(names, types, sizes, strict=False)}
    wide = not PCD_KINDS.issuperset(kinds.get(axis) for axis in "xyz")
    if wide and len(kinds) < len(names):  # that would crash Open3D
        raise ValueError(
            "expected x, y and z of at most 4 bytes where fields share a name, "
            f"got TYPE and SIZE {' '.join(kinds.values())[:60]}"
        )
    if "POINTS" in lines:
        (points,) = _whole("POINTS", lines["POINTS"], 1)
    else:
        width, height = (_whole(word, lines.get(word, []), 1)[0] for word in ("WIDTH", "HEIGHT"))
        points = width * height
    return Layout(
        form="pcd",
        data=PCD_DATA[data],
        points=points,
        columns=dict(zip(names, accumulate([0, *counts]), strict=False)),
        width=sum(counts),
        size=sum(size * count for size, count in zip(sizes, counts, strict=True)),
        wide=wide,
    )


def _ply_layout(file: BinaryIO) -> Layout:
    data = ""
    numbers: dict[str, int] = {}  # of each element
    types: dict[str, dict[str, str]] = {}  # of its properties
    for words in _header(file, "end_header"):
        match words:
            case ["format", "ascii", *_]:
                data = "text"
            case ["format", "binary_little_endian" | "binary_big_endian", *_]:
                data = "binary"
            case ["element", element, number]:
                (numbers[element],) = _whole(f"element {element}", [number], 1)
                types[element] = {}
            case ["property", kind, *_, name] if kind in PLY_SIZES and types:
                types[element][name] = kind
            case ["ply" | "comment" | "obj_info" | "end_header", *_]:
                pass
            case _:
                raise ValueError(f"expected the header of a PLY file, got {' '.join(words)[:60]!r}")
    if not data or "vertex" not in types:
        raise ValueError("expected a header with a format and the element vertex, got none")
    before = 0
    for element, count in numbers.items():
        size = sum(PLY_SIZES[kind] for kind in types[element].values())
        if element == "vertex":
            break
        before += count * (1 if data == "text" else size)
    columns = {name: column for column, name in enumerate(types["vertex"])}
    return Layout("ply", data, numbers["vertex"], columns, len(columns), size, before)


def _header(file: BinaryIO, last: str) -> Iterator[list[str]]:
    """Yield the words of each line up to the one that starts with `last`."""
    for line in islice(iter(lambda: file.readline(LONGEST_LINE), b""), LONGEST_HEADER):
        words = line.decode("ascii", "backslashreplace").split()
        if words:
            yield words
        if words[:1] == [last]:
            return
    raise ValueError(f"expected a header that ends with {last}, got none; the file is cut")


def _whole(what: str, words: list[str], count: int) -> list[int]:
    if len(words) != count or not all(word.isdecimal() for word in words):
        got = " ".join(words)[:40] or "nothing"
        raise ValueError(f"expected {what} with {count} whole numbers, got {got}")
    return [int(word) for word in words]


def _check_text(file: BinaryIO, layout: Layout) -> None:
    lines = islice(
        (line for line in file if line.strip()), layout.before, layout.before + layout.points
    )
    # The last number as well: Open3D passes over a point that is not complete.
    columns = [*(layout.columns[axis] for axis in "xyz"), layout.width - 1]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # about no lines at all: told below
        try:
            rows = len(np.loadtxt(lines, usecols=columns, ndmin=2, comments=None))
        except ValueError as error:
            raise ValueError(f"expected a line of numbers for each point: {error}") from error
    if rows < layout.points:
        raise ValueError(f"expected {layout.points} lines of points, got {rows}; the file is cut")


def _check_size(file: BinaryIO, layout: Layout) -> None:
    need = layout.before + layout.points * layout.size
    if layout.data == "compressed":
        sizes = file.read(8)
        packed, unpacked = struct.unpack("<II", sizes) if len(sizes) == 8 else (0, 0)
        if unpacked != need:
            raise ValueError(f"expected {need} bytes of points, got {unpacked} packed ones")
        if unpacked > LZF_MOST * packed + LZF_MOST:
            raise ValueError(f"expected {unpacked} bytes of points, got {packed} packed ones")
        need = packed
    have = os.fstat(file.fileno()).st_size - file.tell()
    if have < need:
        raise ValueError(f"expected {need} bytes of points, got {have}; the file is cut")
