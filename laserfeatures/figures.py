"""Pictures of scans and what was found in them, in the manner of the paper's Figs. 6 and 7.

Raw points are black, kept lines blue, lines that the filter removed grey and dashed, segments
thick; corners are squares, filled where real and hollow where virtual; the sensor is a red
triangle. matplotlib is imported when a picture is made, and used without its global state.
"""

import math
from pathlib import PurePath
from typing import IO, TYPE_CHECKING, Any, Protocol

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features, LaserScan, Lines, PointFeatures, Pose2D
from laserfeatures.errors import LaserFeaturesError
from laserfeatures.optional import optional

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from laserfeatures.noise_model import RangeNoise
    from laserfeatures.pipeline import Pipeline

BLUE = "#0b4fa8"  # dark in grey print, where REMOVED stays light
RED = "#d62718"
REMOVED = "0.62"
DASHED = (0, (4, 3))
ELLIPSE_SCALE = math.sqrt(-2 * math.log(0.05))  # standard deviations of a 95 % ellipse
ELLIPSES = "95 % ellipse"  # in the legend
MARGIN = 0.15  # of the picture's size, around points and sensor
ORIGIN = Pose2D(0.0, 0.0, 0.0)


class Accumulator(Protocol):
    """The votes that a detector may show.

    Attributes
    ----------
    votes : (T, D) array
        Votes of each cell.
    theta : (T,) array
        Centre of each cell [rad].
    d : (D,) array
        Centre of each cell [m].
    """

    votes: FloatArray
    theta: FloatArray
    d: FloatArray


def new_figure(width: float = 7.0, height: float = 6.0) -> "Figure":
    """Return an empty figure of that size [inch].

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    library = optional("matplotlib.figure", "plotting needs matplotlib", "plots")
    figure: Figure = library.Figure(figsize=(width, height), layout="constrained")
    return figure


def picture_format(path: str) -> str:
    """Return the picture format that a file's ending names, such as "png".

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    ValueError
        If matplotlib writes no such format; the message says which ones it does.
    """
    known = new_figure().canvas.get_supported_filetypes()
    ending = PurePath(path).suffix.lower().removeprefix(".")
    if ending not in known:
        raise ValueError(f"a picture's name must end in one of .{', .'.join(known)}; got {path!r}")
    return ending


def save(figure: "Figure", file: IO[bytes], ending: str) -> None:
    """Write a figure to an open file in the format `ending`, as `picture_format` returns it."""
    figure.savefig(file, format=ending, dpi=160)


def scan_figure(
    features: Features,
    *,
    removed: FloatArray | None = None,
    accumulator: Accumulator | None = None,
    title: str = "",
) -> "Figure":
    """Return a picture of a scan and its features.

    Parameters
    ----------
    features : Features
        What was found in the scan.
    removed : (R, 2) array, optional
        (theta, d) [rad, m] of lines that the filter removed; see `removed_lines`.
    accumulator : Accumulator, optional
        The detector's votes, to be drawn beside the scan.
    title : str
        Text above the picture.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    removed = np.empty((0, 2)) if removed is None else removed
    low, high = _limits(features.scan.points)
    width, height = np.maximum(6.0 * (high - low) / (high - low).max(), (4.8, 2.0))
    figure = new_figure(width + 0.8 + (6.0 if accumulator else 0.0), height + 1.5)
    grid = figure.add_gridspec(1, 2, width_ratios=[width, 5.0 if accumulator else 0.01])
    draw_scan(figure.add_subplot(grid[0]), features, removed=removed)
    if accumulator:
        draw_accumulator(figure.add_subplot(grid[1]), accumulator, features.lines, removed)
    figure.suptitle(title, fontsize="medium")
    draw_legend(figure, columns=3)
    return figure


