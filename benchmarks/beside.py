"""Whole calls of extractors at this checkout beside another one, in one run.

``python benchmarks/beside.py /tmp/before [--extractors direct_hough,ransac] [--beams 361,1081]
[--rooms 12] [--repeats 20] [--told 0.005]`` starts one process for each checkout (the same
interpreter, which imports the package from that checkout) and lets them take turns, block by block,
on the same scans of random rooms. It prints medians over all calls [us], the ratio of this checkout
to the other with its 10 to 90 % range over the blocks, and to which power of the beams each grows
from 1000 to 10000. The features of both are compared too: a difference is counted, not an error.
The other checkout can be made by ``git worktree add /tmp/before COMMIT``.
"""

import argparse
import importlib
import json
import math
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BEAMS = (181, 361, 682, 1081, 2000, 5000, 10000)
GROWTH = (1000, 10000)  # beams between which the growth is measured
SEEDS = 80_000  # of the first room
ROOMS = 12
REPEATS = 20  # blocks of each checkout, at most
SECONDS = 0.15  # that a block takes about


def scanner_of(beams):
    """Return the scanner of that many beams: 180 degrees up to 361 beams, 240, then 270."""
    from laserfeatures.simulation import Scanner  # noqa: PLC0415 - of the checkout under test

    degrees = 180 if beams <= 361 else 240 if beams <= 682 else 270
    return Scanner(beams=beams, field_of_view=math.radians(degrees))


def scenes(beams, rooms):
    """Return the angles and ranges of the scans, and the sensor's range, as JSON has them."""
    import numpy as np  # noqa: PLC0415

    from laserfeatures.simulation import random_room  # noqa: PLC0415

    scanner = scanner_of(beams)
    ranges = []
    for seed in range(SEEDS, SEEDS + rooms):
        world, pose = random_room(seed)
        ranges.append(scanner.scan(world, pose, np.random.default_rng(seed)).ranges.tolist())
    return {"angles": scanner.angles.tolist(), "ranges": ranges, "range_max": scanner.range_max}


