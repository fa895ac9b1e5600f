"""Fuzzing: ten million random and mutated bytes through each protocol's decoder.

``python benchmarks/driver_fuzz.py [--bytes N] [--protocol NAME] [--seed N]`` prints a row a
protocol. Half of the bytes are random; the others are sessions between driver and emulator in which
bytes were flipped, lost, doubled, overwritten and inserted, in pieces of any size. A decoder must
raise nothing, keep little, and find the frames of an undamaged session behind it all.
"""

import argparse
import itertools
import sys
import time
from random import Random

import numpy as np
from page import table

from laserfeatures.drivers import DRIVERS, Sweep, make_driver
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.devices import device_class

QUERIES = {"lms": ["", "mode=interlaced"], "rplidar": ["scan_mode=standard", "scan_mode=express"]}
SCANS = 12  # in a session
PIECE = 600  # bytes at most
LARGE = 2000  # bytes
KEPT = 1_000_000  # bytes that a decoder may hold on to
HEAD = ["protocol", "bytes", "seconds", "frames taken", "damaged", "kept", "sound behind it"]


class Waves:
    """Ranges that change from beam to beam and turn to turn."""

    turn = 0

    def __call__(self, angles):
        """Return the ranges of the next turn."""
        self.turn += 1
        return 2.0 + np.sin(7 * angles + self.turn) + (angles > 2)


def session(protocol, query):
    """Return what went over the line in a session, as a list of ("rx" or "tx", bytes, time)."""
    heard = []
    device = device_class(protocol)(Waves(), Faults())
    with (
        Emulator(device, speed=5, patient=True) as emulator,
        make_driver(
            f"{protocol}:{emulator.port}?{query}", tap=lambda *event: heard.append(event)
        ) as driver,
    ):
        list(itertools.islice(driver, SCANS))
    return joined(heard), driver


def joined(heard):
    """Join what came in small pieces, so that damage leaves some frames whole."""
    whole = []
    for kind, data, at in heard:
        if whole and whole[-1][0] == kind and len(whole[-1][1]) < LARGE:
            whole[-1] = (kind, whole[-1][1] + data, at)
        else:
            whole.append((kind, data, at))
    return whole


def mutated(data, random):
    """Return a piece of a session with some damage."""
    data = bytearray(data)
    for _ in range(random.choice([0, 1, 1, 2, 5, 30])):
        if not data:
            break
        i = random.randrange(len(data))
        kind = random.randrange(6)
        if kind == 0:
            data[i] ^= 1 << random.randrange(8)
        elif kind == 1:
            data[i] = random.randrange(256)
        elif kind == 2:
            del data[i : i + random.randint(1, 20)]
        elif kind == 3:
            data[i:i] = data[i : i + random.randint(1, 20)]
        elif kind == 4:
            data[i:i] = random.randbytes(random.randint(1, 20))
        else:
            data[i : i + 2] = bytes([random.choice([0, 1, 0x7F, 0x80, 0xFF])] * 2)
    return bytes(data)


def noisy(data, random):
    """Return data, damaged or not, and random bytes behind it or not."""
    data = mutated(data, random) if random.random() < 0.5 else data
    data += random.randbytes(len(data)) if random.random() < 0.5 else b""
    return data + (random.randbytes(PIECE) if random.random() < 0.1 else b"")


def pieces(data, random):
    """Yield data in pieces of any size."""
    start = 0
    while start < len(data):
        size = random.randint(1, PIECE)
        yield data[start : start + size]
        start += size


def held(thing, seen=None):
    """Return about how many bytes a decoder holds on to."""
    seen = seen if seen is not None else set()
    if id(thing) in seen or isinstance(thing, type):
        return 0
    seen.add(id(thing))
    size = sys.getsizeof(thing) + getattr(thing, "nbytes", 0)
    inner = vars(thing).values() if hasattr(thing, "__dict__") else ()
    if isinstance(thing, dict):
        inner = itertools.chain(thing.keys(), thing.values())
    elif not isinstance(thing, str | bytes | bytearray | np.ndarray) and hasattr(thing, "__iter__"):
        inner = thing
    return size + sum(held(each, seen) for each in inner)


def fuzz(protocol, wanted, seed):
    """Send bytes through a decoder; return the row."""
    random = Random(seed)  # noqa: S311 - no secret
    sessions = [session(protocol, query) for query in QUERIES.get(protocol, [""])]
    counts = np.zeros(3, dtype=int)
    kept, sound, began = 0, [], time.perf_counter()
    for heard, driver in sessions:
        driver.losses = type(driver.losses)()
        decoder, done = driver.decoder(), 0
        for kind, data, at in itertools.cycle(heard):
            noise = noisy(data, random)
            for piece in pieces(noise, random):
                (decoder.sent if kind == "tx" else decoder.received)(piece, at)
            done += len(noise)
            if random.random() < 0.001:
                kept = max(kept, held(decoder))
            if done > wanted / len(sessions):
                break
        counts += (done, driver.losses.frames, driver.losses.damaged)
        sound.append(sweeps(decoder, heard) >= SCANS - 2)
    seconds = time.perf_counter() - began
    assert kept < KEPT, f"{protocol}: the decoder holds {kept} bytes"
    assert all(sound), f"{protocol}: an undamaged session is not decoded behind the noise"
    row = [f"{counts[0]:,}", f"{seconds:.0f}", *counts[1:].tolist(), f"{kept / 1000:.0f} kB"]
    return [protocol, *row, "yes"]


def sweeps(decoder, heard):
    """Return how many scans an undamaged session makes."""
    found = 0
    for kind, data, at in heard:
        if kind == "rx":
            found += sum(isinstance(each, Sweep) for each in decoder.received(data, at))
        elif kind == "tx":
            decoder.sent(data, at)
    return found


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bytes", type=int, default=10_000_000)
    parser.add_argument("--protocol", action="append", choices=list(DRIVERS))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rows = [fuzz(name, options.bytes, options.seed) for name in options.protocol or DRIVERS]
    print(table(HEAD, rows))


if __name__ == "__main__":
    main()
