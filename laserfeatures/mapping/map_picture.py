"""The map drawn over all scans at the estimated poses, with the ways that led through it."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures import figures
from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.mapping.run import Run
from laserfeatures.slam import Landmark

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = 120_000  # points, evenly out of all
INSIDE = 0.995  # of the points lie in the picture, as few beams through a window go far
SIGMAS = 3.0
SIDE = 9.0  # [inch], the longer one
NARROWEST = 0.5  # of the sides
WIDE = 7.5  # [inch], enough for a legend of one row
POINTS = "0.6"


def map_figure(run: Run, reference: FloatArray | None = None, title: str = "") -> "Figure":
    """Return a picture of a run's map, in its frame.

    Grey: the scans' points at the estimated poses. Blue: the way by SLAM. Black: by odometry, from
    the same start, and dashed the reference. Red: corners with their 3-sigma ellipses, and walls.

    Parameters
    ----------
    run : Run
        What SLAM made of the scans.
    reference : (R, 2+) array, optional
        x and y of the reference's way [m], in the frame of the map.
    title : str
        Text above the picture.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    points = placed_points(run)
    ways = [run.estimate.poses[:, :2], odometry_way(run)]
    if reference is not None:
        ways.append(np.asarray(reference)[:, :2])
    walls = [mark.ends for mark in run.map if mark.kind == "wall"]
    low, high = _limits(points, [*ways, *walls])
    width, height = SIDE * np.maximum((high - low) / (high - low).max(), NARROWEST)
    figure = figures.new_figure(width, height + 0.7)  # and the legend
    axes = figure.add_subplot()
    axes.plot(
        *points.T, ".", markersize=0.7, markeredgewidth=0, color=POINTS, zorder=1, rasterized=True
    )
    axes.plot([], [], ".", color=POINTS, label="scans at the poses by SLAM")  # a dot that one sees
    black: dict[str, Any] = {"color": "black", "linewidth": 0.8}
    axes.plot(*ways[1].T, **black, label="odometry", zorder=3)
    if reference is not None:
        axes.plot(*ways[2].T, **black, linestyle="--", label="reference", zorder=5)
    axes.plot(*ways[0].T, color=figures.BLUE, linewidth=1.4, label="SLAM", zorder=4)
    draw_landmarks(axes, run.map)
    figures.in_metres(axes, low, high)
    axes.set_title(title, fontsize="medium", loc="left")
    corners = [mark.values for mark in run.map if mark.kind == "corner"]
    outside = sum(not ((low <= place) & (place <= high)).all() for place in corners)
    if outside:  # one that is far away must not shrink the map
        plural = "s" * (outside > 1)
        axes.set_title(f"{outside} corner{plural} outside", loc="right", fontsize="small")
    figures.draw_legend(figure, columns=6 if width > WIDE else 3)
    return figure


def draw_landmarks(axes: "Axes", landmarks: Sequence[Landmark]) -> None:
    """Draw corners as dots with their 3-sigma ellipses, and walls as lines, in red."""
    from matplotlib.collections import (  # noqa: PLC0415 - as in figures.new_figure
        EllipseCollection,
        LineCollection,
    )

    corners = [mark for mark in landmarks if mark.kind == "corner"]
    walls = [mark.ends for mark in landmarks if mark.kind == "wall"]
    if walls:
        axes.add_collection(
            LineCollection(walls, colors=figures.RED, linewidths=0.8, label="walls", zorder=2)
        )
    if not corners:
        return
    places = np.array([mark.values for mark in corners])
    variances, vectors = np.linalg.eigh(np.array([mark.covariance for mark in corners]))
    wide = 2 * SIGMAS * np.sqrt(np.maximum(variances, 0.0))
    label = f"corners, {SIGMAS:g}σ"  # noqa: RUF001 - sigma
    axes.plot(*places.T, ".", color=figures.RED, markersize=2.5, label=label, zorder=7)
    axes.add_collection(
        EllipseCollection(
            wide[:, 0],
            wide[:, 1],
            np.degrees(np.arctan2(vectors[:, 1, 0], vectors[:, 0, 0])),
            units="xy",
            offsets=places,
            offset_transform=axes.transData,
            facecolors="none",
            edgecolors=figures.RED,
            linewidths=0.6,
            zorder=7,
        )
    )


def placed_points(run: Run, most: int = SHOWN) -> FloatArray:
    """Return points (P, 2) of all scans at the estimated poses [m], at most so many."""
    stride = max(math.ceil(sum(map(len, run.points)) / most), 1)
    placed = [np.empty((0, 2))]
    skip = 0
    for (x, y, theta), points in zip(run.estimate.poses.tolist(), run.points, strict=True):
        placed.append(Pose2D(x, y, theta).transform(points[skip::stride]))
        skip = (skip - len(points)) % stride
    return np.concatenate(placed)


def odometry_way(run: Run) -> FloatArray:
    """Return x and y (N, 2) [m] of the odometry, moved so that it starts as SLAM does."""
    first = Pose2D(*run.odometry.poses[0].tolist())
    start = Pose2D(*run.estimate.poses[0].tolist())
    back = Pose2D(0.0, 0.0, -first.theta)
    return start.transform(back.transform(run.odometry.poses[:, :2] - (first.x, first.y)))


def _limits(points: FloatArray, others: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return the picture's lowest and highest x and y [m]: all ways, nearly all points."""
    scene = [*others]
    if len(points):
        scene.append(np.quantile(points, [1 - INSIDE, INSIDE], axis=0))
    everything = np.concatenate(scene)
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = float((high - low).max()) or 1.0
    half = np.maximum((high - low) / 2, NARROWEST * size / 2) + 0.03 * size
    return (low + high) / 2 - half, (low + high) / 2 + half
