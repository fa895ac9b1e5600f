"""The report's section on memory: what scans leave behind, and the peak of whole runs.

As a script, ``python benchmarks/memory.py 20000`` is the fresh process in which that many scans are
measured; it prints JSON.
"""

import gc
import gzip
import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import contest
import numpy as np
from page import table, verdict

import laserfeatures as lf

SCANS = 20_000
HELD = 3_000
REPEATED = 10  # times the log
FLAT = 0.05  # growth of the peak that still counts as flat
LARGEST_TEXT = "urg/breezy_exp1.dat.gz"
LARGEST_BAG = "rosbag/legtracker_demo_stationary_simple_environment.bag"

# What the process reports of itself: what wait4 gives includes the peak of the one it came from.
PEAK = 'print(next(line for line in open("/proc/self/status") if line.startswith("VmHWM")))'
EXTRACT = f"""
import sys
from laserfeatures.cli import main
sys.argv = ["laserfeatures", "extract", sys.argv[1], "-o", sys.argv[2]]
try:
    main()
finally:
    {PEAK}
"""
IMPORTS = f"""
import laserfeatures.pipeline
{PEAK}
"""

TEXT = """tracemalloc does not see what numba allocates, so memory is read from the system, in a
fresh process. {scans} calls with {cases} different scans (682 beams, the known room), each result
dropped: the resident set grows by {growth:.0f} kB in all, and the system hands out {faults:.3f}
fresh pages a scan; an accumulator made anew would take {accumulator}. So the accumulator is
reused and nothing leaks: numba's own counter shows {balance} arrays more made than freed.

{held} results held at once take {kept:.1f} kB of resident memory each: {arrays:.1f} kB are their
arrays ({flags:.1f} kB of them `segments.points`, a flag per segment and beam), the rest Python
objects and the allocator's rounding.

Target: a scan allocates no more than its results: {verdict}. In the kernels a scan makes
{made:.0f} arrays, of which the results hold {buffers:.0f}; the others are temporary, and come
from and go back to the allocator within the call. How many bytes they hold at once is not
measured."""

EXTRACT_TEXT = """Target: peak memory of `laserfeatures extract` flat in the log's length. The
largest log by beams is the bag, the largest of text {text}; each is also run strung together
{times} times. Peak resident memory (VmHWM of Linux) of the process alone: {verdict}, the longer
log takes at most {growth:.0%} more. Python, numpy, numba and the compiled kernels make up most of
it: importing them alone peaks at {imports} MB."""


def section(options):
    """Return the section's paragraphs."""
    measured = json.loads(
        _output_of([__file__, options.repeats(SCANS)], {**os.environ, "NUMBA_NRT_STATS": "1"})
    )
    measured["verdict"] = verdict(measured["made"] <= measured["buffers"])
    with TemporaryDirectory() as folder:
        rows = [_peaks(options.data / name, Path(folder)) for name in (LARGEST_TEXT, LARGEST_BAG)]
    growth = max(row[4] / row[2] - 1 for row in rows)
    text = EXTRACT_TEXT.format(
        times=REPEATED,
        text=LARGEST_TEXT,
        imports=_peak_of(IMPORTS),
        growth=growth,
        verdict=verdict(growth < FLAT),
    )
    header = ["log", "scans", "peak [MB]", f"scans, {REPEATED} times", "peak [MB]"]
    return ["## Memory", TEXT.format(**measured), text, table(header, rows)]


def scans(count):
    """Measure in this process; return the figures of `TEXT`."""
    extractor = lf.get_extractor("direct_hough")
    cases = contest.room_cases(contest.SENSORS[682], noises=50)
    for case in cases:
        extractor(contest.fresh(case.scan))
    gc.collect()
    made, before, faults = _arrays_made(), _resident(), _faults()
    for k in range(count):
        extractor(contest.fresh(cases[k % len(cases)].scan))
    after, new_faults, now_made = _resident(), _faults(), _arrays_made()
    held = [extractor(contest.fresh(cases[k % len(cases)].scan)) for k in range(HELD)]
    kept = (_resident() - after) / HELD
    buffers = [_buffers(features) for features in held]
    return {
        "scans": count,
        "cases": len(cases),
        "growth": after - before,
        "faults": (new_faults - faults) / count,
        "accumulator": 180 * 1024 * 4 // resource.getpagesize(),
        "made": (now_made[0] - made[0]) / count,
        "balance": now_made[0] - made[0] - (now_made[1] - made[1]),
        "held": HELD,
        "kept": kept,
        "arrays": float(np.mean([sum(sizes) for sizes in buffers])) / 1024,
        "buffers": float(np.mean([len(sizes) for sizes in buffers])),
        "flags": float(np.mean([features.segments.points.nbytes for features in held])) / 1024,
    }


def _buffers(features):
    """Return the bytes of each buffer under the arrays of the results; the scan is not ours."""
    parts = [features.lines, features.segments, features.corners]
    arrays = [a for part in parts for a in vars(part).values() if isinstance(a, np.ndarray)]
    buffers = {}
    for array in arrays:
        root = array
        while isinstance(root.base, np.ndarray):
            root = root.base
        buffers[id(root)] = root.nbytes
    return list(buffers.values())


def _resident():
    """Return the resident set [kB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1024


def _faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt


def _arrays_made():
    """Return how many arrays numba's kernels have made and freed so far."""
    from numba.core.runtime import rtsys  # noqa: PLC0415 - the report itself needs no numba

    stats = rtsys.get_allocation_stats()
    return stats.alloc, stats.free


def _peaks(path, folder):
    """Return a row: a log's name, its scans and peak, and both of it strung together."""
    many = folder / path.name
    count = _repeat_bag(path, many) if path.suffix == ".bag" else _repeat_text(path, many)
    once, often = (_peak_of(EXTRACT, log, folder / "out.jsonl") for log in (path, many))
    return [path.name, count, once, count * REPEATED, often]


def _repeat_text(path, many):
    many.write_bytes(path.read_bytes() * REPEATED)  # gzip files may be strung together
    with gzip.open(path) as lines:
        return sum(1 for _ in lines)


def _repeat_bag(path, many):
    from rosbags.rosbag1 import Reader, Writer  # noqa: PLC0415 - extra "ros"

    count = 0
    with Reader(path) as reader, Writer(many) as writer:
        found = next(c for c in reader.connections if c.msgtype.endswith("LaserScan"))
        topic = writer.add_connection(
            found.topic, found.msgtype, msgdef=found.msgdef.data, md5sum=found.digest
        )
        for _ in range(REPEATED):
            for _, time, raw in reader.messages([found]):
                writer.write(topic, time + count, raw)
                count += 1
    return count // REPEATED


def _peak_of(code, *arguments):
    """Return the peak resident memory [MB] that a program prints as its last line."""
    return round(int(_output_of(["-c", code, *arguments]).split()[-2]) / 1024)


def _output_of(arguments, environment=None):
    run = [sys.executable, *map(str, arguments)]
    return subprocess.run(  # noqa: S603 - only programs of this file
        run, check=True, capture_output=True, text=True, env=environment
    ).stdout


if __name__ == "__main__":
    print(json.dumps(scans(int(sys.argv[1]))))
