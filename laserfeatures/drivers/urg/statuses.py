"""What a status says.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B, pages 12 to 23.
"""

ACCEPTED = b"00"
DATA = b"99"
RESUMED = b"98"
UNDEFINED = b"0E"
BUSY = frozenset({b"0A", b"0B"})  # later it may work

_GENERAL = {
    "00": "done",
    "0A": "cannot process the command now",
    "0B": "its buffer is full, or the command came again too quickly",
    "0C": "the command has too few parameters",
    "0D": "the command is not defined",
    "0E": "the command is not defined",
    "0F": "the command has too few parameters",
    "0G": "the string behind the command is longer than 16 characters",
    "0H": "the string behind the command has a forbidden character",
    "0I": "waits for a firmware update",
    "0L": "is in an abnormal state",
    "0M": "is in an unstable state",
    "0": "done",
    "E": "speaks SCIP 1.1 and does not know the command",
}
_SCAN = {
    "01": "the first step is no number",
    "02": "the last step is no number",
    "03": "the cluster is no number",
    "04": "the last step is out of range",
    "05": "the last step is before the first",
    "06": "the skip is no number",
    "07": "the number of scans is no number",
    "10": "the laser is off",
    "98": "goes on after a check",
    "99": "scan data follow",
}
_STATES = {
    "BM": {"01": "the laser has a malfunction", "02": "the laser is on already"},
    "TM": {
        "01": "the code is none of 0, 1, 2",
        "02": "is in time stamp mode already",
        "03": "is not in time stamp mode",
        "04": "is not in time stamp mode",
    },
    "SS": {
        "01": "the rate is no number",
        "02": "there is no such rate",
        "03": "has this rate already",
        "04": "this model has no rates",
    },
    "CR": {
        "01": "the speed is no number",
        "02": "the speed is out of range",
        "03": "has this speed already",
        "04": "this model's speed is fixed",
    },
    "HS": {
        "01": "the code is neither 0 nor 1",
        "02": "is in this mode already",
        "03": "this model has no such mode",
    },
}


def meaning(command: bytes, status: bytes) -> str:
    """Say what a sensor means by a status.

    Parameters
    ----------
    command : bytes
        The command that it answers, or its first two letters.
    status : bytes
        The status without its sum.

    Examples
    --------
    >>> meaning(b"GD0044072501", b"10")
    'the laser is off'
    """
    letters, code = command[:2].decode("latin-1"), status.decode("latin-1")
    if letters in {"MD", "MS", "GD", "GS"}:
        known = _SCAN.get(code) or _GENERAL.get(code) or _fault(code)
    else:
        known = _STATES.get(letters, {}).get(code)
    return known or _GENERAL.get(code) or "says something that the protocol does not know"


def is_check(status: bytes) -> bool:
    """Return whether a stream pauses: the sensor checks a possible fault (21 to 49)."""
    return status.isdigit() and 21 <= int(status) <= 49


def is_fault(status: bytes) -> bool:
    """Return whether a stream has ended: for a fault of the hardware (50 to 97), or denied."""
    return status in {b"0L", b"10"} or (status.isdigit() and 50 <= int(status) <= 97)


def is_accepted_stream(status: bytes) -> bool:
    """Return whether a stream is on; a check in it shows that, too."""
    return status in {ACCEPTED, RESUMED} or is_check(status)


def _fault(code: str) -> str | None:
    status = code.encode("latin-1")
    if is_check(status):
        return "pauses to check a possible fault"
    return "a fault of the hardware: its laser, its motor" if is_fault(status) else None