class Worker:
    """A process that runs the extractors of one checkout."""

    def __init__(self, root, cache):
        self.root = Path(root).resolve()
        paths = os.pathsep.join([str(self.root), str(self.root / "plugins")])
        environment = {**os.environ, "PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(cache)}
        self.process = subprocess.Popen(  # noqa: S603 - this very file
            [sys.executable, "-P", __file__, "--worker", str(self.root)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment,
            cwd=self.root,
        )  # fmt: skip

    def ask(self, **question):
        """Send a question and return the answer."""
        self.process.stdin.write(json.dumps(question) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"the process of {self.root} ended")
        return json.loads(answer)

    def close(self):
        """End the process."""
        self.process.stdin.close()
        self.process.wait()


def serve(root):
    """Answer questions on standard input: load scans, check features, time blocks."""
    import laserfeatures_plugins  # noqa: PLC0415

    import laserfeatures as lf  # noqa: PLC0415

    for module in (lf, laserfeatures_plugins):
        assert Path(module.__file__).is_relative_to(root), (module.__file__, root)
    register(root)
    data, extractor = {}, None
    for line in sys.stdin:
        question = json.loads(line)
        match question.pop("what"):
            case "scenes":
                answer = scenes(**question)
            case "load":
                data = loaded(**question)
                answer = len(data["ranges"])
            case "extractor":
                extractor = lf.get_extractor(question["name"], **question["parameters"])
                answer = shown(extractor, data)
            case "block":
                answer = block(extractor, data, question["calls"])
        print(json.dumps(answer), flush=True)


def register(root):
    """Offer the extractors that the checkout itself names: the installed ones are another's."""
    import laserfeatures as lf  # noqa: PLC0415

    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    for name, place in project["entry-points"]["laserfeatures.extractors"].items():
        module, _, attribute = place.partition(":")
        factory = getattr(importlib.import_module(module), attribute)
        lf.register_extractor(name, factory, replace=True)


def loaded(angles, ranges, range_max):
    """Return scans' arrays, read-only, so that no scan copies them; scans share their angles."""
    import numpy as np  # noqa: PLC0415

    angles, *ranges = (np.array(values) for values in (angles, *ranges))
    for each in (angles, *ranges):
        each.flags.writeable = False
    return {"angles": angles, "ranges": ranges, "range_max": range_max}


def fresh(data, number):
    """Return a scan of which nothing has been computed yet."""
    import laserfeatures as lf  # noqa: PLC0415

    ranges = data["ranges"][number % len(data["ranges"])]
    return lf.LaserScan(angles=data["angles"], ranges=ranges, range_max=data["range_max"])


def shown(extractor, data):
    """Return what is found in each scan: its corners, rounded, and its lines."""
    found = [extractor(fresh(data, k)) for k in range(len(data["ranges"]))]
    return [[sorted(each.corners.positions.round(6).tolist()), len(each.lines)] for each in found]


def block(extractor, data, calls):
    """Return the seconds of each call in a block; scans take turns, each is made just before."""
    seconds = []
    for number in range(calls):
        scan = fresh(data, number)
        start = time.perf_counter()
        extractor(scan)
        seconds.append(time.perf_counter() - start)
    return seconds


def compare(workers, name, parameters, repeats):
    """Return the median seconds of each checkout, the ratios of blocks, and scans that differ."""
    import numpy as np  # noqa: PLC0415

    found = [each.ask(what="extractor", name=name, parameters=parameters) for each in workers]
    differ = sum(a != b for a, b in zip(*found, strict=True))
    rooms = len(found[0])
    warm = [each.ask(what="block", calls=rooms) for each in workers]
    calls = rooms * max(1, round(SECONDS / np.median(warm) / rooms))
    seconds = [[], []]
    for turn in range(repeats):
        for k in (0, 1) if turn % 2 else (1, 0):
            seconds[k].append(workers[k].ask(what="block", calls=calls))
    medians = np.median(seconds, axis=2)
    return np.median(np.reshape(seconds, (2, -1)), axis=1), medians[0] / medians[1], differ


def exponent(times):
    """Return to which power of the beams time grows, by least squares over the logarithms."""
    import numpy as np  # noqa: PLC0415

    mine = {beams: time for beams, time in times.items() if GROWTH[0] <= beams <= GROWTH[1]}
    if len(mine) < 2:
        return math.nan
    return np.polyfit(np.log(list(mine)), np.log(list(mine.values())), 1)[0]


def run(workers, options):
    """Print the comparison of all extractors."""
    import numpy as np  # noqa: PLC0415

    beams = [int(each) for each in options.beams.split(",")]
    parameters = {} if options.told is None else {"range_sigma": options.told}
    names = options.extractors.split(",")
    times = {(name, k): {} for name in names for k in (0, 1)}
    print(f"this: {workers[0].root}, other: {workers[1].root}; us")
    print(f"{'extractor':18s}{'beams':>7s}{'this':>10s}{'other':>10s}{'ratio':>8s}", end="")
    print(f"{'10 .. 90 %':>16s}{'differ':>8s}")
    for many in beams:
        load = workers[0].ask(what="scenes", beams=many, rooms=options.rooms)
        for each in workers:
            each.ask(what="load", **load)
        for name in names:
            medians, ratios, differ = compare(workers, name, parameters, options.repeats)
            low, high = np.percentile(ratios, (10, 90))
            print(
                f"{name:18s}{many:7d}{1e6 * medians[0]:10.1f}{1e6 * medians[1]:10.1f}"
                f"{np.median(ratios):8.3f}{low:8.3f} .. {high:.3f}{differ:8d}",
                flush=True,
            )
            for k in (0, 1):
                times[name, k][many] = medians[k]
    for name in names:
        this, other = (exponent(times[name, k]) for k in (0, 1))
        print(
            f"{name}: grows from {GROWTH[0]} to {GROWTH[1]} beams to the power {this:.2f}", end=""
        )
        print(f" (other: {other:.2f})")


def main():
    """Start both processes and compare them; as a worker, serve."""
    parser = argparse.ArgumentParser(description="Time this checkout beside another one.")
    parser.add_argument("other", nargs="?", help="the other checkout")
    parser.add_argument("--extractors", default="direct_hough", help="names, with commas")
    parser.add_argument("--beams", default=",".join(map(str, BEAMS)), help="counts, with commas")
    parser.add_argument("--rooms", type=int, default=ROOMS, help="scans of each count of beams")
    parser.add_argument("--repeats", type=int, default=REPEATS, help="blocks of each checkout")
    parser.add_argument("--told", type=float, help="tell the extractors the range noise [m]")
    parser.add_argument("--cache", type=Path, help="keep numba's caches here, for the next run")
    parser.add_argument("--worker", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        serve(Path(options.worker))
        return
    if options.other is None:
        parser.error("the other checkout's folder is needed")
    # numba does not see that a kernel's helper in another file has changed: start without a cache.
    with tempfile.TemporaryDirectory() as folder:
        cache = options.cache or Path(folder)
        workers = [Worker(ROOT, cache / "this"), Worker(options.other, cache / "other")]
        try:
            run(workers, options)
        finally:
            for each in workers:
                each.close()


if __name__ == "__main__":
    main()
