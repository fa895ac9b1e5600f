"""The frames of the LD06 and LD19: 47 bytes with twelve measurements and a CRC-8.

References
----------
The vendor's driver ldlidar_stl_ros2, lipkg.cpp.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray
from laserfeatures.errors import ProtocolError

HEAD = b"\x54\x2c"  # version 1, twelve points
POINTS = 12
SIZE = 47
TURN = 36_000  # [0.01 deg]
WIDEST = TURN // 8  # [0.01 deg] that one frame may cover: a motor that hardly turns makes it less
CLOCK_MS = 30_000  # where the frame's clock begins again
POLYNOMIAL = 0x4D

_POINT = np.dtype([("range", "<u2"), ("intensity", "u1")])
_FRAME = np.dtype(
    [
        ("head", "<u2"),
        ("speed", "<u2"),
        ("start", "<u2"),
        ("points", _POINT, POINTS),
        ("end", "<u2"),
        ("time", "<u2"),
        ("crc", "u1"),
    ]
)


@dataclass(frozen=True)
class Frame:
    """Twelve measurements in a row.

    Parameters
    ----------
    speed : int
        Of the motor [deg/s].
    start, end : int
        Clockwise angle of the first and last measurement [0.01 deg].
    ranges : (12,) int array
        Ranges [mm]; 0 is no return.
    intensities : (12,) int array
        Intensities, 0 to 255.
    time : int
        The device's clock [ms], from 0 again at 30 000.
    """

    speed: int
    start: int
    end: int
    ranges: NDArray[np.uint16]
    intensities: NDArray[np.uint8]
    time: int

    @property
    def angles(self) -> FloatArray:
        """Clockwise angle of each measurement [deg], (12,), going beyond 360 where it wraps."""
        step = (self.end - self.start) % TURN / (POINTS - 1)
        return (self.start + step * np.arange(POINTS)) / 100


def decode(data: bytes) -> Frame:
    """Return the frame that 47 bytes make.

    Raises
    ------
    ProtocolError
        If they are no frame: the length, the first two bytes, the CRC or an angle is wrong.
    """
    if len(data) != SIZE or not data.startswith(HEAD):
        raise ProtocolError(
            f"an LD19 frame must be {SIZE} bytes from 54 2c on, got {len(data)} bytes "
            f"from {data[:2].hex(' ')} on"
        )
    if crc8(data[:-1]) != data[-1]:
        raise ProtocolError(
            f"an LD19 frame must end in its CRC {crc8(data[:-1]):02x}, got {data[-1]:02x}"
        )
    (fields,) = np.frombuffer(data, _FRAME)
    start, end = int(fields["start"]), int(fields["end"])
    if not (start < TURN and end < TURN and (end - start) % TURN <= WIDEST):
        raise ProtocolError(
            f"an LD19 frame must cover up to {WIDEST / 100:g} deg of a turn, got "
            f"{start / 100:g} to {end / 100:g} deg"
        )
    points = fields["points"]
    return Frame(
        speed=int(fields["speed"]),
        start=start,
        end=end,
        ranges=points["range"],
        intensities=points["intensity"],
        time=int(fields["time"]),
    )


def encode(frame: Frame) -> bytes:
    """Return the 47 bytes of a frame."""
    fields = np.zeros(1, _FRAME)
    fields["head"] = int.from_bytes(HEAD, "little")
    fields["speed"], fields["start"], fields["end"] = frame.speed, frame.start, frame.end
    fields["points"]["range"] = frame.ranges
    fields["points"]["intensity"] = frame.intensities
    fields["time"] = frame.time
    body = fields.tobytes()[:-1]
    return body + bytes([crc8(body)])


def crc8(data: bytes) -> int:
    """Return the CRC-8 of some bytes: polynomial 4D, from 0, not reflected."""
    crc = 0
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc


def _table() -> bytes:
    table = bytearray(range(256))
    for _ in range(8):
        for i, value in enumerate(table):
            table[i] = (value << 1 & 0xFF) ^ (POLYNOMIAL if value & 0x80 else 0)
    return bytes(table)


_TABLE = _table()
