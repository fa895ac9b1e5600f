"""The emulated devices by name."""

from importlib import import_module

from laserfeatures.emulators.device import Device
from laserfeatures.registry import near_names

DEVICES = {
    "urg": ("laserfeatures.emulators.urg", "UrgDevice"),
    "lms": ("laserfeatures.emulators.lms", "LmsDevice"),
    "rplidar": ("laserfeatures.emulators.rplidar", "RPLidarDevice"),
    "ld19": ("laserfeatures.emulators.ld19", "Ld19Device"),
}
"""Module and class of each, by the protocol of the driver that reads it."""


def device_class(protocol: str) -> type[Device]:
    """Return the emulated device of a protocol.

    Raises
    ------
    ValueError
        If there is none.
    """
    if protocol not in DEVICES:
        raise ValueError(f"there is no device {protocol!r}; {near_names(protocol, DEVICES)}")
    module, name = DEVICES[protocol]
    found: type[Device] = getattr(import_module(module), name)
    return found
