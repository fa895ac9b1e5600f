"""What a device does not tell about itself, by its model byte.

The high nibble is the series (1 to 3: A1 to A3; 4 and 5: C; 6 to 8: S; then T and M), the low one
the number behind the M of its name.
"""

from typing import NamedTuple

USUAL_BAUD = 115_200


class Model(NamedTuple):
    """Smallest and largest range [m], and rate of the line [Bd]."""

    limits: tuple[float, float]
    baud: int


A2_OF_115200 = {0x24, 0x25, 0x26, 0x28}
A2 = Model((0.15, 16.0), 256_000)
SERIES = {
    1: Model((0.15, 12.0), USUAL_BAUD),
    2: A2,
    3: Model((0.2, 25.0), 256_000),
    4: Model((0.05, 12.0), 460_800),
    5: Model((0.05, 12.0), 460_800),
    6: Model((0.1, 40.0), 256_000),
    7: Model((0.05, 40.0), 1_000_000),
}
OTHER = Model((0.05, 40.0), 1_000_000)
UNKNOWN = Model((0.05, 40.0), USUAL_BAUD)
"""Before a device has told its model."""


def model_of(code: int) -> Model:
    """Return what is known of the model with this byte, from the data sheets."""
    if code in A2_OF_115200:
        return A2._replace(baud=USUAL_BAUD)
    return SERIES.get(code >> 4, OTHER)
