"""Saying what it is that answers on a port."""

import re
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from laserfeatures.drivers.reader import Reader

SIGNATURES = (  # the most telling first
    (re.compile(rb"\xa5\x5a.{4}[\x04\x06\x15\x20\x81-\x86]", re.DOTALL), "an RPLIDAR (rplidar:)"),
    (re.compile(rb"(\x54\x2c.{45}){2}", re.DOTALL), "an LD06 or LD19 (ld19:)"),
    (re.compile(rb"\xaa\x55.{8,90}\xaa\x55", re.DOTALL), "a YDLIDAR"),
    (re.compile(rb"\x02[\x80\x81].[\x00-\x03][\x90-\xff]", re.DOTALL), "a SICK LMS2xx (lms:)"),
    (re.compile(rb"(?m)^(VEND|PROD|MODL|DMIN):|^[MG][DS]\d{10,13}\n|^99b$|^0[0E][Pe]$"),
     "a Hokuyo that speaks SCIP (urg:)"),
    (re.compile(rb"\x02(\x02{3}.{4})?s(RA|AN|EA|SN|FA|RI|WA|MA)\b", re.DOTALL),
     "a SICK that speaks SOPAS (TiM, LMS1xx)"),
    (re.compile(rb"\$G[PNL][A-Z]{3},"), "a GPS receiver (NMEA sentences)"),
)  # fmt: skip
QUESTIONS = (  # that change nothing: rate of the line [Bd] and request
    (115_200, b"VV\n"),
    (115_200, b"\xa5\x50"),
    (9_600, b"\x02\x00\x01\x00\x31\x15\x12"),
    (38_400, b"\x02\x00\x01\x00\x31\x15\x12"),
    (115_200, b"\x02sRN DeviceIdent\x03"),
    (230_400, b""),  # an LD19 talks unasked
)
ANSWER_TIME = 0.3  # [s]
SHOWN = 24  # bytes
PRINTABLE = 0.9  # share of bytes that makes a text


def identify(heard: bytes) -> str:
    """Say what sent the bytes `heard`, as far as they tell.

    Examples
    --------
    >>> identify(b"$GPGGA,123519,4807.038,N")
    "a GPS receiver (NMEA sentences): b'$GPGGA,123519,4807.038,N'"
    """
    for signature, name in SIGNATURES:
        found = signature.search(heard)
        if found:
            shown = heard[found.start() : found.start() + SHOWN]
            return f"{name}: {shown!r}"
    shown = heard[-SHOWN:]
    text = sum(32 <= byte < 127 or byte in b"\r\n\t" for byte in heard)
    if text > PRINTABLE * len(heard):
        return f"another device, which sends the text {shown!r}"
    return (
        f"bytes of no protocol known here ({shown.hex(' ')}): a wrong baud rate, or another device"
    )


def is_known(heard: bytes) -> bool:
    """Return whether `identify` can tell what sent the bytes `heard`."""
    return any(signature.search(heard) for signature, _ in SIGNATURES)


def ask_around(reader: "Reader") -> str | None:
    """Ask a device that does not answer in one protocol who it is in the others.

    What answers, but in none that is known here, is told as far as its bytes tell; None: silence.

    Raises
    ------
    DriverError
        If the port is gone, or cannot have a usual rate.
    """
    strange = b""
    for baud, question in QUESTIONS:
        reader.port.baud = baud
        reader.heard.clear()
        reader.write(question)
        time.sleep(ANSWER_TIME)
        heard = bytes(reader.heard)
        if is_known(heard):
            return identify(heard)
        strange = strange or heard
    return identify(strange) if strange else None
