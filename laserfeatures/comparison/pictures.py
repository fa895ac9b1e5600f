"""The pictures of a comparison: corners by evidence, time over beams, one scan seen by each."""

import io
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures import figures
from laserfeatures.arrays import FloatArray
from laserfeatures.comparison.document import Picture
from laserfeatures.comparison.evidence import KINDS, Curve
from laserfeatures.comparison.growth import Growth
from laserfeatures.data import LaserScan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from laserfeatures.noise_model import RangeNoise
    from laserfeatures.pipeline import Pipeline

MARKERS = "osD^vP*X"  # so that the curves can be told without colours
SHOWN = 0.9  # of the returns lie inside the picture of a scan, along x and along y
NARROWEST = 0.6  # of a picture's sides
MARGIN = 0.1  # around it, of the longer side
LONG = 26  # characters of a name, of which two do not fit abreast


def evidence_picture(found: Mapping[str, Mapping[str, Curve]]) -> Picture:
    """Return the share of corners found again over corners a scan, real and virtual ones apart.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    figure = figures.new_figure(8.4, 4.2)
    for axes, kind in zip(figure.subplots(1, 2, sharey=True), KINDS, strict=True):
        for number, (name, curves) in enumerate(found.items()):
            curve = curves[kind]
            axes.plot(curve.corners, curve.shares, _style(number), color=_color(number), label=name)
        axes.set(xlabel=f"{kind} corners a scan", ylim=(-0.02, 1.02))
        axes.set_xlim(left=0.0)
        axes.grid(visible=True, alpha=0.3)
    figure.axes[0].set_ylabel("share found again")
    figures.draw_legend(figure, columns=2 if max(map(len, found), default=0) > LONG else 3)
    alt = "Share of the real and of the virtual corners found again, over corners a scan"
    return Picture("evidence", "Corners found again, by least evidence", alt, _png(figure))


def growth_picture(found: Growth) -> Picture:
    """Return the median time of each extractor over the number of beams, both logarithmic.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    figure = figures.new_figure(5.5, 4.2)
    from matplotlib.ticker import LogLocator  # noqa: PLC0415 - as in figures.new_figure

    axes = figure.add_subplot()
    for number, (name, seconds) in enumerate(found.seconds.items()):
        axes.loglog(found.beams, 1e6 * seconds, _style(number), color=_color(number), label=name)
    axes.set_xticks(found.beams, [f"{count:g}" for count in found.beams])
    axes.minorticks_off()
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))  # labels within a decade too
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set(xlabel="beams", ylabel="median time [µs]")
    axes.grid(visible=True, alpha=0.3)
    figures.draw_legend(figure, columns=1 if max(map(len, found.seconds), default=0) > LONG else 2)
    alt = f"Median time over {found.beams[0]:g} to {found.beams[-1]:g} beams, log-log"
    return Picture("speed", "Median time over the number of beams", alt, _png(figure))


def scan_pictures(
    extractors: Mapping[str, "Pipeline"],
    scan: LaserScan,
    number: int,
    *,
    noise: "RangeNoise | None" = None,
) -> list[Picture]:
    """Return one picture for each extractor of what it finds in a scan.

    Parameters
    ----------
    extractors : mapping of str to Pipeline
        From a name to an extractor.
    scan : LaserScan
        The scan.
    number : int
        Its number in the log.
    noise : RangeNoise, optional
        The noise of its ranges, if the extractors are to be told.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    limits = _middle(scan)
    width, height = 4.4 * (limits[1] - limits[0]) / (limits[1] - limits[0]).max()
    pictures = []
    for position, (name, extractor) in enumerate(extractors.items(), 1):
        features = extractor(scan, noise=noise)
        figure = figures.new_figure(width + 0.8, height + 0.8)
        removed = figures.removed_lines(extractor, features, noise=noise)
        figures.draw_scan(figure.add_subplot(), features, removed=removed, limits=limits)
        lines, corners = len(features.lines), len(features.corners)
        counts = f"{lines} line{'s' * (lines != 1)}, {corners} corner{'s' * (corners != 1)}"
        alt = f"Scan {number} with what {name} finds in it: {counts}"
        file = f"scan-{position}-{re.sub(r'[^A-Za-z0-9]+', '_', name)}"
        pictures.append(Picture(file, f"{name}: {counts}", alt, _png(figure)))
    return pictures


def _style(number: int) -> str:
    return f"{MARKERS[number % len(MARKERS)]}-"


def _color(number: int) -> str:
    return f"C{number % 10}"


def _middle(scan: LaserScan) -> FloatArray:
    """Return lowest and highest x and y [m] of sensor and most returns, never a mere strip.

    A glance down a corridor or through a window would make all else too small to be seen.
    """
    scene = np.zeros((2, 2))
    if len(scan.points):
        scene = np.quantile(scan.points, [(1 - SHOWN) / 2, (1 + SHOWN) / 2], axis=0)
    low, high = np.minimum(scene[0], 0.0), np.maximum(scene[1], 0.0)
    size = float((high - low).max()) or 1.0
    half = np.maximum((high - low) / 2, NARROWEST * size / 2) + MARGIN * size
    limits: FloatArray = (low + high) / 2 + np.stack([-half, half])
    return limits


def _png(figure: "Figure") -> bytes:
    file = io.BytesIO()
    figures.save(figure, file, "png")
    return file.getvalue()
