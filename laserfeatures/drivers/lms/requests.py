"""What a host asks an LMS2xx."""

from laserfeatures.drivers.lms.telegrams import FROM_SCANNER, pack_request

RESET = 0x10
MODE = 0x20
VALUES = 0x30
STATUS = 0x31
ERRORS = 0x32
MEAN = 0x36
SUB_RANGE = 0x37
TYPE = 0x3A
VARIANT = 0x3B
POWER_ON_BAUD = 0x66
READ_CONFIGURATION = 0x74
WRITE_CONFIGURATION = 0x77

POWERED_ON = 0x90  # sent unasked
RESETTING = 0x91
REFUSED = 0x92

INSTALLATION = 0x00
DIAGNOSIS = 0x10
STREAM = 0x24
ON_REQUEST = 0x25
STREAM_MEAN = 0x26
STREAM_SUB_RANGE = 0x27
STREAM_MEAN_SUB_RANGE = 0x28
STREAM_PARTIAL = 0x2A
STREAMS = {STREAM, STREAM_MEAN, STREAM_SUB_RANGE, STREAM_MEAN_SUB_RANGE, STREAM_PARTIAL}
"""The operating modes in which values come unasked."""

ONE_SCAN = 0x01
ONE_PARTIAL_SCAN = 0x08
PASSWORD = b"SICK_LMS"
BAUDS = {38400: 0x40, 19200: 0x41, 9600: 0x42, 500_000: 0x48}
"""The rates of the line [Bd], and what sets them."""


def reply_to(request: bytes) -> int:
    """Return the command of the reply to a request."""
    command = request[4]
    return RESETTING if command == RESET else command + FROM_SCANNER


def word(value: int) -> bytes:
    """Return a number as it is sent."""
    return value.to_bytes(2, "little")


def operating_mode(mode: int, data: bytes = b"") -> bytes:
    """Return the request for an operating mode; `ON_REQUEST` stops what streams."""
    return pack_request(MODE, bytes([mode]) + data)


def installation_mode() -> bytes:
    """Return the request for the mode in which the configuration can be written."""
    return operating_mode(INSTALLATION, PASSWORD)


def stream(*, mean: int = 1, first: int | None = None, last: int | None = None) -> bytes:
    """Return the request for a stream of scans.

    Parameters
    ----------
    mean : int
        Of how many scans each is the mean, 1..250.
    first, last : int, optional
        Which values of a scan are sent, counted from 1; None: all.
    """
    part = word(first) + word(last) if first is not None and last is not None else b""
    if mean > 1:
        mode = STREAM_MEAN_SUB_RANGE if part else STREAM_MEAN
        return operating_mode(mode, bytes([mean]) + part)
    return operating_mode(STREAM_SUB_RANGE if part else STREAM, part)


def session_baud(baud: int) -> bytes:
    """Return the request for a rate of the line [Bd], until the scanner is switched off."""
    return operating_mode(BAUDS[baud])


def one_scan(*, mean: int = 1, first: int | None = None, last: int | None = None) -> bytes:
    """Return the request for one scan, or the mean of some, or a part of one."""
    if first is not None and last is not None:
        return pack_request(SUB_RANGE, word(first) + word(last))
    if mean > 1:
        return pack_request(MEAN, bytes([mean]))
    return pack_request(VALUES, bytes([ONE_SCAN]))


def variant(angle: int, resolution: int) -> bytes:
    """Return the request for a field of view [degrees] and a resolution [1/100 degree]."""
    return pack_request(VARIANT, word(angle) + word(resolution))


def power_on_baud(*, keep: bool) -> bytes:
    """Return the request to keep the present rate at power-on, or to start at 9600 Bd."""
    return pack_request(POWER_ON_BAUD, bytes([keep]))
