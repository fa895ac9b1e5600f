"""Measure EKF-SLAM on simulated drives: every extractor, with corners, walls and both.

Run ``python benchmarks/slam_simulation.py -o FOLDER``: it writes slam_simulation.md, the tables of
docs/slam.md, and slam_simulation.json, all figures of every drive. ``--seeds 30`` drives of the
office loop take about 15 minutes on 2 cores. ``--odometry`` prints instead how wrong odometry is
on drives with other seeds, beside the noise that the filter takes for it.
"""

import argparse
import math
import time
from dataclasses import asdict
from functools import partial
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
from page import table

import laserfeatures as lf
from laserfeatures.cli.slam_options import LANDMARKS, make_slam
from laserfeatures.cli.slam_simulate_table import LEGEND, table_of
from laserfeatures.cli.slam_simulated import document_of, summaries_of
from laserfeatures.comparison.document import Document, Heading, Paragraph
from laserfeatures.comparison.machine import machine
from laserfeatures.comparison.to_markdown import to_markdown
from laserfeatures.mapping.monte_carlo import Trial
from laserfeatures.mapping.robot_motion import motion_of
from laserfeatures.poses import relative
from laserfeatures.simulation.robot import Robot
from laserfeatures.sources.simulated import readings_of
from laserfeatures.testbench.output import to_json
from laserfeatures.testbench.workers import core_count, in_parallel

OFFICE = str(files("laserfeatures.simulation") / "office.toml")
ODOMETRY_SEEDS = range(100, 120)  # not those that are reported
WINDOWS = (1, 5, 10, 25)  # scans
STRAIGHT = 0.05  # [rad] of a turn at most, over a window
ON_THE_SPOT = 0.08  # [m] of way at most, for each radian of a turn; the sensor is ahead of the axle


def main():
    """Measure and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path())
    parser.add_argument("--plan", default=OFFICE)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--workers", type=int, default=core_count())
    parser.add_argument("--odometry", action="store_true")
    options = parser.parse_args()
    if options.odometry:
        print(odometry_table(options.plan, options.workers))
        return
    start = time.perf_counter()
    found = {kind: drives(options, kind) for kind in LANDMARKS}
    minutes = (time.perf_counter() - start) / 60
    for kind, outcomes in found.items():
        for name, score in outcomes[0].scores.items():
            assert math.isfinite(score.final_error), (kind, name)
    facts = {"minutes": minutes, "workers": options.workers, "machine": machine()}
    whole = facts | {
        "motion": asdict(motion_of(Robot())),
        **{kind: document_of(outcomes) for kind, outcomes in found.items()},
    }
    options.output.mkdir(parents=True, exist_ok=True)
    (options.output / "slam_simulation.json").write_text(to_json(whole))
    (options.output / "slam_simulation.md").write_text(page(options, found, minutes))
    print(f"{options.seeds} seeds, {minutes:.1f} minutes with {options.workers} workers")


def drives(options, kind):
    """Return what comes of all drives, with every extractor, for one kind of landmarks."""
    trial = Trial(
        plan=options.plan,
        extractors={name: lf.get_extractor(name) for name in lf.list_extractors()},
        slam=partial(make_slam, kind, "joint", motion_of(Robot()), 0.0),
    )
    return in_parallel(trial, range(options.seeds), workers=options.workers)


def page(options, found, minutes):
    """Return the tables as Markdown."""
    blocks = []
    for kind, outcomes in found.items():
        blocks += [Heading(f"Landmarks: {kind}"), table_of(summaries_of(outcomes))]
    about = (
        f"{options.seeds} drives of {Path(options.plan).name}, seeds 0 to {options.seeds - 1}; "
        f"{minutes:.0f} minutes with {options.workers} workers."
    )
    document = Document("SLAM on simulated drives", [Paragraph(about), Paragraph(LEGEND), *blocks])
    return to_markdown(document, lambda picture: picture.name)


def odometry_table(plan, workers):
    """Return the rms errors of odometry on straights and turns, and what the filter takes."""
    errors = np.concatenate(
        in_parallel(partial(window_errors, plan), ODOMETRY_SEEDS, workers=workers)
    )
    motion = motion_of(Robot())
    rows = []
    for window in WINDOWS:
        of_window = errors[errors[:, 0] == window]
        way, turn = of_window[:, 1], of_window[:, 2]
        for kind, which in (
            ("straight", (turn < STRAIGHT) & (way > 0.9 * way.max())),
            ("turn", (way < ON_THE_SPOT * turn) & (turn > 0.1 * window**0.5)),
        ):
            if which.sum() < 20:
                continue
            metres, radians = way[which].mean(), turn[which].mean()
            along, _, heading = np.sqrt((of_window[which, 3:] ** 2).mean(axis=0))
            taken = math.sqrt(motion.turn_by_way**2 * metres + motion.turn**2 * radians)
            rows.append(
                [kind, window, which.sum(), f"{metres:.2f}", f"{radians:.2f}", f"{1e3 * along:.2f}",
                 f"{1e3 * motion.way * math.sqrt(metres):.2f}", f"{1e3 * heading:.2f}",
                 f"{1e3 * taken:.2f}"]
            )  # fmt: skip
    header = ["", "scans", "windows", "way [m]", "turn [rad]", "along [mm]", "taken [mm]",
              "heading [mrad]", "taken [mrad]"]  # fmt: skip
    return table(header, rows)


def window_errors(plan, seed):
    """Return scans, way, turn and the errors x, y, theta of odometry over windows, (K, 6)."""
    readings = list(readings_of(plan, seed=seed))
    truth = [reading.observation.pose for reading in readings]
    odometry = [reading.scan.pose for reading in readings]
    steps = [relative(a, b) for a, b in pairwise(truth)]
    way = np.cumsum([0.0, *(math.hypot(step.x, step.y) for step in steps)])
    turn = np.cumsum([0.0, *(abs(step.theta) for step in steps)])
    found = []
    for window in WINDOWS:
        for i in range(0, len(truth) - window, max(window // 2, 1)):
            j = i + window
            error = relative(relative(truth[i], truth[j]), relative(odometry[i], odometry[j]))
            found.append(
                (window, way[j] - way[i], turn[j] - turn[i], error.x, error.y, error.theta)
            )
    return np.array(found)


if __name__ == "__main__":
    main()
