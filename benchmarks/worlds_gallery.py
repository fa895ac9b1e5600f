"""Draw one world of each random family for docs/simulation.md: worlds_gallery.py [FILE]."""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from laserfeatures import Pose2D
from laserfeatures.simulation import (
    Scanner,
    random_corridor,
    random_hallway,
    random_office,
    random_room,
)

PAGE = Path(__file__).parents[1] / "docs/worlds.png"
SCANNER = Scanner.model("lms200", outliers=0.02, beam_width=0.01)


def draw(axes, title, world, poses, path=None):
    """Draw a world, where a scanner stands in it, and what it sees from one of the places."""
    for ends in world.sides:
        axes.plot(*ends.T, color="black", linewidth=0.8)
    for x, y, radius in world.poles:
        axes.add_patch(plt.Circle((x, y), radius, color="black"))
    if path is not None:
        axes.plot(*path.T, color="tab:blue", linewidth=0.8)
    axes.plot([p.x for p in poses], [p.y for p in poses], ".", color="tab:blue")
    seen = SCANNER.observe(world, poses[len(poses) // 2], np.random.default_rng(1))
    points = seen.pose.transform(seen.scan.points)
    true = seen.surface[seen.scan.beams] >= 0
    axes.plot(*points[true].T, ".", color="tab:red", markersize=2.5)
    axes.plot(*points[~true].T, "x", color="tab:orange", markersize=5)
    axes.plot(seen.pose.x, seen.pose.y, "o", color="tab:red")
    axes.set_title(title, fontsize=10)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=8)


def main(path):
    figure, grid = plt.subplots(2, 2, figsize=(11, 8), layout="constrained")
    world, pose = random_room(14, poles=4)
    draw(grid[0, 0], "random_room(14, poles=4)", world, [pose])
    draw(grid[0, 1], "random_corridor(24)", *random_corridor(24))
    draw(grid[1, 0], "random_hallway(7)", *random_hallway(7))
    plan = random_office(2)
    way = plan.drive.waypoints
    headings = np.arctan2(*np.diff(way, axis=0).T[::-1])
    poses = [Pose2D(x, y, heading) for (x, y), heading in zip(way[:-1], headings, strict=True)]
    draw(grid[1, 1], "random_office(2), the drive in blue", plan.world, poses, way)
    figure.savefig(path, dpi=90)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else PAGE)
