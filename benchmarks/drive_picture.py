"""Draw docs/robot.png: the drive of docs/office.toml, true and by odometry; print what slips.

Run ``python benchmarks/drive_picture.py``; ``--docs`` says where the plan is and the picture goes,
``--seeds N`` how many drives make a row of the table of docs/robot.md (20).
"""

import argparse
import math
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from page import new_figure, table

from laserfeatures.simulation import read_plan
from laserfeatures.simulation.robot import Robot, drive

ROOT = Path(__file__).parents[1]
FIRST_SEED = 100
PERFECT = {"radius_error": 0.0, "track_error": 0.0, "unevenness": 0.0, "friction": (0.8, 0.8)}
CAUSES = ["radius_error", "track_error", "unevenness", "friction"]
EVERY = 100  # scans, of which one is drawn


def main():
    """Draw and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    parser.add_argument("--seeds", type=int, default=20)
    options = parser.parse_args()
    plan = read_plan(options.docs / "office.toml")
    start = time.perf_counter()
    readings = list(drive(plan))
    seconds = time.perf_counter() - start
    picture(plan, readings).savefig(options.docs / "robot.png", dpi=110)
    length = np.linalg.norm(np.diff(plan.drive.waypoints, axis=0), axis=1).sum()
    lasted = readings[-1].scan.stamp
    print(f"{length:.1f} m, {len(readings)} scans, {lasted:.0f} s in {seconds:.2f} s: ", end="")
    print(f"{lasted / seconds:.0f} times real time")
    print(causes(plan, options.seeds))


def picture(plan, readings):
    """Draw the plan, the scans at their true poses and both paths."""
    figure = new_figure(9, 6.5)
    axes = figure.add_subplot(aspect="equal", xlabel="x [m]", ylabel="y [m]")
    for start, end in plan.world.sides:
        axes.plot(*np.transpose([start, end]), color="0.75", linewidth=4, solid_capstyle="round")
    angles = np.linspace(0, math.tau, 60)
    for x, y, radius in plan.world.poles:
        axes.fill(x + radius * np.cos(angles), y + radius * np.sin(angles), color="0.75")
    for reading in readings[::EVERY]:
        points = reading.observation.pose.transform(reading.scan.points)
        axes.plot(*points.T, ".", color="tab:red", markersize=1.5)
    for name, style in (("truth", "--"), ("odometry", "-")):
        poses = [getattr(reading, name) for reading in readings]
        axes.plot([p.x for p in poses], [p.y for p in poses], style, color="black", label=name)
    axes.plot([], [], ".", color="tab:red", label=f"every {EVERY}th scan, at its true pose")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.1), ncols=3, frameon=False)
    return figure


def causes(plan, seeds):
    """Return the table of how far odometry ends off, by cause."""
    robots = {"none": Robot(**PERFECT)}
    robots |= {f"`{c}`": Robot(**{**PERFECT, c: getattr(Robot(), c)}) for c in CAUSES}
    robots["all, the default"] = Robot()
    plan = replace(plan, drive=replace(plan.drive, scan_rate=1.0))
    rows = []
    for name, robot in robots.items():
        off = np.array([errors(plan, robot, FIRST_SEED + i) for i in range(seeds)])
        end, most, turned = np.median(off, axis=0)
        rows.append([name, f"{end:.2f}", f"{off[:, 0].max():.2f}", f"{most:.2f}", f"{turned:.1f}"])
    header = ["error", "end, median [m]", "end, worst [m]", "on the way, median [m]", "heading [°]"]
    return table(header, rows)


def errors(plan, robot, seed):
    """Return how far off odometry ends and is at most [m], and its last heading [degrees]."""
    readings = list(drive(replace(plan, drive=replace(plan.drive, seed=seed)), robot))
    off = [math.dist((r.odometry.x, r.odometry.y), (r.truth.x, r.truth.y)) for r in readings]
    last = readings[-1]
    turned = math.remainder(last.odometry.theta - last.truth.theta, math.tau)
    return off[-1], max(off), abs(math.degrees(turned))


if __name__ == "__main__":
    main()
