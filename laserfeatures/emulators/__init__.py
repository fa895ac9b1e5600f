"""Emulated rangefinders: byte for byte what the real ones send, on a pseudo-terminal or TCP port.

A device (`urg`, `lms`, `rplidar`, `ld19`) is a state machine without I/O; an `Emulator` plays it.
"""

from laserfeatures.emulators.device import Device
from laserfeatures.emulators.faults import FAULTS, Faults
from laserfeatures.emulators.feed import Feed, ScansFeed, WorldFeed
from laserfeatures.emulators.link import Emulator

__all__ = ["FAULTS", "Device", "Emulator", "Faults", "Feed", "ScansFeed", "WorldFeed"]
