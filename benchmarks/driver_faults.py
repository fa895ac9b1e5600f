"""Faults on the line: ten thousand frames with each fault, through emulator and driver.

``python benchmarks/driver_faults.py [--frames N] [--protocol NAME] [--fault NAME]`` prints a row a
protocol and fault. Every beam of turn k shows the range 1 m + k mm, so that each scan tells which
turn it is of, and a beam of another turn or of none is seen. The emulator lives faster than a real
device; terminal, driver and its thread are the real ones.

What a turn lacks beyond its damaged frames (and, in formats that need it, their neighbours) is
counted as undamaged frames lost. Faults of the device itself (stuck, restart, unplug) also take
what was on its way to the host: the turns around such an event, until scans come again, are left
out.
"""

import argparse
import time
from collections import Counter, defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from laserfeatures.drivers import DRIVERS, make_driver
from laserfeatures.emulators import FAULTS, Emulator, Faults
from laserfeatures.emulators.devices import device_class

FIRST, STEP, NUMBERS = 1.0, 0.001, 2500  # [m], [m]
RATE = {"stuck": 0.001, "restart": 0.001, "unplug": 0.001}  # of the others, 0.1
AROUND = {"stuck": 3, "restart": 3, "unplug": 6}  # turns that such an event may cost besides


@dataclass(frozen=True)
class Case:
    """How a protocol is played.

    `points` is how many measurements a frame holds (None: a whole turn), `neighbours` how many
    frames beside a damaged one cannot be decoded without it.
    """

    speed: float
    query: str = ""
    device: dict = field(default_factory=dict)
    points: int | None = None
    neighbours: int = 0


CASES = {
    "urg": Case(speed=40),
    "lms": Case(speed=10, query="baud=500000"),
    "rplidar": Case(speed=10, query="scan_mode=standard&coverage=0.05", points=1, neighbours=2),
    "rplidar express": Case(
        speed=10, query="scan_mode=express&coverage=0.05", points=32, neighbours=1
    ),
    "ld19": Case(speed=10, points=12),
}


class NumberedFeed:
    """Every beam of turn k has the range 1 m + k mm, beginning again after 2500 turns."""

    turn = -1

    def __call__(self, angles):
        """Return the ranges of the next turn."""
        self.turn += 1
        return np.full(angles.size, FIRST + STEP * (self.turn % NUMBERS))


@dataclass
class Outcome:
    """What came of one run."""

    frames: int = 0
    hit: int = 0
    scans: int = 0
    undamaged: int = 0
    undamaged_lost: int = 0
    beams: int = 0
    false_beams: int = 0
    growth: float = 0.0
    seconds: float = 0.0
    losses: str = ""

    def row(self):
        """Return its cells."""
        return [
            self.frames,
            self.hit,
            self.scans,
            f"{self.undamaged_lost} of {self.undamaged}",
            f"{self.false_beams} of {self.beams}",
            f"{self.growth:+.1f} MB",
            f"{self.seconds:.0f} s",
            self.losses,
        ]


HEAD = ["protocol", "fault", "frames", "hit", "scans", "undamaged lost",
        "false beams", "memory", "time", "losses counted"]  # fmt: skip


def resident():
    """Return the resident memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def run(name, fault, frames, seed=0):
    """Play `frames` frames of a protocol with a fault."""
    case, outcome = CASES[name], Outcome()
    rate = {fault: RATE.get(fault, 0.1)} if fault else {}
    faults = Faults(rate, seed=seed, stuck_time=1.5 * case.speed, unplugged_time=0.5)
    protocol = name.split()[0]
    device = device_class(protocol)(NumberedFeed(), faults, **case.device)
    device.frames = type(device.frames)(maxlen=None)
    delivered = Counter()  # turn -> beams
    began, last, before = time.monotonic(), 0, None
    with Emulator(device, speed=case.speed, patient=True) as emulator:
        query = f"{case.query}&reconnect=1&buffer=1000"
        with make_driver(f"{protocol}://{emulator.port}?{query}") as driver:
            for scan in driver:
                last = count(scan, device.feed.turn, delivered, outcome, last)
                outcome.scans += 1
                if before is None and len(device.frames) > frames / 5:
                    before = resident()
                if len(device.frames) >= frames:
                    break
            outcome.losses = str(driver.losses)
    outcome.seconds = time.monotonic() - began
    outcome.growth = resident() - (before or resident())
    judge(case, device.frames, delivered, outcome)
    return outcome


def count(scan, newest, delivered, outcome, last):
    """Count the beams of a scan by turn; return the latest turn seen."""
    outcome.beams += int(scan.valid.sum())
    numbers = np.rint((scan.ranges[scan.valid] - FIRST) / STEP).astype(int)
    exact = np.abs(scan.ranges[scan.valid] - FIRST - STEP * numbers) < STEP / 4
    for number, beams in Counter(numbers[exact].tolist()).items():
        turn = newest - (newest - number) % NUMBERS
        if 0 <= number < NUMBERS and newest - turn < NUMBERS // 2 and turn >= last - 1:
            delivered[turn] += beams
            last = max(last, turn)
        else:
            outcome.false_beams += beams
    outcome.false_beams += int((~exact).sum())
    return last


def around_events(hits, delivered):
    """Return the turns around what befell the device itself, until scans came again after it."""
    near = set()
    for turn, faults in hits.items():
        for fault in set(faults) & set(AROUND):
            again = next((each for each in delivered if each > turn), turn)
            near |= set(range(turn - AROUND[fault], max(again, turn + AROUND[fault]) + 1))
    return near


def judge(case, frames, delivered, outcome):
    """Compare what was delivered with the device's own account."""
    hits = defaultdict(list)
    for turn, fault in frames:
        hits[turn].append(fault)
    near = around_events(hits, sorted(delivered))
    outcome.frames = len(frames)
    outcome.hit = sum(fault is not None for _, fault in frames)
    if not delivered:
        return
    full = Counter(delivered.values()).most_common(1)[0][0]
    points = case.points or full
    cost = points * (1 + 2 * case.neighbours)
    hit = {turn: sum(fault is not None for fault in faults) for turn, faults in hits.items()}
    for turn in range(min(delivered) + 1, max(delivered)):
        if turn in near or turn not in hit:
            continue
        allowed = cost * hit[turn]
        if case.points:  # a frame may reach into the next turn
            allowed += cost * sum(hit.get(turn + i, 0) > 0 for i in (-1, 1)) + 1
        lost = full - delivered[turn] - allowed
        outcome.undamaged += len(hits[turn]) - hit[turn]
        outcome.undamaged_lost += max(lost // points, 0)


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--protocol", action="append", choices=list(CASES))
    parser.add_argument("--fault", action="append", choices=["none", *FAULTS])
    options = parser.parse_args()
    print("| " + " | ".join(HEAD) + " |")
    print("|" + " --- |" * len(HEAD))
    for name in options.protocol or CASES:
        for fault in options.fault or ["none", *FAULTS]:
            outcome = run(name, None if fault == "none" else fault, options.frames)
            print("| " + " | ".join(map(str, [name, fault, *outcome.row()])) + " |", flush=True)


if __name__ == "__main__":
    assert {name.split()[0] for name in CASES} == set(DRIVERS)
    main()
