"""The demo's picture: the corners found over the plan, and some of the scans."""

from typing import TYPE_CHECKING

import numpy as np

from laserfeatures import figures
from laserfeatures.cli.tour import Visit
from laserfeatures.simulation import hallway

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from laserfeatures.pipeline import Pipeline

SHOWN = (1, 4, 6)  # scans that get a picture of their own
MARGIN = 1.2  # around the plan [m]


def demo_figure(extractor: "Pipeline", visits: list[Visit]) -> "Figure":
    """Return a picture of some scans, and of the corners of all over the plan."""
    figure = figures.new_figure(11.0, 11.0)
    plan, *below = figure.subplot_mosaic(
        [["plan"] * len(SHOWN), [str(index) for index in SHOWN]], height_ratios=[1.8, 1]
    ).values()
    _draw_plan(plan, visits)
    for axes, index in zip(below, SHOWN, strict=True):
        features = visits[index].features
        removed = figures.removed_lines(extractor, features)
        figures.draw_scan(axes, features, removed=removed)
        axes.set_title(f"scan {index}", fontsize="medium", loc="left")
    figures.draw_legend(figure, columns=5)
    return figure


def _draw_plan(axes: "Axes", visits: list[Visit]) -> None:
    world, _ = hallway()
    axes.plot(*world.walls.transpose(2, 1, 0), color="0.8", linewidth=5, solid_capstyle="round")
    corners = [visit.pose.transform(visit.truth.corners) for visit in visits]
    truth = np.unique(np.concatenate(corners).round(6), axis=0)
    axes.plot(
        *truth.T, "o", color="0.5", markersize=11, fillstyle="none", label="crossings of walls"
    )
    for index, visit in enumerate(visits):
        figures.draw_corners(axes, visit.features.corners, pose=visit.pose)
        figures.draw_sensor(axes, visit.pose)
        axes.annotate(
            str(index), (visit.pose.x, visit.pose.y), (0, -9), textcoords="offset points",
            ha="center", va="top", fontsize="small", color=figures.RED,
        )  # fmt: skip
    ends = world.walls.reshape(-1, 2)
    figures.in_metres(axes, ends.min(axis=0) - MARGIN, ends.max(axis=0) + MARGIN)
    axes.set_title("corners found from all poses, over the plan", fontsize="medium")
