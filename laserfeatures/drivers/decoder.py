"""What a protocol's decoder takes and gives: the heart of a driver, without any I/O.

A decoder listens to both sides of a conversation. Its scans depend on nothing but the bytes and
their times, so that a recording played through it gives the very scans of the live run.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from laserfeatures.drivers.losses import Losses
from laserfeatures.scan import LaserScan


class Event:
    """What whoever iterates the scans must know; anything else that is decoded is a reply."""


@dataclass(frozen=True)
class Sweep(Event):
    """A scan, and when its first byte came [s since the epoch]."""

    scan: LaserScan
    arrival: float


@dataclass(frozen=True)
class Halt(Event):
    """The device has stopped sending scans of its own accord, and why."""

    reason: str


class Decoder(Protocol):
    """From the bytes on a line to scans and replies.

    Attributes
    ----------
    losses : Losses
        Where it counts what it throws away.
    """

    losses: Losses

    def sent(self, data: bytes, time: float) -> None:
        """Take note of bytes that the host sent at `time` [s since the epoch]."""

    def received(self, data: bytes, time: float) -> Sequence[object]:
        """Take bytes that came from the device, in pieces of any size.

        Returns
        -------
        sequence
            What has become whole with them: `Sweep`, `Halt`, or a reply of the protocol's own. An
            exception is a bug: damage is counted in `losses`.
        """

    def reset(self) -> None:
        """Forget what is half received and what is known of the device: the port is opened anew."""
