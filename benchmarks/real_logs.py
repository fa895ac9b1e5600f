"""The report's section on real recordings: what comes out of each, how fast, and how clean."""

import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import contest
import numpy as np
from page import table

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
COMMAND = str(Path(sys.executable).parent / "laserfeatures")

METHOD = """Every log of `../shared/data`, read whole with the defaults. Lines, corners and real
corners are means over the scans; blind scans are those without a corner, empty ones those without
a line. Times are of one pass, in this process, every scan once: median of the extraction, mean of
the reading (parsing and unpacking; the first ten scans are read when the log is opened).
Explained: share of the returns that lie on a segment. The commands `laserfeatures extract` and
`laserfeatures plot` (the middle scan) ran on each: {failures}."""


def section(options):
    """Return the section's paragraphs."""
    extractor = lf.get_extractor("direct_hough")
    with lf.open_source(options.data / LOGS[0]) as scans:
        extractor(next(scans))  # compile
    rows, failures = [], []
    for name in LOGS:
        row = _row(extractor, options.data / name)
        rows.append([name.rpartition("/")[2].removesuffix("-corrected.log.gz"), *row])
        failures += _run_commands(options.data / name, row[0] // 2)
    header = [
        "log", "scans", "beams", "lines", "corners", "real", "blind", "empty", "explained",
        "extract [µs]", "read [ms]",
    ]  # fmt: skip
    text = METHOD.format(failures="all without an error" if not failures else "; ".join(failures))
    return ["## Real recordings", text, table(header, rows)]


def _row(extractor, path):
    start = time.perf_counter()
    with lf.open_source(path) as source:
        scans = list(source)
    reading = time.perf_counter() - start
    seconds, results = [], []
    for scan in scans:
        again = contest.fresh(scan)
        start = time.perf_counter()
        features = extractor(again)
        seconds.append(time.perf_counter() - start)
        results.append(features)
    corners = np.array([len(features.corners) for features in results])
    on_segments = sum(int(f.segments.points.any(axis=0).sum()) for f in results)
    lines = np.array([len(features.lines) for features in results])
    return [
        len(scans),
        len(scans[0]),
        f"{lines.mean():.2f}",
        f"{corners.mean():.2f}",
        f"{np.mean([features.corners.real.sum() for features in results]):.2f}",
        int((corners == 0).sum()),
        int((lines == 0).sum()),
        f"{on_segments / max(sum(int(scan.valid.sum()) for scan in scans), 1):.0%}",
        f"{1e6 * np.median(seconds):.0f}",
        f"{1e3 * reading / len(scans):.2f}",
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
