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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, read_only
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.sources.files import DAMAGE, open_stream
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
        return array.astype(np.float64)


def _load(log: Log) -> dict[str, FloatArray]:
    """Return the known arrays of the archive."""
    try:
        with open_stream(log.path) as stream:
            content = io.BytesIO(stream.read())  # unpacked gzip data cannot be sought in
    except DAMAGE as error:
        raise SourceError(
            f"{log.path}: the gzip data are cut or damaged ({error}); fetch the file again"
        ) from error
    known = {"ranges", *NAMES}
    try:
        with np.load(content, allow_pickle=False) as archive:
            arrays = {name: _as_floats(archive[name]) for name in archive.files if name in known}
            names = ", ".join(archive.files)
    except Exception as error:
        raise SourceError(
            f"{log.path}: expected a .npz archive of number arrays, got: {error}; write it again "
            "with numpy.savez"
        ) from error
    if not {"ranges", "angles"} <= arrays.keys():
        raise SourceError(
            f"{log.path}: expected the arrays ranges and angles, got {names or 'none'}"
        )
    return arrays
