"""Saying what it is that answers on a port."""

import re

SIGNATURES = (  # the most telling first
    (re.compile(rb"\xa5\x5a.{4}[\x04\x06\x15\x20\x81-\x86]", re.DOTALL), "an RPLIDAR"),
    (re.compile(rb"(\x54\x2c.{45}){2}", re.DOTALL), "an LD06 or LD19 (ld19:)"),
    (re.compile(rb"\xaa\x55.{8,90}\xaa\x55", re.DOTALL), "a YDLIDAR"),
    (re.compile(rb"\x02[\x80\x81].[\x00-\x03][\x90-\xff]", re.DOTALL), "a SICK LMS2xx (lms:)"),
    (re.compile(rb"(?m)^(VEND|PROD|MODL|DMIN):|^[MG][DS]\d{10,13}\n|^99b$|^0[0E][Pe]$"),
     "a Hokuyo that speaks SCIP (urg:)"),
    (re.compile(rb"\$G[PNL][A-Z]{3},"), "a GPS receiver (NMEA sentences)"),
)  # fmt: skip
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
