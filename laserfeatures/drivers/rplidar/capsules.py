"""The capsules of express scans: 84 bytes with 32 measurements, their angles relative to a start.

A capsule tells where it starts; where it ends, only the next one tells.

References
----------
Slamtec, "RPLIDAR interface protocol and application notes"; Slamtec/rplidar_sdk,
``sl_lidar_driver.cpp``, which reads the angle corrections as unsigned, as is done here.
"""

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.drivers.rplidar.nodes import DEGREE, FINE, TURN, Measurements
from laserfeatures.drivers.rplidar.packets import checksum
from laserfeatures.errors import ProtocolError

HEAD = 4  # bytes
CAPSULE = 84  # bytes
SAMPLES = 32
FIRST = 0x8000  # set in the first capsule of a stream
QUALITY = 47  # what the vendor's library gives to a return, as capsules tell none
THETA = DEGREE // 8  # the unit of an angle correction
LARGEST_THETA = 0x3F
LARGEST = 0x3FFF  # [mm]

CABIN = np.dtype([("first", "<u2"), ("second", "<u2"), ("theta", "u1")])


def capsule_fits(data: bytes) -> bool:
    """Return whether the marks, start angle and checksum of a capsule of any kind are right."""
    if data[0] >> 4 != 0xA or data[1] >> 4 != 0x5 or (data[3] & 0x7F) << 8 | data[2] > TURN // FINE:
        return False
    folded = int.from_bytes(data[HEAD - 2 :], "little")
    for bits in (1024, 512, 256, 128, 64, 32, 16, 8):
        folded = folded >> bits ^ folded & (1 << bits) - 1
    return folded == (data[0] & 0xF) | (data[1] & 0xF) << 4


def start_of(data: bytes) -> tuple[int, bool]:
    """Return a capsule's start angle [1/2048 degree], and whether it is the first of a stream."""
    word = data[2] | data[3] << 8
    return (word & ~FIRST) * FINE % TURN, bool(word & FIRST)


def head(start: int, body: bytes, *, first: bool = False) -> bytes:
    """Return a capsule of any kind: marks, checksum, start angle [1/2048 degree], body."""
    word = start // FINE % (TURN // FINE) | (FIRST if first else 0)
    rest = word.to_bytes(2, "little") + body
    check = checksum(rest)
    return bytes((0xA0 | check & 0xF, 0x50 | check >> 4)) + rest


def raw_angles(starts: IntArray, spans: IntArray, samples: int) -> IntArray:
    """Return the uncorrected angles (C, samples) [1/2048 degree] of capsules, not wrapped."""
    return starts[:, None] + spans[:, None] * np.arange(samples) // samples


def unpack_capsules(data: bytes, starts: IntArray, spans: IntArray) -> Measurements:
    """Return the measurements of whole capsules.

    Parameters
    ----------
    data : bytes
        C capsules, each checked.
    starts, spans : (C,) int arrays
        Where each starts, and how far it is to the start of the next [1/2048 degree].

    Raises
    ------
    ProtocolError
        If it is not C capsules.
    """
    if len(data) != CAPSULE * len(starts):
        raise ProtocolError(f"expected {len(starts)} capsules of 84 bytes, got {len(data)} bytes")
    bodies = np.frombuffer(data, np.uint8).reshape(-1, CAPSULE)[:, HEAD:]
    cabins = np.ascontiguousarray(bodies).view(CABIN)
    words = np.stack((cabins["first"], cabins["second"]), axis=-1).astype(np.int64)
    low = np.stack((cabins["theta"] & 0xF, cabins["theta"] >> 4), axis=-1)
    theta = ((words & 3) << 4 | low) * THETA
    angles = raw_angles(starts, spans, SAMPLES) - theta.reshape(-1, SAMPLES)
    return with_quality(angles, words >> 2)


def with_quality(angles: IntArray, distances: IntArray) -> Measurements:
    """Return measurements whose quality is that of a return where there is one."""
    distance = distances.reshape(-1).astype(np.float64)
    return Measurements(angles.reshape(-1) % TURN, distance, np.where(distance > 0, QUALITY, 0))


def pack_capsule(start: int, theta: IntArray, distances: FloatArray, *, first: bool) -> bytes:
    """Return a capsule.

    Parameters
    ----------
    start : int
        Start angle [1/2048 degree].
    theta : (32,) int array
        What is taken from the angle of each measurement [1/8 degree].
    distances : (32,) array
        Distances [mm]; what does not fit becomes 0.
    first : bool
        Whether it is the first of a stream.
    """
    millimetres = np.where((distances > 0) & (distances <= LARGEST), np.rint(distances), 0)
    words = (millimetres.astype(np.int64) << 2 | theta >> 4).reshape(-1, 2)
    cabins = np.empty(SAMPLES // 2, CABIN)
    cabins["first"], cabins["second"] = words.T
    low = (theta & 0xF).reshape(-1, 2)
    cabins["theta"] = low[:, 0] | low[:, 1] << 4
    return head(start, cabins.tobytes(), first=first)
