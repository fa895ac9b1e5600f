"""The capsules of the faster scans: ultra ("boost"), 132 bytes of 96, dense, 84 bytes of 40.

Three measurements of an ultra capsule share 32 bits: the first distance in steps that grow with it,
the second as a difference to the first, the third as one to the first of the next three.

References
----------
Slamtec/rplidar_sdk, ``sdk/src/sl_lidar_driver.cpp``: the only public description of both.
"""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.drivers.rplidar.capsule_turns import Kind
from laserfeatures.drivers.rplidar.capsules import CAPSULE, HEAD, head, raw_angles, with_quality
from laserfeatures.drivers.rplidar.nodes import DEGREE, Measurements
from laserfeatures.errors import ProtocolError

ULTRA_CAPSULE = 132  # bytes
ULTRA_SAMPLES = 96
DENSE_SAMPLES = 40
LARGEST_DENSE = 0xFFFF  # [mm]

# Where each step size begins: in millimetres, and as a code. The step is 1 mm << its index.
BEGINS = np.array([0, 512, 2048, 4096, 16384])
CODES = np.array([0, 512, 1280, 1792, 3328])
LARGEST_CODE = 0xFFF
NOTHING = (-512, 511)  # differences that stand for no return

# How far the ray is turned from the sensor's own angle, in 2**-16 radian: near things more.
FAR_OFFSET = int(math.radians(8) * 65536)
NO_RETURN_OFFSET = int(math.radians(7.5) * 65536)
NEAR = 98361  # quarter millimetres
CUBIC = 98304
NEAREST = 50  # [mm]; below that the offset is that of no return
TO_UNITS = math.degrees(1) * DEGREE / 65536


class Steps(NamedTuple):
    """Distances (N,) [mm] in steps that grow with them, and the logarithms of the steps (N,)."""

    distances: IntArray
    levels: IntArray


def steps_of(codes: IntArray) -> Steps:
    """Return the distances of codes (N,)."""
    levels = np.searchsorted(CODES, codes, side="right") - 1
    return Steps(BEGINS[levels] + (codes - CODES[levels] << levels), levels)


def codes_of(distances: IntArray) -> IntArray:
    """Return the codes of distances (N,) [mm]; 0 where they are too large."""
    levels = np.searchsorted(BEGINS, distances, side="right") - 1
    codes: IntArray = CODES[levels] + (distances - BEGINS[levels] >> levels)
    return np.where(codes <= LARGEST_CODE, codes, 0)


def offsets(distances: IntArray) -> IntArray:
    """Return how far rays of these distances (N,) [mm] are turned back [1/2048 degree]."""
    near = NEAR // np.maximum(distances * 4, 1)
    turned = FAR_OFFSET - near * 64 - near**3 // CUBIC
    turned = np.where(distances >= NEAREST, turned, NO_RETURN_OFFSET)
    return np.rint(turned * TO_UNITS).astype(np.int64)


def unpack_ultra(data: bytes, starts: IntArray, spans: IntArray, following: bytes) -> Measurements:
    """Return the measurements of whole ultra capsules.

    Parameters
    ----------
    data : bytes
        C capsules, each checked.
    starts, spans : (C,) int arrays
        Where each starts, and how far it is to the start of the next [1/2048 degree].
    following : bytes
        The first four bytes of the body of the capsule after each.

    Raises
    ------
    ProtocolError
        If there are not C of them.
    """
    if len(data) != ULTRA_CAPSULE * len(starts) or len(following) != 4 * len(starts):
        raise ProtocolError(f"expected {len(starts)} ultra capsules, got {len(data)} bytes")
    words = np.frombuffer(data, "<u4").reshape(-1, ULTRA_CAPSULE // 4)[:, HEAD // 4 :]
    after = np.frombuffer(following, "<u4").reshape(-1, 1)
    words = np.concatenate((words, after), axis=1).astype(np.int64)
    major, levels = steps_of(words & LARGEST_CODE)
    own, next_ = major[:, :-1], major[:, 1:]
    borrowed = (own == 0) & (next_ != 0)
    second = _difference(words[:, :-1] >> 12, np.where(borrowed, levels[:, 1:], levels[:, :-1]),
                         np.where(borrowed, next_, own))  # fmt: skip
    third = _difference(words[:, :-1] >> 22, levels[:, 1:], next_)
    distances = np.stack((own, second, third), axis=-1).reshape(len(starts), -1)
    angles = raw_angles(starts, spans, ULTRA_SAMPLES) - offsets(distances)
    return with_quality(angles, distances)


def pack_ultra(start: int, distances: FloatArray, next_: float, *, first: bool) -> bytes:
    """Return an ultra capsule.

    Parameters
    ----------
    start : int
        Start angle [1/2048 degree].
    distances : (96,) array
        Distances [mm]; what does not fit becomes 0.
    next_ : float
        First distance of the next capsule [mm].
    first : bool
        Whether it is the first of a stream.
    """
    whole = np.where(distances > 0, np.rint(distances), 0).astype(np.int64).reshape(-1, 3)
    codes = codes_of(np.append(whole[:, 0], round(max(next_, 0.0))))
    major, levels = steps_of(codes)
    borrowed = (major[:-1] == 0) & (major[1:] != 0)
    base = np.where(borrowed, major[1:], major[:-1])
    level = np.where(borrowed, levels[1:], levels[:-1])
    words = codes[:-1] | _code(whole[:, 1], level, base) << 12
    words |= _code(whole[:, 2], levels[1:], major[1:]) << 22
    return head(start, words.astype("<u4").tobytes(), first=first)


def unpack_dense(data: bytes, starts: IntArray, spans: IntArray, _: bytes) -> Measurements:
    """Return the measurements of whole dense capsules; parameters as of `unpack_ultra`.

    Raises
    ------
    ProtocolError
        If there are not as many as starts.
    """
    if len(data) != CAPSULE * len(starts):
        raise ProtocolError(f"expected {len(starts)} dense capsules, got {len(data)} bytes")
    distances = np.frombuffer(data, "<u2").reshape(-1, CAPSULE // 2)[:, HEAD // 2 :]
    return with_quality(raw_angles(starts, spans, DENSE_SAMPLES), distances.astype(np.int64))


def pack_dense(start: int, distances: FloatArray, *, first: bool) -> bytes:
    """Return a dense capsule; parameters as of `pack_ultra`, of 40 distances."""
    fits = (distances > 0) & (distances <= LARGEST_DENSE)
    return head(start, np.where(fits, np.rint(distances), 0).astype("<u2").tobytes(), first=first)


def _difference(field: IntArray, levels: IntArray, bases: IntArray) -> IntArray:
    """Return the distances that signed fields of ten bits stand for."""
    signed = (field + 512) % 1024 - 512
    distances = np.maximum((signed << levels) + bases, 0)
    return np.where((signed == NOTHING[0]) | (signed == NOTHING[1]), 0, distances)


def _code(distances: IntArray, levels: IntArray, bases: IntArray) -> IntArray:
    """Return distances as signed fields of ten bits; one too far from its base is no return."""
    signed = distances - bases >> levels
    fits = (distances > 0) & (signed > NOTHING[0]) & (signed < NOTHING[1])
    return np.where(fits, signed, NOTHING[0]) & 0x3FF


ULTRA = Kind(ULTRA_CAPSULE, ULTRA_SAMPLES, unpack_ultra)
DENSE = Kind(CAPSULE, DENSE_SAMPLES, unpack_dense)
