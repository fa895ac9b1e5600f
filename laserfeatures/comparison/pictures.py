"""The pictures of a comparison: time over beams, and one scan as each extractor sees it."""

import io
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures import figures
from laserfeatures.arrays import FloatArray
from laserfeatures.comparison.document import Picture
from laserfeatures.comparison.growth import Growth
from laserfeatures.data import LaserScan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from laserfeatures.pipeline import Pipeline

MARKERS = "osD^vP*X"  # so that the curves can be told without colours
SHOWN = 0.9  # of the returns lie inside the picture of a scan, along x and along y
NARROWEST = 0.6  # of a picture's sides
MARGIN = 0.1  # around it, of the longer side


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
        style = f"{MARKERS[number % len(MARKERS)]}-"
        axes.loglog(found.beams, 1e6 * seconds, style, color=f"C{number % 10}", label=name)
    axes.set_xticks(found.beams, [f"{count:g}" for count in found.beams])
    axes.minorticks_off()
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))  # labels within a decade too
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set(xlabel="beams", ylabel="median time [µs]")
    axes.grid(visible=True, alpha=0.3)
    long = max(map(len, found.seconds)) > 26  # characters, of which two do not fit abreast
    figures.draw_legend(figure, columns=1 if long else 2)
    alt = f"Median time over {found.beams[0]:g} to {found.beams[-1]:g} beams, log-log"
    return Picture("speed", "Median time over the number of beams", alt, _png(figure))


def scan_pictures(
    extractors: Mapping[str, "Pipeline"], scan: LaserScan, number: int
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

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    limits = _middle(scan)
    width, height = 4.4 * (limits[1] - limits[0]) / (limits[1] - limits[0]).max()
    pictures = []
    for position, (name, extractor) in enumerate(extractors.items(), 1):
        features = extractor(scan)
        figure = figures.new_figure(width + 0.8, height + 0.8)
        removed = figures.removed_lines(extractor, features)
        figures.draw_scan(figure.add_subplot(), features, removed=removed, limits=limits)
        lines, corners = len(features.lines), len(features.corners)
        counts = f"{lines} line{'s' * (lines != 1)}, {corners} corner{'s' * (corners != 1)}"
        alt = f"Scan {number} with what {name} finds in it: {counts}"
        file = f"scan-{position}-{re.sub(r'[^A-Za-z0-9]+', '_', name)}"
        pictures.append(Picture(file, f"{name}: {counts}", alt, _png(figure)))
    return pictures


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
