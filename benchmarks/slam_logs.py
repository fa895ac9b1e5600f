"""Measure EKF-SLAM on recorded logs: every extractor, with corners, walls and both.

Run ``python benchmarks/slam_logs.py -o FOLDER``: it writes slam_logs.md, the tables of docs/slam.md
and slam_logs.json; about 10 minutes on 2 cores. Each run on CSAIL is repeated with odometry that
differs by little (seeded noise of 2 cm and 0.6 degrees, which is less than it is wrong by in one
step): where the least change breaks it, one lucky run tells nothing.
"""

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from itertools import permutations
from pathlib import Path

import numpy as np
from page import NONE, table

import laserfeatures as lf
from laserfeatures.mapping.against import against
from laserfeatures.mapping.matching import matched
from laserfeatures.mapping.reference import read_reference
from laserfeatures.mapping.run import Recorder
from laserfeatures.noise_model import NoiseModel
from laserfeatures.slam import EkfSlam
from laserfeatures.slam import filter as ekf

CSAIL = ("sick/csail.corrected.gfs.gz", "sick/csail-corrected.log.gz")
BRENNER = ("urg/brenner_robot4", "urg/brenner_robot4")
BREEZY = ("urg/breezy_exp1.dat.gz", None)
KINDS = {"corners": (True, False), "walls": (False, True), "both": (True, True)}
REPEATS = 5
NOISE, TURN = 0.02, 0.01  # [m], [rad]
SIDE = 2.02  # [m] of the arena
SURE = 20  # sightings of a corner that is compared
# What was tried on CSAIL, each by leaving one thing out or changing it.
TRIED = {
    "as it is": {},
    "odometry alone predicts": {"registered": False},
    "nearest neighbours": {"association": "nearest"},
    "extractors' covariances alone": {"roughness": 0.0},
    "plain EKF, nothing carried over": {"plain": True},
}


def main():
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--repeats", type=int, default=REPEATS)
    parser.add_argument("-e", "--extractor", action="append", default=[])
    options = parser.parse_args()
    names = options.extractor or lf.list_extractors()
    every = [(name, kind) for name in names for kind in KINDS]
    jobs = [
        *((options.data, CSAIL, name, kind, r, {}) for name, kind in every
          for r in range(options.repeats)),
        *((options.data, log, name, kind, 0, {}) for log in (BRENNER, BREEZY)
          for name, kind in every),
        *((options.data, CSAIL, "direct_hough", kind, r, given) for given in TRIED.values()
          for kind in KINDS for r in range(options.repeats)),
    ]  # fmt: skip
    with ProcessPoolExecutor(2) as pool:
        found = dict(zip(map(repr, jobs), pool.map(run, jobs), strict=True))
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "slam_logs.json").write_text(json.dumps(list(found.values()), indent=1))
    (options.output / "slam_logs.md").write_text(page(options, names, found))


def run(job):
    """Return the figures of one run."""
    data, (source, reference), name, kind, repeat, given = job
    given = dict(given)
    if given.pop("plain", False):
        ekf.carried_over = nothing_carried_over
    corners, walls = KINDS[kind]
    extractor, model = lf.get_extractor(name), NoiseModel()
    recorder = Recorder(
        lambda scan: extractor(scan, noise=model.feed(scan)),
        EkfSlam(corners=corners, walls=walls, **given),
    )
    noise = np.random.default_rng(repeat).normal(0, (NOISE, NOISE, TURN), (10_000, 3))
    with lf.open_source(data / source, poses="odometry") as scans:
        for i, scan in enumerate(scan for scan in scans if scan.pose):
            x, y, theta = noise[i] if repeat else (0, 0, 0)
            pose = lf.Pose2D(scan.pose.x + x, scan.pose.y + y, scan.pose.theta + theta)
            recorder.add(scan, pose, pose)
    ekf.carried_over = CARRIED_OVER
    made = recorder.run()
    figures = {
        "log": source, "extractor": name, "landmark_kinds": kind, "repeat": repeat, **given,
        "landmarks": len(made.map), "step_ms": 1e3 * float(np.median(made.seconds)),
        "notices": made.notices,
    }  # fmt: skip
    if reference:
        truth = read_reference(data / reference)
        held = against(made, truth, matched(made.estimate, truth))
        figures |= asdict(held.slam) | {
            f"odometry_{k}": v for k, v in asdict(held.odometry).items()
        }
    if source == BRENNER[0]:
        figures["square"] = off_the_square(made.map)
    return figures


CARRIED_OVER = ekf.carried_over


def nothing_carried_over(before, _after, _is_wall, _anchors):
    """Return what leaves the covariance as a plain EKF has it."""
    return np.zeros((len(before), 3))


def off_the_square(landmarks):
    """Return how far the worst of the arena's corners is from a square that is laid on them [m]."""
    seen = [m.values for m in landmarks if m.kind == "corner" and m.sightings >= SURE]
    square = SIDE * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    if len(seen) < len(square):
        return None
    away = np.linalg.norm(np.array(seen)[:, None] - square, axis=2)
    found = np.array(seen)[away.argmin(axis=0)]
    return min(worst_off(square, found[list(order)]) for order in permutations(range(4)))


def worst_off(square, found):
    """Return the largest distance after a fit by turn and shift."""
    a, b = square - square.mean(axis=0), found - found.mean(axis=0)
    u, _, v = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, np.linalg.det(u @ v)]) @ v
    return float(np.linalg.norm(a @ turn - b, axis=1).max())


def page(options, names, found):
    """Return the tables as Markdown."""
    parts = []
    if options.repeats > 1:
        parts.append(f"Medians of {options.repeats} runs on CSAIL, worst in brackets.")
    for log, keys in ((CSAIL, ()), (BRENNER, ("square",)), (BREEZY, ())):
        repeats = options.repeats if log == CSAIL else 1
        rows = []
        for name in names:
            cells = [name]
            for kind in KINDS:
                runs = [found[repr((options.data, log, name, kind, r, {}))] for r in range(repeats)]
                if log != BREEZY:
                    cells.append(spread([each["ate_rmse"] for each in runs]))
                cells += [metres(runs[0][key]) for key in keys]
                cells += [runs[0]["landmarks"], f"{runs[0]['step_ms']:.1f}"]
            rows.append(cells)
        shown = [
            *(["ATE [m]"] * (log != BREEZY)),
            *(["square [m]"] * bool(keys)),
            "landmarks",
            "ms",
        ]
        header = ["", *(f"{kind}: {what}" for kind in KINDS for what in shown)]
        parts += [f"## {log[0]}", odometry(found, log), table(header, rows)]
    rows = [
        [what, *(spread([found[repr((options.data, CSAIL, "direct_hough", kind, r, given))]
                         ["ate_rmse"] for r in range(options.repeats)]) for kind in KINDS)]
        for what, given in TRIED.items()
    ]  # fmt: skip
    parts += ["## Tried on CSAIL, direct_hough", table(["ATE [m]", *KINDS], rows)]
    return "\n\n".join(parts) + "\n"


def odometry(found, log):
    """Return what odometry alone comes to, as a line."""
    errors = [e["odometry_ate_rmse"] for e in found.values() if e["log"] == log[0] and log[1]]
    return f"Odometry alone: ATE {errors[0]:.3f} m." if errors else "No reference."


def metres(value):
    """Return a length as text."""
    return NONE if value is None else f"{value:.3f}"


def spread(values):
    """Return the median, and the worst if there are several."""
    if len(values) == 1:
        return f"{values[0]:.3f}"
    return f"{np.median(values):.2f} ({max(values):.2f})"


if __name__ == "__main__":
    main()