def accumulator_of(extractor: "Pipeline", scan: LaserScan) -> Accumulator:
    """Return the votes of an extractor's detector.

    Raises
    ------
    LaserFeaturesError
        If it has none.
    """
    method = getattr(extractor.detector, "accumulator", None)
    if not callable(method):
        raise LaserFeaturesError(f"extractor {extractor.name!r} has no accumulator to draw")
    votes: Accumulator = method(scan)
    return votes


def removed_lines(
    extractor: "Pipeline", features: Features, *, noise: "RangeNoise | None" = None
) -> FloatArray:
    """Return (theta, d) [rad, m] of the lines that the detector finds and the filter removes."""
    detected = extractor.detect(features.scan, noise=noise)
    if isinstance(detected, PointFeatures):
        return np.empty((0, 2))
    before = _parameters(detected.lines)
    after = _parameters(features.lines)
    survives = (before[:, None] == after[None]).all(axis=2).any(axis=1)
    return np.asarray(before[~survives])


def draw_scan(
    axes: "Axes", features: Features, *, removed: FloatArray, limits: FloatArray | None = None
) -> None:
    """Draw a scan and its features in the sensor's frame.

    Parameters
    ----------
    axes : Axes
        Where to draw.
    features : Features
        What was found in the scan.
    removed : (R, 2) array
        (theta, d) [rad, m] of lines that the filter removed.
    limits : (2, 2) array, optional
        Lowest and highest x and y to show [m], instead of all points.
    """
    points, corners = features.scan.points, features.corners
    low, high = _limits(points) if limits is None else limits
    _draw_lines(axes, removed, color=REMOVED, linestyle=DASHED, label="removed lines", zorder=1)
    _draw_lines(axes, _parameters(features.lines), color=BLUE, label="kept lines", zorder=2)
    if len(features.segments):  # else the legend would name what is not there
        _draw_segments(axes, features.segments.endpoints)
    axes.plot(*points.T, "k.", markersize=2.5, label="measured points", zorder=6)
    draw_corners(axes, corners)
    draw_sensor(axes, ORIGIN, label="sensor")
    inside = ((corners.positions >= low) & (corners.positions <= high)).all(axis=1)
    _draw_ellipses(axes, corners.positions[inside], corners.covariance[inside])
    outside = len(corners) - int(inside.sum())
    if outside:
        plural = "s" * (outside > 1)
        axes.set_title(f"{outside} corner{plural} outside", loc="right", fontsize="small")
    in_metres(axes, low, high)


def draw_corners(axes: "Axes", corners: PointFeatures, *, pose: Pose2D = ORIGIN) -> None:
    """Draw corners that were seen from `pose`: real ones filled, virtual ones hollow."""
    for real, face in ((True, BLUE), (False, "white")):
        chosen = corners.real == real
        if chosen.any():
            axes.plot(
                *pose.transform(corners.positions[chosen]).T,
                "s",
                markersize=5.5 if real else 5,
                markerfacecolor=face,
                markeredgecolor=BLUE,
                markeredgewidth=1.1,
                label=f"{'real' if real else 'virtual'} corners",
                zorder=7 if real else 5,
            )


def draw_sensor(axes: "Axes", pose: Pose2D, *, label: str = "") -> None:
    """Draw a red triangle that points where the sensor looks."""
    tip = -90 + math.degrees(pose.theta)  # the marker "3 sides at 0 degrees" points up
    axes.plot(
        pose.x, pose.y, marker=(3, 0, tip), color=RED, markersize=12, markeredgecolor="white",
        linestyle="none", label=label or "_", zorder=8,
    )  # fmt: skip


