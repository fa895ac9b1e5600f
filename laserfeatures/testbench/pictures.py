"""The pictures of the testbench. matplotlib is imported when one is made."""

import io
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures import figures
from laserfeatures.arrays import FloatArray
from laserfeatures.testbench.measuring import ORACLE
from laserfeatures.testbench.neighborhoods import Panel
from laserfeatures.testbench.noise import AXES, PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

GREY = "0.55"
MARKERS = "osD^vP*X"  # so that the curves can be told without colours
MARGIN = 0.6  # [m], around points and true features
FARTHEST = 12.0  # [m]; a feature beyond would make all else too small
CURVES = {
    "tp_percent": "true positives [%]",
    "fp_percent": "false positives [%]",
    "median_error": "median error of corners [mm]",
}


def neighborhood_png(panels: Sequence[Panel]) -> bytes:
    """Return one scene at several sizes of the neighbourhood, in the colours of the paper.

    Black points are raw measurements, grey lines those that the filter removed, blue lines those
    that passed, grey circles all true features, blue squares those detected; the red triangle is
    the laser.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    low, high = _limits(panels[0])
    width, height = high - low
    size = min(4.4 / width, 5.5 / height)  # [inch] a metre
    figure = figures.new_figure(len(panels) * (width * size + 0.4), height * size + 1.2)
    for axes, panel in zip(figure.subplots(1, len(panels), sharey=True), panels, strict=True):
        draw_panel(axes, panel)
        figures.in_metres(axes, low, high)
        axes.label_outer()
    figures.draw_legend(figure, columns=6)
    return _png(figure)


def draw_panel(axes: "Axes", panel: Panel) -> None:
    """Draw one panel in the frame of the sensor."""
    lines = panel.features.lines
    _draw_lines(axes, panel.removed, color=GREY, linewidth=0.9, label="lines filtered out")
    passed = np.stack([lines.theta, lines.d], axis=1)
    _draw_lines(axes, passed, color=figures.BLUE, linewidth=1.4, label="lines that passed")
    axes.plot(*panel.features.scan.points.T, "k.", markersize=4, label="raw measurements")
    style: dict[str, Any] = {"linestyle": "none", "fillstyle": "none"}
    axes.plot(
        *panel.truth.corners.T, "o", color="0.4", markersize=11, markeredgewidth=1.6,
        label="true features", **style,
    )  # fmt: skip
    axes.plot(
        *panel.features.corners.positions.T, "s", color="#2458ff", markersize=6,
        markeredgewidth=1.6, label="features detected", **style,
    )  # fmt: skip
    figures.draw_sensor(axes, figures.ORIGIN, label="laser")
    counts = panel.counts
    axes.set_title(
        f"$\\Delta V_d$ = {panel.row.v_d}, $\\Delta V_\\theta$ = {panel.row.v_theta}: "
        f"{counts['features_matched']} of {counts['features_true']} features",
        fontsize="medium",
    )


def _draw_lines(axes: "Axes", parameters: FloatArray, **style: Any) -> None:
    for theta, d in parameters:
        normal = np.array([math.cos(theta), math.sin(theta)])
        axes.axline(d * normal, d * normal + (-normal[1], normal[0]), zorder=1, **style)
        style["label"] = "_"  # one entry in the legend


def _limits(panel: Panel) -> FloatArray:
    """Return lowest and highest x and y of the points, the laser and the true features [m]."""
    corners = panel.truth.corners
    near = corners[np.hypot(*corners.T) < FARTHEST]
    scene = np.vstack([panel.features.scan.points, near, [(0.0, 0.0)]])
    limits: FloatArray = np.stack([scene.min(axis=0) - MARGIN, scene.max(axis=0) + MARGIN])
    return limits


def noise_png(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the curves of true and false positives and errors over everything that was varied.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    figure = figures.new_figure(12.0, 10.5)
    grid = figure.subplots(len(CURVES), len(AXES), sharex="col", sharey="row")
    for line, (key, label) in zip(grid, CURVES.items(), strict=True):
        for axes, axis in zip(line, AXES, strict=True):
            chosen = [row for row in rows if row["axis"] == axis.name]
            _draw_curves(axes, chosen, key)
            axes.grid(visible=True, alpha=0.3)
            axes.set(xlabel=axis.label, ylabel=label)
            axes.label_outer()
        line[0].set_ylim(bottom=0)
    figures.draw_legend(figure, columns=4)
    return _png(figure)


def _draw_curves(axes: "Axes", rows: Sequence[Mapping[str, Any]], key: str) -> None:
    scale = 1e3 if key.endswith("error") else 1.0
    for number, name in enumerate(dict.fromkeys(row["extractor"] for row in rows)):
        own = [row for row in rows if row["extractor"] == name]
        values = [scale * row[key] for row in own]
        marker = MARKERS[number % len(MARKERS)]
        special = {ORACLE: ("k--", "oracle"), PAPER: ("k:", "the paper's literal algorithm")}
        form, label = special.get(name, (f"C{number}-", name))
        axes.plot(
            [row["value"] for row in own], values, form, marker=marker, markersize=5, label=label
        )


def _png(figure: "Figure") -> bytes:
    file = io.BytesIO()
    figures.save(figure, file, "png")
    return file.getvalue()
