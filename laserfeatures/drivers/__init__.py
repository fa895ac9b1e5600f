"""Drivers of laser rangefinders on serial ports, one package a protocol.

A protocol's package has pure functions between bytes and messages, a decoder made of them, and a
thin driver. `make_driver` takes an address such as ``urg:///dev/ttyACM0``; `Driver` is what all
share.
"""

from laserfeatures.drivers.address import DRIVERS, is_address, make_driver, settings_of
from laserfeatures.drivers.decoder import Decoder, Event, Halt, Sweep
from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.losses import Losses

__all__ = [
    "DRIVERS",
    "Decoder",
    "Driver",
    "Event",
    "Halt",
    "Losses",
    "Sweep",
    "is_address",
    "make_driver",
    "settings_of",
]
