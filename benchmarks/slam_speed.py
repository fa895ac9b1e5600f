"""Time EKF-SLAM's whole step, and its parts, as the map grows to hundreds of landmarks.

Run ``OMP_NUM_THREADS=1 python benchmarks/slam_speed.py -o FOLDER``: it writes slam_speed.json and
slam_speed.md, and draws docs/slam_speed.png. One thread, since matrices of this size gain nothing
from more, and a robot's other threads have work of their own.

A robot drives through room after room of a simulated building, and maps them. So a map of 500
landmarks is what a filter comes to by itself, with all its correlations, and what each scan sees
grows with the furniture of the room and not with the map.
"""

import argparse
import math
import os
import time
from contextlib import ExitStack, contextmanager
from functools import wraps
from itertools import pairwise
from pathlib import Path
from unittest.mock import patch

import numpy as np
from page import new_figure, table, verdict
from slam_building import BARE, Building

import laserfeatures as lf
from laserfeatures.comparison.machine import machine
from laserfeatures.poses import compose, relative
from laserfeatures.simulation import Scanner
from laserfeatures.slam import EkfSlam, Motion
from laserfeatures.slam import filter as slam_filter
from laserfeatures.slam.landmarks import Landmarks
from laserfeatures.slam.registration import register
from laserfeatures.slam.state import State
from laserfeatures.testbench.output import to_json

SIZES = (10, 25, 50, 100, 200, 300, 500, 700)
TARGETS = {100: 2e-3, 500: 20e-3}  # [s], of the whole step's median
STEPS = 30  # that are timed at each size, at least: those nearest to it
SPREAD, LEAST_SPREAD = 0.1, 6  # share and number; steps farther off are of another size
WARM = 10  # scans, before anything is timed
SCANNER = Scanner()  # the LMS200, as the paper has it
MOTION = Motion(way=0.02, side=0.01, turn_by_way=0.01, turn=0.02)
VAGUE = np.diag([0.1**2, 0.1**2, 0.1**2])  # a step that is registered
RIGHT = 0.01  # of the way, that the estimate may be off in the end
# What is timed inside of a step: whose attribute it is, and the part it counts as.
PARTS = {
    "association": [(slam_filter, "matches_of")],
    "update": [(State, "move"), (State, "correct"), (slam_filter, "measurement_of")],
    "map's care": [(Landmarks, "saw"), (Landmarks, "propose"), (Landmarks, "worth_keeping")],
}
METHOD = """A robot with a simulated LMS200 ({beams} beams over 180°, 10 m) maps {rooms} rooms, a
scan each 5 cm ({scans} scans, {way:.0f} m); medians of all scans at which the map is within
{spread:.0%} of a size, or of the {steps} nearest to it. One thread, {processor}. In the end the
estimate is {off:.2f} m off, odometry {astray:.1f} m. Steps this short need no registration of
scans; where odometry is less sure, that takes {milliseconds:.1f} ms more."""


def main():
    """Measure, write and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--docs", type=Path, default=Path(__file__).parents[1] / "docs")
    parser.add_argument("--most", type=int, default=SIZES[-1], help="leave larger maps out")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if os.environ.get("OMP_NUM_THREADS") != "1":
        parser.error("set OMP_NUM_THREADS=1 before the start: NumPy reads it as it is imported")
    sizes = [size for size in SIZES if size <= options.most]
    drive = Drive(options.seed, most=sizes[-1])
    drive.check()
    rows = [medians(drive, size) for size in sizes]
    facts = {"machine": machine(), "seed": options.seed, **drive.facts(), "sizes": rows}
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "slam_speed.json").write_text(to_json(facts))
    page = text(facts)
    (options.output / "slam_speed.md").write_text(page + "\n")
    picture(rows).savefig(options.docs / "slam_speed.png", dpi=110)
    print(page)


class Drive:
    """A filter's way through a building, until its map is large enough, and the time it took."""

    def __init__(self, seed, most):
        rng = np.random.default_rng(seed)
        self.rooms = BARE + 1 + most // 25
        building = Building(rng, self.rooms)
        extractor, self.slam = lf.get_extractor("direct_hough"), EkfSlam(motion=MOTION)
        self.truth, self.odometry, self.steps = [], [], []
        self.seconds, self.points = [], []
        with timed_parts() as parts:
            for pose in building.way:
                self.truth.append(pose)
                self.odometry.append(self._moved(rng))
                scan = SCANNER.scan(building.world, pose, rng)
                parts.update(dict.fromkeys(parts, 0.0))
                start = time.perf_counter()
                features = extractor(scan)
                middle = time.perf_counter()
                step = self.slam.step(self.odometry[-1], features, building.way[0])
                end = time.perf_counter()
                self.steps.append(step)
                self.points.append(scan.points)
                self.seconds.append({"whole": end - start, "features": middle - start, **parts})
                if step.landmarks > most * (1 + SPREAD):
                    break
        self.landmarks = np.array([step.landmarks for step in self.steps])

    def _moved(self, rng):
        """Return where odometry takes the robot to be, after its last step."""
        if not self.odometry:
            return self.truth[0]
        step = relative(*self.truth[-2:])
        x, y, turn = rng.multivariate_normal(np.zeros(3), MOTION.covariance(step)).tolist()
        wrong = lf.Pose2D(step.x + x, step.y + y, step.theta + turn)
        return compose(self.odometry[-1], wrong)

    def check(self):
        """Check that what was timed is right."""
        notices = [step.notice for step in self.steps if step.notice]
        assert not notices, notices
        assert self.off(self.steps[-1].pose) < RIGHT * self.way, "the estimate went astray"
        covariance = self.slam.state.covariance
        assert (covariance == covariance.T).all()
        assert np.linalg.eigvalsh(covariance)[0] > -1e-12 * covariance.max()
        matched = np.array([step.matched for step in self.steps[1:]])
        assert np.mean(matched >= 3) > 0.95, "too little was recognised to time the update"

    def registration(self):
        """Return how long it takes to lay a scan over the one before [s], in the median."""
        seconds = []
        for k in np.linspace(STEPS, len(self.truth) - 1, STEPS).astype(int):
            before, after = self.points[k - 1], self.points[k]
            step = relative(*self.truth[k - 1 : k + 1])
            register(before, after, step, VAGUE)  # compile, and warm the caches
            start = time.perf_counter()
            found, _ = register(before, after, step, VAGUE)
            seconds.append(time.perf_counter() - start)
            off = relative(step, found)
            assert math.hypot(off.x, off.y) < 0.1, (k, off)
        return float(np.median(seconds))

    @property
    def way(self):
        """How far the robot has come [m]."""
        return sum(math.hypot(b.x - a.x, b.y - a.y) for a, b in pairwise(self.truth))

    def off(self, pose):
        """Return how far a pose is from the true one in the end [m]."""
        return math.hypot(pose.x - self.truth[-1].x, pose.y - self.truth[-1].y)

    def facts(self):
        """Return what is to be known of the drive."""
        return {
            "beams": SCANNER.beams,
            "rooms": self.rooms,
            "scans": len(self.steps),
            "way": self.way,
            "off": self.off(self.steps[-1].pose),
            "astray": self.off(self.odometry[-1]),
            "landmarks": int(self.landmarks[-1]),
            "registration": self.registration(),
        }


