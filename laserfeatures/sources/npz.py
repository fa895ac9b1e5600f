"""NumPy archives (`.npz`) of scans with the same beams.

- ``ranges``: (M, N) or (N,) [m]; 0, inf and nan are no returns
- ``angles``: (N,) [rad], increasing or decreasing
- ``stamps``: (M,) [s], optional
- ``poses``: (M, 3) x, y, theta [m, m, rad], optional; nan is none
- ``range_min``, ``range_max``: numbers [m], optional

The archive does not say what its poses are; they count as odometry, or as what is asked for.
"""

import io
import math
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, read_only
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.errors import SourceError, shown
from laserfeatures.sources.files import DAMAGE, is_bomb, is_gzip, open_stream
from laserfeatures.sources.log import Log, Scans

NAMES = ("angles", "stamps", "poses", "range_min", "range_max")


def read_npz(log: Log) -> Scans:
    """Yield the scans of an archive; the arrays are read whole.

    Raises
    ------
    SourceError
        If the archive is damaged, or an array is missing or has the wrong shape.
    """
    arrays = _load(log)
    try:
        ranges = np.atleast_2d(arrays.pop("ranges"))
        ranges = read_only(ranges, "ranges", (None, None))
        scans, beams = ranges.shape
        shapes = dict(zip(NAMES, ((beams,), (scans,), (scans, 3), (), ()), strict=True))
        checked = {name: read_only(array, name, shapes[name]) for name, array in arrays.items()}
    except ValueError as error:
        raise SourceError(f"{log.path}: expected arrays that fit: {error}") from error
    angles = checked["angles"]
    if angles.size > 1 and angles[0] > angles[-1]:
        angles, ranges = read_only(angles[::-1], "angles", (None,)), ranges[:, ::-1]
    limits: dict[str, float] = {
        name: float(checked[name]) for name in ("range_min", "range_max") if name in checked
    }
    if log.range_max is not None:
        limits["range_max"] = log.range_max
    log.poses = (log.wanted or "odometry") if "poses" in checked else "none"
    stamps = checked.get("stamps", np.full(len(ranges), math.nan))
    poses = checked.get("poses", np.full((len(ranges), 3), math.nan))
    yield from _scans(log, angles, ranges, stamps, poses, limits)


def _scans(
    log: Log,
    angles: FloatArray,
    ranges: FloatArray,
    stamps: FloatArray,
    poses: FloatArray,
    limits: dict[str, float],
) -> Scans:
    for number, row in enumerate(ranges):
        try:
            pose = Pose2D(*poses[number].tolist()) if np.isfinite(poses[number]).all() else None
            stamp = float(stamps[number])
            scan = LaserScan(angles=angles, ranges=row, stamp=stamp, pose=pose, **limits)
        except ValueError as error:
            log.broken(f"scan {number}", error, error)
            continue
        yield scan


def _as_floats(array: NDArray[Any]) -> FloatArray:
    if array.dtype.kind not in "biuf":
        raise TypeError(f"an array of type {array.dtype}")
    with np.errstate(over="ignore", invalid="ignore"):
        return array.astype(np.float64, copy=False)


def _content(path: Path) -> Path | io.BytesIO:
    """Return what NumPy can read: gzip data are unpacked, as they cannot be sought in."""
    if not is_gzip(path):
        return path
    content = io.BytesIO()
    packed = path.stat().st_size
    with open_stream(path) as stream:
        while block := stream.read(1 << 20):
            content.write(block)
            if is_bomb(content.tell(), packed):
                raise ValueError(f"{packed} packed bytes of more than {content.tell()}")
    content.seek(0)
    return content


def _check_sizes(archive: zipfile.ZipFile, known: set[str]) -> None:
    """Look at what the arrays say of themselves before there is memory for them.

    Raises
    ------
    ValueError
        If that is more than their bytes can hold, or these are packed as no measured data are.
    """
    for member in archive.infolist():
        if member.filename.removesuffix(".npy") not in known:
            continue
        if is_bomb(member.file_size, member.compress_size):
            raise ValueError(
                f"{member.filename}: {member.compress_size} packed bytes of {member.file_size}"
            )
        with archive.open(member) as file:
            version = np.lib.format.read_magic(file)
            read = np.lib.format.read_array_header_1_0
            if version != (1, 0):
                read = np.lib.format.read_array_header_2_0
            shape, _, kind = read(file)
        if max(math.prod(shape) * kind.itemsize, *shape, 0) > member.file_size:
            raise ValueError(f"{member.filename}: {shape} numbers in {member.file_size} bytes")


def _load(log: Log) -> dict[str, FloatArray]:
    """Return the known arrays of the archive."""
    known = {"ranges", *NAMES}
    try:
        content = _content(log.path)
    except DAMAGE as error:
        raise SourceError(
            f"{log.path}: the gzip data are cut or damaged ({error}); fetch the file again"
        ) from error
    except ValueError as error:
        raise SourceError(f"{log.path}: expected measured data, got {error}") from error
    try:
        with zipfile.ZipFile(content) as zipped:
            _check_sizes(zipped, known)
        with np.load(content, allow_pickle=False) as archive:
            arrays = {name: _as_floats(archive[name]) for name in archive.files if name in known}
            names = ", ".join(archive.files)
    except Exception as error:
        text = shown(str(error))
        raise SourceError(
            f"{log.path}: expected a .npz archive of number arrays, got: {text}; write it again "
            "with numpy.savez"
        ) from error
    if not {"ranges", "angles"} <= arrays.keys():
        raise SourceError(
            f"{log.path}: expected the arrays ranges and angles, got {names or 'none'}"
        )
    return arrays
