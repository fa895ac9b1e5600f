"""The telegrams of an LMS2xx that carry measured values."""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from laserfeatures.arrays import FloatArray, read_only
from laserfeatures.drivers.lms.ranges import Words
from laserfeatures.drivers.lms.telegrams import Telegram
from laserfeatures.errors import ProtocolError

SCAN, MEAN_SCAN, PART, MEAN_PART, WITH_REFLECTIVITY = 0xB0, 0xB6, 0xB7, 0xBF, 0xC4
PREFIX = {SCAN: 0, MEAN_SCAN: 1, PART: 4, MEAN_PART: 5, WITH_REFLECTIVITY: 0}
"""Bytes of data before the header word, by command: how many scans, first and last value."""

COUNT = 0x3FF
PARTIAL = 0x2000
INDEX_BYTES = 2
DEGREES = {
    101: (100, 100),
    181: (180, 100),
    201: (100, 50),
    361: (180, 50),
    401: (100, 25),
}
"""Field of view [degrees] and resolution [1/100 degree], by the number of values."""

MIRROR_TURN = 0.01332  # [s]
FIELDS_OF_VIEW, STEPS = (90, 100, 180), (25, 50, 100)  # [degrees], [1/100 degree]


@dataclass(frozen=True, kw_only=True, eq=False)
class Measurement:
    """What a value telegram carries.

    Parameters
    ----------
    words : (N,) array
        The values as sent; `ranges.to_ranges` reads them.
    unit : int
        0 centimetres, 1 millimetres.
    partial : int or None
        Of a partial scan in steps of 1 degree: how many quarters of a degree it is shifted.
    mean : int
        Of how many scans it is the mean.
    first : int or None
        Of a part of a scan: place of its first value in the scan, from 1.
    indices : tuple of int or None
        Counters modulo 256: of the mirror's turns, and of the telegrams.
    """

    words: Words
    unit: int
    partial: int | None = None
    mean: int = 1
    first: int | None = None
    indices: tuple[int, int] | None = None


def parse_measurement(telegram: Telegram) -> Measurement:
    """Return the measured values of a telegram B0, B6, B7, BF or C4 (without reflectivities).

    Raises
    ------
    ProtocolError
        If it is no such telegram, or its length does not fit the number of values.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 47-50, 61-93.
    """
    data, command = telegram.data, telegram.command
    if command not in PREFIX:
        raise ProtocolError(f"measured values: expected B0, B6, B7, BF or C4, got {command:02X}")
    at = PREFIX[command]
    if len(data) < at + 2:
        raise ProtocolError(f"measured values {command:02X}: {len(data)} bytes of data are too few")
    header = int.from_bytes(data[at : at + 2], "little")
    count, end = header & COUNT, at + 2 + 2 * (header & COUNT)
    if command == WITH_REFLECTIVITY:
        end_of_all = end + 6 + int.from_bytes(data[end : end + 2], "little")
    else:
        end_of_all = end
    extra = len(data) - end_of_all
    if extra not in {0, INDEX_BYTES}:
        raise ProtocolError(
            f"measured values {command:02X}: expected 0 or 2 bytes behind {count} values, "
            f"got {extra}"
        )
    return Measurement(
        words=np.frombuffer(data, dtype="<u2", count=count, offset=at + 2),
        unit=header >> 14,
        partial=header >> 11 & 3 if header & PARTIAL else None,
        mean=data[0] if command in {MEAN_SCAN, MEAN_PART} else 1,
        first=int.from_bytes(data[at - 4 : at - 2], "little") if at >= 4 else None,
        indices=(data[-2], data[-1]) if extra else None,
    )


def measurement_telegram(command: int, measurement: Measurement, status: int) -> Telegram:
    """Return the telegram B0, B6, B7 or BF that carries measured values."""
    count, m = measurement.words.size, measurement
    header = count | m.unit << 14 | (0 if m.partial is None else PARTIAL | m.partial << 11)
    prefix = bytes([m.mean]) if command in {MEAN_SCAN, MEAN_PART} else b""
    if command in {PART, MEAN_PART}:
        first = m.first or 1
        prefix += first.to_bytes(2, "little") + (first + count - 1).to_bytes(2, "little")
    values = m.words.astype("<u2").tobytes()
    data = prefix + header.to_bytes(2, "little") + values + bytes(m.indices or ())
    return Telegram(command, data, status)


def expected_size(command: int, begin: bytes) -> int | None:
    """Return the bytes of data without index bytes, by how they begin; None if that is too little.

    It tells a false start from a telegram before the whole of it is there.
    """
    at = PREFIX[command]
    if len(begin) < at + 2:
        return None
    return at + 2 + 2 * (int.from_bytes(begin[at : at + 2], "little") & COUNT)


def values_of(field: int, resolution: int) -> int:
    """Return the number of values of a scan, by field of view [degrees], step [1/100 degree]."""
    return field * 100 // resolution + 1


def check_variant(field: int, resolution: int) -> tuple[int, int]:
    """Return a field of view [degrees] and a step [1/100 degree] if a scanner can have them.

    Raises
    ------
    ProtocolError
        If none can.
    """
    if field not in FIELDS_OF_VIEW or resolution not in STEPS:
        raise ProtocolError(
            f"variant: expected 90, 100 or 180 degrees in steps of 0.25, 0.5 or 1, got {field} "
            f"in steps of {resolution / 100}"
        )
    return field, resolution


@lru_cache(maxsize=64)
def beam_angles(
    count: int,
    *,
    partial: int | None = None,
    first: int | None = None,
    variant: tuple[int, int] | None = None,
) -> FloatArray:
    """Return the directions of the beams of a telegram, (count,) [rad], counter-clockwise.

    Parameters
    ----------
    count : int
        Number of values.
    partial, first
        As in `Measurement`.
    variant : tuple of int, optional
        Field of view [degrees] and resolution [1/100 degree], if known.

    Raises
    ------
    ProtocolError
        If the number of values fits no field of view.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 48: from the right to the left.
    """
    if partial is not None:
        variant, shift = (100 if count <= 101 else 180, 100), partial / 4
    else:
        variant, shift = variant or DEGREES.get(count), 0.0
        if variant and first is None and count != values_of(*variant):
            variant = DEGREES.get(count)
    if variant is None or (first or 1) - 1 + count > values_of(*variant) or first == 0:
        raise ProtocolError(f"measured values: {count} from {first or 1} on fit no field of view")
    index = np.arange((first or 1) - 1, (first or 1) - 1 + count)
    degrees = shift - variant[0] / 2 + variant[1] / 100 * index
    return read_only(np.radians(degrees), "angles", (None,))


def turns(resolution: int | None, field: int | None = 180) -> int:
    """Return how many turns of the mirror a scan takes: 1 degree is shot in each.

    Parameters
    ----------
    resolution : int or None
        [1/100 degree]; None: a partial scan.
    field : int or None
        Field of view [degrees]: the fast type of 90 degrees takes half degrees in one turn.
    """
    if resolution is None or field == 90:
        return 1
    return math.ceil(100 / resolution)