def draw_accumulator(
    axes: "Axes", accumulator: Accumulator, kept: Lines, removed: FloatArray
) -> None:
    """Draw the votes over theta [deg] and d [m], the lines found circled."""
    from matplotlib.colors import PowerNorm  # noqa: PLC0415 - as in new_figure

    votes, theta, d = accumulator.votes, np.degrees(accumulator.theta), accumulator.d
    shade = PowerNorm(0.5, 0, max(votes.max(initial=0), 1))  # single votes show beside hundreds
    image = axes.pcolormesh(
        theta, d, votes.T, norm=shade, cmap="Greys", shading="nearest", rasterized=True
    )
    voted = np.flatnonzero(votes.any(axis=0))
    if voted.size:
        low, high = d[voted[0]], d[voted[-1]]
        margin = 0.04 * (high - low) or 1.0  # so that no circle is cut
        axes.set_ylim(low - margin, high + margin)
    style: dict[str, Any] = {"marker": "o", "linestyle": "none", "fillstyle": "none"}
    axes.plot(np.degrees(removed[:, 0]), removed[:, 1], color=REMOVED, markersize=9, **style)
    axes.plot(
        np.degrees(kept.theta), kept.d, color=BLUE, markersize=12, markeredgewidth=1.6, **style
    )
    axes.set(xlabel="θ [deg]", ylabel="d [m]", xticks=range(0, 181, 30), xlim=(0, 180))
    axes.figure.colorbar(image, ax=axes, fraction=0.04, pad=0.02, label="votes")


def draw_legend(figure: "Figure", columns: int) -> None:
    """Say below the figure what stands for what, each thing once."""
    entries: dict[str, Artist] = {}
    for axes in figure.axes:
        handles, labels = axes.get_legend_handles_labels()
        entries |= zip(labels, handles, strict=True)
    place: dict[str, Any] = {"loc": "outside lower center", "fontsize": "small", "frameon": False}
    figure.legend(entries.values(), entries, ncols=columns, **place)


def in_metres(axes: "Axes", low: FloatArray, high: FloatArray) -> None:
    """Give axes equal scales in metres from corner `low` to corner `high`."""
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x [m]", ylabel="y [m]")
    axes.set_aspect("equal", adjustable="box")
    axes.tick_params(direction="in", top=True, right=True)


def _parameters(lines: Lines) -> FloatArray:
    return np.stack([lines.theta, lines.d], axis=1)


def _limits(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the picture's limits: a far corner must not shrink the scene."""
    scene = np.vstack([points, [(0.0, 0.0)]])
    low, high = scene.min(axis=0), scene.max(axis=0)
    margin = MARGIN * float((high - low).max()) or 1.0
    return low - margin, high + margin


def _draw_lines(axes: "Axes", parameters: FloatArray, **style: Any) -> None:
    for theta, d in parameters:
        normal = np.array([math.cos(theta), math.sin(theta)])
        foot = d * normal
        axes.axline(foot, foot + np.array([-normal[1], normal[0]]), linewidth=0.7, **style)
        style["label"] = "_"  # one entry in the legend


def _draw_segments(axes: "Axes", endpoints: FloatArray) -> None:
    from matplotlib.collections import LineCollection  # noqa: PLC0415 - as in new_figure

    axes.add_collection(
        LineCollection(
            list(endpoints), colors=BLUE, alpha=0.45, linewidths=5, label="segments", zorder=3
        )
    )


def _draw_ellipses(axes: "Axes", positions: FloatArray, covariances: FloatArray) -> None:
    from matplotlib.patches import Ellipse  # noqa: PLC0415 - as in new_figure

    known = np.isfinite(covariances).all(axis=(1, 2))
    if known.any():  # a ring in the legend, where a patch would be a box
        axes.plot([], [], "o", fillstyle="none", color=BLUE, markeredgewidth=0.6, label=ELLIPSES)
    for position, covariance in zip(positions[known], covariances[known], strict=True):
        variances, vectors = np.linalg.eigh(covariance)
        width, height = 2 * ELLIPSE_SCALE * np.sqrt(np.maximum(variances, 0.0))
        angle = math.degrees(math.atan2(vectors[1, 0], vectors[0, 0]))
        ellipse = Ellipse(tuple(position), width, height, angle=angle, fill=False, edgecolor=BLUE)
        ellipse.set(linewidth=0.6, zorder=5)
        axes.add_patch(ellipse)
