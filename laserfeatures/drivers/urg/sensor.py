"""What a sensor says of itself: VV, PP and II.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B, pages 20 to 22.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.drivers.urg.commands import Measurement
from laserfeatures.errors import ProtocolError

LARGEST_SHORT = 4095  # [mm] that two characters can tell; what is farther may read so, too
MOST_STEPS = 1 << 16


@dataclass(frozen=True)
class Geometry:
    """A sensor's geometry and limits, from PP.

    Parameters
    ----------
    model : str
        MODL.
    shortest, longest : int
        DMIN and DMAX [mm]; a value below DMIN is an error code.
    steps : int
        ARES: steps of a turn.
    first, last : int
        AMIN and AMAX: the steps that are measured.
    front : int
        AFRT: the step that points ahead.
    speed : int
        SCAN, or as set by CR [rpm].
    """

    model: str
    shortest: int
    longest: int
    steps: int
    first: int
    last: int
    front: int
    speed: int

    @property
    def period(self) -> float:
        """How long a turn takes [s]."""
        return 60.0 / self.speed

    @property
    def step_time(self) -> float:
        """How long a step takes [s]."""
        return self.period / self.steps

    def angle(self, step: FloatArray | IntArray) -> FloatArray:
        """Return the angles [rad] of steps, counter-clockwise from the front."""
        return (np.asarray(step, dtype=np.float64) - self.front) * (math.tau / self.steps)

    def angles(self, measurement: Measurement) -> FloatArray:
        """Return the angles (N,) [rad] of a scan's values: the middle of the steps of each."""
        low = measurement.first + measurement.width * np.arange(measurement.values)
        high = np.minimum(low + measurement.width - 1, measurement.last)
        return self.angle((low + high) / 2)

    def range_max(self, measurement: Measurement) -> float:
        """Return the limit of a scan's ranges [m]."""
        longest = self.longest
        if measurement.characters == 2:
            longest = min(longest, LARGEST_SHORT)
        return longest / 1000


def decode_fields(lines: Sequence[bytes]) -> dict[str, str]:
    """Return the values by key of lines ``KEY:VALUE``, given without their sums.

    Raises
    ------
    ProtocolError
        If a line has another form.
    """
    fields = {}
    for line in lines:
        key, colon, value = line.decode("latin-1").partition(":")
        if not colon or not key.isalnum():
            raise ProtocolError(f"SCIP line {line[:40]!r}: expected KEY:VALUE")
        fields[key] = value
    return fields


def decode_geometry(lines: Sequence[bytes]) -> Geometry:
    """Return the geometry that the lines of PP hold.

    Raises
    ------
    ProtocolError
        If a field is missing, no number, or impossible.
    """
    fields = decode_fields(lines)
    keys = ("DMIN", "DMAX", "ARES", "AMIN", "AMAX", "AFRT", "SCAN")
    geometry = Geometry(fields.get("MODL", ""), *(_number(fields, key) for key in keys))
    for text, holds in (
        ("DMIN < DMAX", geometry.shortest < min(geometry.longest, LARGEST_SHORT)),
        ("0 < ARES", 0 < geometry.steps <= MOST_STEPS),
        ("AMIN < AMAX < AMIN + ARES", 0 <= geometry.last - geometry.first < geometry.steps),
        ("AFRT <= ARES", geometry.front <= geometry.steps),
        ("SCAN > 0", geometry.speed > 0),
    ):
        if not holds:
            raise ProtocolError(f"SCIP PP: expected {text}, got {fields}")
    return geometry


def with_speed(geometry: Geometry, information: dict[str, str]) -> Geometry:
    """Return the geometry at the motor's speed that II tells (SCSP), if it does."""
    found = re.search(r"(\d{2,5})\[rpm\]", information.get("SCSP", ""))
    if found and int(found[1]) > 0:
        return replace(geometry, speed=int(found[1]))
    return geometry


def _number(fields: dict[str, str], key: str) -> int:
    value = fields.get(key, "")
    if not (value.isascii() and value.isdigit() and len(value) <= 7):
        raise ProtocolError(f"SCIP PP: expected a number for {key}, got {value[:20]!r}")
    return int(value)
