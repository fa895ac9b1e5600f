"""A picture of a map. matplotlib is imported when one is made."""

import io

import numpy as np

from laserfeatures import figures
from laserfeatures.testbench.real.recordings import Drawing


def map_png(drawing: Drawing) -> bytes:
    """Return a map as PNG: the points of all scans, the walls, and the real corners.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    ends = drawing.walls.reshape(-1, 2)
    low, high = ends.min(axis=0) - 1, ends.max(axis=0) + 1
    width, height = 9.0 * (high - low) / (high - low).max()
    figure = figures.new_figure(max(width, 4.5) + 0.5, height + 1.0)
    axes = figure.subplots()
    inside = ((drawing.points > low) & (drawing.points < high)).all(axis=1)
    axes.plot(*drawing.points[inside].T, ",", color="0.6", label="points of all scans")
    broken = np.insert(drawing.walls, 2, np.nan, axis=1).reshape(-1, 2)
    axes.plot(*broken.T, color=figures.BLUE, linewidth=1.2, label="walls")
    axes.plot(
        *drawing.corners.T, "s", color=figures.RED, markersize=4, fillstyle="none",
        label="real corners that scans show",
    )  # fmt: skip
    figures.in_metres(axes, low, high)
    figures.draw_legend(figure, columns=3)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=110)
    return file.getvalue()
