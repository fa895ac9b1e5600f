"""Emulated rangefinders that the tests of sources and commands read."""

import time

import numpy as np

from laserfeatures.drivers import make_driver
from laserfeatures.drivers.recorder import Recorder
from laserfeatures.emulators import Emulator, Faults, WorldFeed
from laserfeatures.emulators.ld19 import Ld19Device
from laserfeatures.growing_file import GrowingFile
from laserfeatures.simulation import hallway


def sends_on(played):
    """Return whether a device still sends scans, or has its laser on."""
    before = len(played.device.frames)
    time.sleep(0.3)
    laser = getattr(getattr(played.device, "state", None), "laser", False)
    return len(played.device.frames) > before or laser


def ld19(rates=None, *, unplugged_time=0.3, **link):
    """Return an LD19 in the hallway, not plugged in."""
    world, path = hallway()
    faults = Faults(rates, unplugged_time=unplugged_time)
    return Emulator(Ld19Device(WorldFeed(world, path[0]), faults), **link)


def address(emulator, query=""):
    """Return the address of an LD19's port."""
    return f"ld19:{emulator.port}{query and '?' + query}"


def record(path, port, scans, *, after=None, **parameters):
    """Record some scans; return them with their arrivals. `after(i)` is called after each."""
    driver = make_driver(port, **parameters)
    taken = []
    with GrowingFile(path) as file, Recorder(file, driver) as recorder, driver:
        for scan in driver:
            recorder.add(scan)
            taken.append((scan, driver.arrival))
            if after:
                after(len(taken))
            if len(taken) == scans:
                break
    return taken, driver.losses


def same(a, b):
    """Return whether two scans are equal to the last bit."""
    return (
        np.array_equal(a.angles, b.angles)
        and np.array_equal(a.ranges, b.ranges, equal_nan=True)
        and (a.stamp, a.range_min, a.range_max) == (b.stamp, b.range_min, b.range_max)
    )
