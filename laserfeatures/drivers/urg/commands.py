"""The commands that measure: MD and MS stream scans, GD and GS fetch one.

References
----------
Hokuyo, Communication Protocol Specification for SCIP2.0 Standard, C-42-03320B, pages 10 to 13.
"""

import re
from dataclasses import dataclass, replace
from typing import Literal, get_args

from laserfeatures.errors import ProtocolError

Kind = Literal["MD", "MS", "GD", "GS"]
KINDS: tuple[Kind, ...] = get_args(Kind)

_SHAPE = re.compile(rb"(?:(M[DS])(\d{4})(\d{4})(\d\d)(\d)(\d\d)|(G[DS])(\d{4})(\d{4})(\d\d))(;.*)?")


@dataclass(frozen=True)
class Measurement:
    """A command that measures.

    Parameters
    ----------
    kind : {"MD", "MS", "GD", "GS"}
        M streams, G fetches one scan; a distance has three characters with D, two with S.
    first, last : int
        First and last step, both included.
    cluster : int
        How many steps become one value; 0 is 1.
    skip : int
        How many turns are left out after each.
    count : int
        How many scans are wanted, or in a sensor's echo: are still to come; 0 is no end.
    """

    kind: Kind
    first: int
    last: int
    cluster: int = 1
    skip: int = 0
    count: int = 0

    @property
    def streams(self) -> bool:
        """Whether scans come until they are stopped."""
        return self.kind[0] == "M"

    @property
    def characters(self) -> int:
        """Characters of a distance."""
        return 3 if self.kind[1] == "D" else 2

    @property
    def width(self) -> int:
        """Steps in a value."""
        return max(self.cluster, 1)

    @property
    def values(self) -> int:
        """Number of values in a scan."""
        return -(-(self.last - self.first + 1) // self.width)

    def encode(self) -> bytes:
        """Return the command without its line feed."""
        text = f"{self.kind}{self.first:04d}{self.last:04d}{self.cluster:02d}"
        if self.streams:
            text += f"{self.skip:d}{self.count:02d}"
        return text.encode()

    def answers(self, command: "Measurement") -> bool:
        """Return whether a sensor that was sent `command` may echo this."""
        fewer = self.count <= command.count
        return fewer and replace(self, count=command.count) == command


def decode_measurement(echo: bytes) -> Measurement:
    """Return the command that an echo (with or without a string) holds.

    Raises
    ------
    ProtocolError
        If it is none that measures, or its steps are in the wrong order.

    Examples
    --------
    >>> decode_measurement(b"MD0044072501000").values
    682
    """
    found = _SHAPE.fullmatch(echo)
    if not found:
        raise ProtocolError(f"SCIP echo {echo[:40]!r}: expected MD, MS, GD or GS and its digits")
    parts = [part for part in found.groups()[:10] if part is not None]
    kind = next(kind for kind in KINDS if kind.encode() == parts[0])
    measurement = Measurement(kind, *(int(part) for part in parts[1:]))
    if measurement.last < measurement.first:
        raise ProtocolError(f"SCIP echo {echo!r}: expected the last step after the first")
    return measurement
