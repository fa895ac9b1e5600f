"""The status of an LMS2xx: the reply B1, the status byte, the list of errors."""

from dataclasses import dataclass
from struct import Struct

from laserfeatures.errors import ProtocolError

FIELDS = {
    "mode": (7, Struct("<B")),
    "defective": (8, Struct("<B")),
    "motor_period": (66, Struct("<H")),
    "measuring_mode": (101, Struct("<B")),
    "angle": (106, Struct("<H")),
    "resolution": (108, Struct("<H")),
    "baud_code": (115, Struct("<H")),
    "keeps_baud": (118, Struct("<B")),
    "address": (119, Struct("<B")),
    "unit": (121, Struct("<B")),
}
"""Where the numbers stand in the data of a B1, behind the command."""

LEAST = 130  # bytes: up to the boot PROM's version
TURN_STEPS = 90  # the motor's period is given for 1/90 of a turn

BAUD_CODES = {9600: 0x8067, 19200: 0x8033, 38400: 0x8019, 500_000: 0x8001}
SEVERITIES = ("ok", "info", "warning", "error", "fatal error")
WARNING = 2
IMPLAUSIBLE = 0x40
POLLUTION = 0x80
OLD = 0x80

ERRORS = {
    5: "dazzled",
    29: "motor speed",
    39: "time measurement",
    45: "a value is missing",
    46: "a scan is missing",
    49: "laser power",
    50: "time measurement",
    53: "memory written",
    56: "watchdog",
    57: "no zero index",
} | dict.fromkeys(range(17, 23), "window polluted")


@dataclass(frozen=True)
class Status:
    """What a scanner says of itself.

    Parameters
    ----------
    firmware, boot_version, serial : str
        Versions and serial number.
    mode : int
        Operating mode, such as 0x24 for a stream.
    defective : int
        Above 0: it has, or has had, a fatal fault.
    motor_period : int
        Time of 1/90 of a turn of the mirror [µs].
    measuring_mode : int
        Meaning of a value's bits, see `ranges.LAYOUTS`.
    angle : int
        Field of view [degrees].
    resolution : int
        Step from value to value [1/100 degree].
    baud_code : int
        Rate of the line, as in `BAUD_CODES`.
    keeps_baud : int
        1: the rate stays through power-off; 0: 9600 Bd at power-on.
    address : int
        Its address on the line.
    unit : int
        Of its values: 0 centimetres, 1 millimetres.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 53-57; real replies of an LMS200-S18063.
    """

    firmware: str
    boot_version: str
    serial: str
    mode: int
    defective: int
    motor_period: int
    measuring_mode: int
    angle: int
    resolution: int
    baud_code: int
    keeps_baud: int
    address: int
    unit: int

    @property
    def turn_time(self) -> float:
        """Time of a turn of the mirror [s]."""
        return self.motor_period * TURN_STEPS * 1e-6

    @property
    def baud(self) -> int | None:
        """Rate of the line [Bd], None if its code is not known."""
        codes = {code: baud for baud, code in BAUD_CODES.items()}
        return codes.get(self.baud_code)


def parse_status(data: bytes) -> Status:
    """Return what the data of a B1 say.

    Raises
    ------
    ProtocolError
        If they are too short.
    """
    if len(data) < LEAST:
        raise ProtocolError(f"status B1: expected at least {LEAST} bytes of data, got {len(data)}")
    numbers = {name: int(kind.unpack_from(data, at)[0]) for name, (at, kind) in FIELDS.items()}
    return Status(
        firmware=_text(data[0:7]), serial=_text(data[9:17]), boot_version=_text(data[123:130]),
        **numbers,
    )  # fmt: skip


def write_status(template: bytes, **numbers: int) -> bytes:
    """Return the data of a B1 with other numbers, by the names of `FIELDS`."""
    data = bytearray(template)
    for name, value in numbers.items():
        at, kind = FIELDS[name]
        kind.pack_into(data, at, value)
    return bytes(data)


def describe(status: int) -> str | None:
    """Return what is wrong by a status byte, None if nothing is.

    Examples
    --------
    >>> describe(0x11)
    >>> describe(0x53)
    'error, implausible values'
    """
    severity = status & 7
    faults = []
    if severity >= WARNING:
        faults.append(SEVERITIES[min(severity, len(SEVERITIES) - 1)])
    if status & IMPLAUSIBLE:
        faults.append("implausible values")
    return ", ".join(faults) or None


def parse_errors(data: bytes) -> list[str]:
    """Return the errors of a B2 in words; those that are over are called old.

    Raises
    ------
    ProtocolError
        If the data are no pairs.

    Examples
    --------
    >>> parse_errors(bytes.fromhex("84 16 01 31"))
    ['old fatal error 22 (window polluted)', 'info 49 (laser power)']
    """
    if len(data) % 2:
        raise ProtocolError(f"error list B2: expected pairs, got {len(data)} bytes")
    return [_error(*data[i : i + 2]) for i in range(0, len(data), 2)]


def _error(kind: int, number: int) -> str:
    severity = SEVERITIES[min(kind & ~OLD, len(SEVERITIES) - 1)]
    name = f" ({ERRORS[number]})" if number in ERRORS else ""
    return f"{'old ' if kind & OLD else ''}{severity} {number}{name}"


def _text(data: bytes) -> str:
    return data.decode("ascii", "replace").strip("\0 ")