@contextmanager
def timed_parts():
    """Count the time that each part takes, in a mapping, for as long as the context lasts."""
    seconds = dict.fromkeys(PARTS, 0.0)
    with ExitStack() as stack:
        for part, places in PARTS.items():
            for owner, name in places:
                stack.enter_context(patch.object(owner, name, _timed(owner, name, part, seconds)))
        yield seconds


def _timed(owner, name, part, seconds):
    function = getattr(owner, name)

    @wraps(function)
    def timed(*args, **kwargs):
        start = time.perf_counter()
        try:
            return function(*args, **kwargs)
        finally:
            seconds[part] += time.perf_counter() - start

    return timed


def medians(drive, size):
    """Return a size's median times [s], of the whole and of each part."""
    off = abs(drive.landmarks - size)
    off[:WARM] = size
    nearest = np.argsort(off, kind="stable")[: max(STEPS, np.sum(off <= SPREAD * size))]
    assert off[nearest].max() <= max(2 * SPREAD * size, LEAST_SPREAD), f"too few near {size}"
    times = {part: np.array([drive.seconds[i][part] for i in nearest]) for part in drive.seconds[0]}
    times["rest"] = times["whole"] - sum(times[part] for part in ("features", *PARTS))
    return {
        "size": size,
        "steps": len(nearest),
        "landmarks": float(np.median(drive.landmarks[nearest])),
        "matched": float(np.median([drive.steps[i].matched for i in nearest])),
        "p90": float(np.quantile(times["whole"], 0.9)),
        **{part: float(np.median(values)) for part, values in times.items()},
    }


def text(facts):
    """Return the page."""
    parts = ["features", *PARTS, "rest"]
    rows = [
        [f"{row['landmarks']:.0f}", f"{row['matched']:.0f}",
         *(f"{1e3 * row[part]:.2f}" for part in parts),
         f"**{1e3 * row['whole']:.2f}**", f"{1e3 * row['p90']:.2f}"]
        for row in facts["sizes"]
    ]  # fmt: skip
    header = ["landmarks", "recognised", *(f"{part} [ms]" for part in parts), "whole [ms]", "90 %"]
    told = []
    for size, target in TARGETS.items():
        for row in facts["sizes"]:
            if row["size"] == size:
                met = verdict(row["whole"] < target)
                told.append(f"{size} landmarks: under {1e3 * target:.0f} ms, {met}.")
    method = METHOD.format(
        steps=STEPS,
        spread=SPREAD,
        milliseconds=1e3 * facts["registration"],
        processor=facts["machine"]["processor"],
        **facts,
    ).replace("\n", " ")
    return "\n\n".join([method, table(header, rows), " ".join(told)])


def picture(rows):
    """Return time over landmarks, with what quadratic growth would be."""
    figure = new_figure(6.5, 4.5)
    axes = figure.add_subplot()
    counts = np.array([row["landmarks"] for row in rows])
    whole = 1e3 * np.array([row["whole"] for row in rows])
    axes.loglog(counts, whole, "o-", color="black", lw=2, label="whole step")
    for part in ("features", *PARTS):
        axes.loglog(counts, [1e3 * row[part] for row in rows], ".-", lw=1, label=part)
    update = 1e3 * rows[-1]["update"] * (counts / counts[-1]) ** 2
    axes.loglog(counts, update, ":", color="gray", label="slope 2")
    for size, target in TARGETS.items():
        axes.plot(size, 1e3 * target, "v", color="red")
        axes.annotate(
            f"target {1e3 * target:.0f} ms",
            (size, 1e3 * target),
            (0, -14),
            textcoords="offset points",
            color="red",
            ha="center",
        )
    axes.set_xticks(SIZES, SIZES, minor=False)
    axes.set_xticks([], minor=True)
    axes.set(xlabel="landmarks", ylabel="median time [ms]", ylim=(0.05, None))
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    return figure


if __name__ == "__main__":
    main()
