"""Finding capsules in a stream that may be damaged."""

from typing import NamedTuple

from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.capsules import capsule_fits


class Framed(NamedTuple):
    """A capsule, how many bytes came after it, and how many before it belong to none."""

    capsule: bytes
    behind: int
    stray: int


class CapsuleFraming:
    """Cuts the bytes of an express scan into capsules whose checksum is right.

    Parameters
    ----------
    size : int
        Bytes of a capsule.
    losses : Losses
        Where damage is counted: wrong capsules as damaged, other bytes as garbage.
    """

    def __init__(self, size: int, losses: Losses) -> None:
        self._size = size
        self._losses = losses
        self._buffer = b""
        self._stray = 0

    def feed(self, data: bytes) -> list[Framed]:
        """Take bytes; return the capsules that are whole."""
        buffer, at = self._buffer + data, 0
        found: list[Framed] = []
        while len(buffer) - at >= self._size:
            capsule = buffer[at : at + self._size]
            if capsule_fits(capsule):
                at += self._size
                found.append(Framed(capsule, len(buffer) - at, self._stray))
                self._stray = 0
                continue
            self._losses.damaged += not self._stray
            next_ = beginning(buffer, at + 1)
            self._stray += next_ - at
            self._losses.garbage += next_ - at
            at = next_
        self._buffer = buffer[at:]
        return found


def beginning(buffer: bytes, at: int) -> int:
    """Return the first place from `at` on that may be the beginning of a capsule."""
    while at < len(buffer):
        if buffer[at] >> 4 == 0xA and (at + 1 == len(buffer) or buffer[at + 1] >> 4 == 0x5):
            return at
        at += 1
    return at
