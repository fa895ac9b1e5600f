"""From the value words of an LMS2xx to ranges, and back."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray
from laserfeatures.errors import ProtocolError

Words = NDArray[np.uint16]

LAYOUTS = {0: 13, 1: 13, 2: 13, 3: 14, 4: 14, 5: 15, 6: 15, 0x0F: 16}
"""Bits of a value that hold the range, by measuring mode; those above are flags of fields.

The listing gives mode 05 14 bits, but calls it 32 m and gives it one flag: 15 are right. Mode 3F
holds reflectivities and no ranges.
"""

REACH = {0: 8, 1: 8, 2: 8, 3: 16, 4: 16, 5: 32, 6: 32, 0x0F: 32}
"""How far values in millimetres go [m], by measuring mode."""

SPECIAL = 9  # the highest values of a layout are no ranges: no return, dazzled, too far ...
STEPS = {0: 100, 1: 1000}  # in a metre, by unit


def default_mode(reach: int) -> int:
    """Return the measuring mode of the delivered scanner that reaches so far [m]."""
    return {8: 0, 16: 4, 32: 6}[reach]


def first_special(mode: int) -> int:
    """Return the lowest value that is no range.

    Raises
    ------
    ProtocolError
        If the measuring mode has no ranges.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 98, 124-125.
    """
    if mode not in LAYOUTS:
        raise ProtocolError(f"measuring mode: expected one with ranges, got 0x{mode:02X}")
    return (1 << min(LAYOUTS[mode], 15)) - SPECIAL


def range_limit(mode: int, unit: int) -> float:
    """Return the range that is out of reach [m]."""
    return first_special(mode) / _steps(unit)


def to_ranges(words: Words, mode: int, unit: int) -> FloatArray:
    """Return the ranges [m] of value words, (N,); nan where there is no return.

    Parameters
    ----------
    words : (N,) array
        As sent, with the flags of fields.
    mode : int
        Measuring mode.
    unit : int
        0 centimetres, 1 millimetres.

    Raises
    ------
    ProtocolError
        If the mode has no ranges or the unit is none.
    """
    special, steps = first_special(mode), _steps(unit)
    values = words & ((1 << LAYOUTS[mode]) - 1)
    ranges: FloatArray = values / steps
    ranges[values >= special] = math.nan
    return ranges


def to_words(ranges: FloatArray, mode: int, unit: int) -> Words:
    """Return the value words of ranges [m], (N,); nan and what is out of reach is no return."""
    special = first_special(mode)
    steps = np.rint(np.nan_to_num(ranges * _steps(unit), nan=math.inf))
    no_return = special + SPECIAL - 1
    return np.where(steps < special, np.maximum(steps, 0), no_return).astype(np.uint16)


def _steps(unit: int) -> int:
    if unit not in STEPS:
        raise ProtocolError(f"unit: expected 0 (cm) or 1 (mm), got {unit}")
    return STEPS[unit]
