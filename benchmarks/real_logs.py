"""The report's section on real recordings: what comes out of each, how fast, and how clean."""

import math
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import contest
import numpy as np
from page import NONE, table

import laserfeatures as lf

LOGS = [
    "sick/aces-corrected.log.gz",
    "sick/belgioioso-corrected.log.gz",
    "sick/csail-corrected.log.gz",
    "sick/csail.corrected.gfs.gz",
    "sick/flirt_mit-cscail.log.gz",
    "sick/freiburg-101-corrected.log.gz",
    "sick/orebro-corrected.log.gz",
    "sick/seattle-corrected.log.gz",
    "rosbag/legtracker_demo_stationary_simple_environment.bag",
    "rosbag/cartographer_data_hokuyo.bag",
    "ros2_converted/urg04lx_ros2_mcap",
    "ros2_converted/urg04lx_ros2_sqlite3",
    "urg/breezy_exp1.dat.gz",
    "urg/brenner_robot4",
    "urg/frm_g5_Scan1.csv.gz",
    "urg/frm_g5_Scan2.csv.gz",
    "urg/frm_g5_Scan3.csv.gz",
    "rplidar/tdt4856_points_8k_1.txt",
    "rplidar/tdt4856_points_dekk_8k_1.txt",
]
SAMPLE = 300  # scans of a log, spread evenly, that all extractors run on
COMMAND = str(Path(sys.executable).parent / "laserfeatures")

METHOD = """Every log of `../shared/data`, read whole with the defaults. Lines, corners and real
corners are means over the scans; blind scans are those without a corner, empty ones those without
a line. Times are of one pass, in this process, every scan once, one extractor after the other:
median of the extraction, mean of the reading (parsing and unpacking; the first ten scans are read
when the log is opened). Explained: share of the returns that lie on a segment. The commands
`laserfeatures extract` and `laserfeatures plot` (the middle scan) ran on each: {failures}.

First direct_hough in full:"""

ALL = f"All extractors likewise, on at most {SAMPLE} scans spread evenly over each log, {{what}}:"
SHORT = ("legtracker_demo_stationary_simple_environment.bag", "legtracker.bag")


@dataclass(frozen=True)
class Found:
    """What an extractor found in a log."""

    seconds: np.ndarray
    lines: np.ndarray
    corners: np.ndarray
    real: np.ndarray
    explained: int  # returns on a segment

    @classmethod
    def of(cls, extractor, scans):
        """Run an extractor on all scans."""
        extractor(scans[0])
        rows = []
        for scan in scans:
            again = contest.fresh(scan)
            start = time.perf_counter()
            features = extractor(again)
            seconds = time.perf_counter() - start
            corners = features.corners
            on_segments = features.segments.points.any(axis=0).sum()
            rows.append(
                (seconds, len(features.lines), len(corners), corners.real.sum(), on_segments)
            )
        *columns, on_segments = np.transpose(rows)
        return cls(*columns, explained=int(on_segments.sum()))


def section(options):
    """Return the section's paragraphs."""
    extractors = {name: lf.get_extractor(name) for name in lf.list_extractors()}
    with lf.open_source(options.data / LOGS[0]) as scans:
        first = next(scans)
    for extractor in extractors.values():
        extractor(first)  # compile
    rows, failures, tables = [], [], {what: [] for what in QUANTITIES}
    for name in LOGS:
        short = name.rpartition("/")[2].removesuffix("-corrected.log.gz").replace(*SHORT)
        scans, facts, reading = _read(options.data / name)
        full = Found.of(extractors["direct_hough"], scans)
        rows.append([short, *facts, *_row(full, scans), reading])
        sample = scans[:: max(1, math.ceil(len(scans) / SAMPLE))]
        found = {each: Found.of(extractor, sample) for each, extractor in extractors.items()}
        for what, cell in QUANTITIES.items():
            tables[what].append([short, *map(cell, found.values())])
        failures += _run_commands(options.data / name, len(scans) // 2)
    header = [
        "log", "scans", "beams", "lines", "corners", "real", "blind", "empty", "explained",
        "extract [µs]", "read [ms]",
    ]  # fmt: skip
    text = METHOD.format(failures="all without an error" if not failures else "; ".join(failures))
    return ["## Real recordings", text, table(header, rows)] + [
        part
        for what, lines in tables.items()
        for part in (ALL.format(what=what), table(["log", *extractors], lines))
    ]


def _lines(found):
    return f"{found.lines.mean():.2f}" if found.lines.any() else NONE


QUANTITIES = {
    "median time of a scan [µs]": lambda found: f"{1e6 * np.median(found.seconds):.0f}",
    "lines a scan": _lines,
    "corners a scan, of them real": lambda found: (
        f"{found.corners.mean():.2f}, {found.real.mean():.2f}"
    ),
    "blind scans": lambda found: int((found.corners == 0).sum()),
}


def _read(path):
    """Return the scans of a log, how many they are and of how many beams, and the time [ms]."""
    start = time.perf_counter()
    with lf.open_source(path) as source:
        scans = list(source)
    reading = time.perf_counter() - start
    return scans, [len(scans), len(scans[0])], f"{1e3 * reading / len(scans):.2f}"


def _row(found, scans):
    returns = sum(int(scan.valid.sum()) for scan in scans)
    return [
        f"{found.lines.mean():.2f}",
        f"{found.corners.mean():.2f}",
        f"{found.real.mean():.2f}",
        int((found.corners == 0).sum()),
        int((found.lines == 0).sum()),
        f"{found.explained / max(returns, 1):.0%}",
        f"{1e6 * np.median(found.seconds):.0f}",
    ]


def _run_commands(path, scan):
    """Run `extract` and `plot` on a log; return what failed."""
    with TemporaryDirectory() as folder:
        programs = [
            [COMMAND, "extract", str(path), "-o", f"{folder}/features.jsonl"],
            [COMMAND, "plot", str(path), "--scan", str(scan), "-o", f"{folder}/scan.png"],
        ]
        runs = [
            subprocess.run(run, check=False, capture_output=True, text=True)  # noqa: S603 - the programs above
            for run in programs
        ]
    return [
        f"{run.args[1]} {path.name}: {run.stderr.strip()[-200:]}" for run in runs if run.returncode
    ]
