"""Draw docs/extractor_*.png: two scans as each extractor sees them.

Run ``python benchmarks/gallery.py``; ``--data`` says where the recordings are (../shared/data),
``--docs`` where the pictures go. One scan is of a real log, the other of a simulated room with
false beams, whose walls are drawn dotted.
"""

import argparse
import math
from pathlib import Path

import numpy as np
import truth as truths
from page import new_figure
from rooms import plain_room

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.evaluation.truth import in_sensor_frame
from laserfeatures.simulation import Scanner

ROOT = Path(__file__).parents[1]
LOG, NUMBER = "sick/freiburg-101-corrected.log.gz", 100
SHOWN = np.array([[-1.0, -5.5], [13.0, 8.2]])  # [m], of the real scan
MARGIN = 0.5  # [m], around the simulated room
FALSE = Scanner(beams=361, field_of_view=math.radians(270), range_max=10.0, range_sigma=0.015)


def main():
    """Draw all pictures."""
    parser = argparse.ArgumentParser(description="Draw what each extractor finds in two scans.")
    parser.add_argument("--data", type=Path, default=ROOT / "../shared/data")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    arguments = parser.parse_args()
    with lf.open_source(arguments.data / LOG) as source:
        real = next(scan for number, scan in enumerate(source) if number == NUMBER)
    world, poses = plain_room()
    pose = poses[0]
    rng = np.random.default_rng(1)
    made, _ = truths.sense(world, FALSE, pose, rng, outliers=0.2, isolated=True)
    walls = in_sensor_frame(world.sides, pose)
    for name in lf.list_extractors():
        figure = picture(lf.get_extractor(name), real, made, walls)
        path = arguments.docs / f"extractor_{name}.png"
        figure.savefig(path, dpi=90)
        print(f"wrote {path}, {path.stat().st_size / 1e3:.0f} kB")


def picture(extractor, real, made, walls):
    """Return a figure of both scans and what is found in them."""
    figure = new_figure(10.0, 5.2)
    left, right = figure.subplots(1, 2)
    log = Path(LOG).name.removesuffix("-corrected.log.gz")
    draw(left, extractor, real, SHOWN, f"{log}, scan {NUMBER}")
    low, high = walls.min(axis=(0, 1)) - MARGIN, walls.max(axis=(0, 1)) + MARGIN
    for wall in walls:
        right.plot(*wall.T, ":", color="tab:green", linewidth=1.3, zorder=4)
    right.plot([], [], ":", color="tab:green", label="true walls", linewidth=1.3)
    draw(right, extractor, made, np.array([low, high]), "simulated, 15 mm noise, 20 % false beams")
    figures.draw_legend(figure, columns=4)
    return figure


def draw(axes, extractor, scan, limits, title):
    """Draw a scan and what is found in it."""
    features = extractor(scan)
    removed = figures.removed_lines(extractor, features)
    figures.draw_scan(axes, features, removed=removed, limits=limits)
    counts = f"{len(features.lines)} lines, {len(features.corners)} corners"
    axes.set_title(f"{title}:\n{counts}", fontsize="medium", loc="left")


if __name__ == "__main__":
    main()
