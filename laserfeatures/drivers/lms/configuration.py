"""The configuration of an LMS2xx, which it keeps in an EEPROM."""

from dataclasses import dataclass

from laserfeatures.drivers.lms.ranges import REACH, default_mode
from laserfeatures.errors import ProtocolError

LENGTHS = (32, 34)  # bytes; 32 before firmware V2.10
AVAILABILITY, MEASURING_MODE, UNIT = 4, 5, 6
INDICES = 0x02  # in the byte AVAILABILITY
UNITS = {"cm": 0, "mm": 1}


@dataclass(frozen=True)
class Configuration:
    """The bytes of an F4, of which a driver touches three.

    Parameters
    ----------
    data : bytes
        32 or 34 bytes.

    Raises
    ------
    ProtocolError
        If it has another length.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 96-102.
    """

    data: bytes

    def __post_init__(self) -> None:
        """Check the length."""
        if len(self.data) not in LENGTHS:
            raise ProtocolError(
                f"configuration: expected 32 or 34 bytes of data, got {len(self.data)}"
            )

    @property
    def measuring_mode(self) -> int:
        """Meaning of a value's bits, see `ranges.LAYOUTS`."""
        return self.data[MEASURING_MODE]

    @property
    def unit(self) -> int:
        """Of the values: 0 centimetres, 1 millimetres."""
        return self.data[UNIT]

    @property
    def indices(self) -> bool:
        """Whether two counters follow the values."""
        return bool(self.data[AVAILABILITY] & INDICES)

    def changed(
        self,
        *,
        reach: int | None = None,
        unit: str | None = None,
        indices: bool | None = None,
    ) -> "Configuration":
        """Return a configuration with other settings; None leaves one as it is.

        Parameters
        ----------
        reach : int, optional
            How far values in millimetres go: 8, 16 or 32 m; ten times that in centimetres. A
            measuring mode of that reach stays, whatever fields it has.
        unit : str, optional
            ``"cm"`` or ``"mm"``.
        indices : bool, optional
            Whether two counters follow the values.
        """
        data = bytearray(self.data)
        if reach is not None and REACH.get(self.measuring_mode) != reach:
            data[MEASURING_MODE] = default_mode(reach)
        if unit is not None:
            data[UNIT] = UNITS[unit]
        if indices is not None:
            data[AVAILABILITY] = data[AVAILABILITY] & ~INDICES | INDICES * indices
        return Configuration(bytes(data))


def parse_written(data: bytes) -> tuple[bool, Configuration]:
    """Return whether an F7 says that a configuration was taken, and the one that holds now.

    Raises
    ------
    ProtocolError
        If the length is wrong.
    """
    if not data:
        raise ProtocolError("reply F7: expected a result and a configuration, got nothing")
    return data[0] == 1, Configuration(data[1:])
