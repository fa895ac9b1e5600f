"""The measurements of a standard scan: nodes of five bytes.

Angles are whole numbers of 1/2048 degree, clockwise from the front; distances are millimetres.
"""

from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.errors import ProtocolError

NODE = 5  # bytes
DEGREE = 2048
TURN = 360 * DEGREE
FINE = DEGREE // 64  # the unit of a node's angle
LARGEST = 0xFFFF / 4  # [mm]

LAYOUT = np.dtype([("quality", "u1"), ("angle", "<u2"), ("distance", "<u2")])


class Measurements(NamedTuple):
    """What was measured, in the order of time.

    Attributes
    ----------
    angles : (N,) int array
        Directions [1/2048 degree], clockwise from the front, in [0, `TURN`).
    distances : (N,) array
        Distances [mm]; 0: no return.
    quality : (N,) int array
        Strength of the echo, 0 .. 63.
    """

    angles: IntArray
    distances: FloatArray
    quality: IntArray


def in_sync(node: bytes) -> bool:
    """Return whether the check bits of a node's first two bytes are right."""
    return (node[0] ^ node[0] >> 1) & node[1] & 1 == 1


def unpack_nodes(data: bytes) -> Measurements:
    """Return the measurements of whole nodes; their check bits have been looked at.

    Raises
    ------
    ProtocolError
        If it is not a whole number of nodes.
    """
    if len(data) % NODE:
        raise ProtocolError(f"expected nodes of {NODE} bytes, got {len(data)} bytes")
    nodes = np.frombuffer(data, LAYOUT)
    return Measurements(
        (nodes["angle"] >> 1).astype(np.int64) * FINE % TURN,
        nodes["distance"] / 4.0,
        (nodes["quality"] >> 2).astype(np.int64),
    )


def pack_nodes(measured: Measurements, starts: BoolArray) -> bytes:
    """Return measurements as nodes.

    Parameters
    ----------
    measured : Measurements
        What is packed; distances that do not fit become 0.
    starts : (N,) bool array
        Which are the first of a turn.

    Examples
    --------
    >>> first = Measurements(np.array([90 * DEGREE]), np.array([1234.5]), np.array([47]))
    >>> pack_nodes(first, np.array([True])).hex(" ")
    'bd 01 2d 4a 13'
    """
    nodes = np.empty(len(starts), LAYOUT)
    nodes["quality"] = measured.quality << 2 | np.where(starts, 1, 2)
    nodes["angle"] = measured.angles // FINE << 1 | 1
    fits = (measured.distances > 0) & (measured.distances <= LARGEST)
    nodes["distance"] = np.where(fits, np.rint(measured.distances * 4), 0)
    return nodes.tobytes()
