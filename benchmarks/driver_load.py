"""Ten rangefinders at once in one process, every scan through `direct_hough`.

``python benchmarks/driver_load.py [--seconds 60] [--devices lms urg ...]`` prints a row a device:
scans taken, lost between device and user, latency from a scan's first byte to its features, and
below the share of one core that the process took. The emulators live in a process of their own and
see a room.

Latency holds the time that a scan is on the line: an LMS telegram takes 14.6 ms at 500 kBd, a turn
of an LD19 100 ms.
"""

import argparse
import multiprocessing
import resource
import tempfile
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from page import table

import laserfeatures as lf
from laserfeatures.drivers import Losses, make_driver
from laserfeatures.drivers.host_clock import now
from laserfeatures.emulators import Emulator, WorldFeed
from laserfeatures.emulators.devices import device_class
from laserfeatures.simulation import random_room

TEN = ["lms"] * 3 + ["urg"] * 3 + ["rplidar"] * 2 + ["ld19"] * 2
QUERIES = {"lms": "?baud=500000&resolution=0.5"}
HEAD = ["device", "scans", "scans/s", "lost", "corners", "median", "p99", "longest"]


@dataclass
class Taken:
    """What one device's thread took."""

    name: str
    address: str
    latencies: list = field(default_factory=list)  # [s]
    corners: int = 0
    seconds: float = 0.0
    losses: Losses = field(default_factory=Losses)
    error: BaseException | None = None


def play(names, folder, ends):
    """Play the devices until told to end; send back what their terminals could not hold."""
    world, pose = random_room(5)
    emulators = [
        Emulator(device_class(name)(WorldFeed(world, pose, seed=i)), link=Path(folder, str(i)))
        for i, name in enumerate(names)
    ]
    for emulator in emulators:
        emulator.__enter__()
    ends.send("ready")
    ends.recv()
    ends.send(sum(emulator.dropped for emulator in emulators))
    for emulator in emulators:
        emulator.__exit__(None, None, None)


def take(taken, seconds):
    """Take the scans of one device for a while."""
    extractor = lf.get_extractor("direct_hough")
    driver = make_driver(taken.address)
    try:
        with driver:
            next(driver)
            began = time.monotonic()
            for scan in driver:
                taken.corners += len(extractor(scan).corners)
                taken.latencies.append(now() - driver.arrival)
                taken.seconds = time.monotonic() - began
                if taken.seconds >= seconds:
                    break
    except lf.DriverError as error:
        taken.error = error
    taken.losses = driver.losses


def warm_up():
    """Compile, or load from the cache, what the threads will call."""
    world, pose = random_room(5)
    angles = np.linspace(-1.5, 1.5, 200)
    ranges = WorldFeed(world, pose)(angles)
    lf.get_extractor("direct_hough")(lf.LaserScan(angles=angles, ranges=ranges))


def measure(names, seconds):
    """Return what each device's thread took, the share of a core, and the bytes dropped."""
    warm_up()
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    with tempfile.TemporaryDirectory() as folder:
        player = spawn.Process(target=play, args=(names, folder, theirs))
        player.start()
        ours.recv()
        everything = [
            Taken(name, f"{name}:{folder}/{i}{QUERIES.get(name, '')}")
            for i, name in enumerate(names)
        ]
        threads = [threading.Thread(target=take, args=(each, seconds)) for each in everything]
        before, began = resource.getrusage(resource.RUSAGE_SELF), time.monotonic()
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        after, wall = resource.getrusage(resource.RUSAGE_SELF), time.monotonic() - began
        ours.send("end")
        dropped = ours.recv()
        player.join()
    used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return everything, used / wall, dropped


def lost(losses):
    """Return how many scans or frames did not reach the user, by the driver's own count."""
    return losses.scans + losses.damaged


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--devices", nargs="+", default=TEN, metavar="NAME")
    options = parser.parse_args()
    everything, share, dropped = measure(options.devices, options.seconds)
    rows = []
    for each in everything:
        if each.error:
            raise each.error
        late = np.array(each.latencies) * 1000
        quantiles = [f"{q:.1f} ms" for q in np.quantile(late, [0.5, 0.99, 1.0])]
        rate = f"{len(late) / each.seconds:.2f}"
        rows.append([each.name, len(late), rate, lost(each.losses), each.corners, *quantiles])
    print(table(HEAD, rows))
    print(f"\n{share:.0%} of one core for {len(rows)} devices; bytes dropped: {dropped}")
    gone = sum(lost(each.losses) for each in everything)
    if gone or dropped:
        raise SystemExit(f"{gone} scans were lost")


if __name__ == "__main__":
    main()
