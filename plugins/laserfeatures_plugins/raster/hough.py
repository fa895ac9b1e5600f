"""`raster_hough`: OpenCV's Hough transform of an image of the scan."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import cv2
import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.engine import WallDetector
from laserfeatures.engine.detector import check_gap
from laserfeatures.engine.segments import line_segments
from laserfeatures_plugins.raster.drawing import Blur, Picture, draw
from laserfeatures_plugins.raster.outline import Outline, outline
from laserfeatures_plugins.raster.size import check_image
from laserfeatures_plugins.raster.walls import Lines, bins_on, propose

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

MAX_CELLS = 1 << 28  # of OpenCV's accumulator: 1 GB
WEIGHTED = (4, 11)  # version of OpenCV since which pixels vote as much as they are bright


@dataclass(frozen=True, kw_only=True)
class RasterHough(WallDetector):
    """Draw the scan into an image, run OpenCV's Hough transform on it, refit the lines it finds.

    The returns of each surface are joined by lines one pixel wide. What OpenCV finds is taken
    strongest first: a wall is grown along the scan from the points near the line and refitted; its
    points support no line after it, so that the repeats go. Round objects are not drawn. The scan
    is then explained by these lines and what they leave (see `WallDetector`).

    Parameters
    ----------
    resolution : float
        Side of a pixel, and distance resolution of the accumulator [m].
    theta_step : float
        Angular resolution of the accumulator [rad].
    min_votes : int
        Pixels on a line at least.
    refit : bool
        Whether walls are refitted to their points. False: lines are OpenCV's bins, less those that
        repeat another one.
    blur : float
        Standard deviation of a Gaussian that the image is blurred with [pixels]; 0: it is not. The
        pixels then vote as much as they are bright, for which OpenCV 4.11 or newer is needed.
    blur_growth : float
        Growth of that width with range [m/m].
    min_incidence : float
        Returns are not joined where a surface between them would be met at less than this [rad].
    max_range : float
        What is farther away is not drawn [m]; but it belongs to walls that come from nearer.

    Raises
    ------
    ValueError
        If a parameter is out of its range, or if the image could have, or at a scan has, more than
        64 million pixels; at a scan, if `max_gap` is less than the way from beam to beam.

    References
    ----------
    Li and Olson (2010), "Extracting general-purpose features from LIDAR data", for the image of a
    scan. Duda and Hart (1972) for the transform, which is `cv2.HoughLines`; the choice of the
    points to be joined starts from Borges and Aldon (2004).
    """

    resolution: float = 0.02
    theta_step: float = math.radians(1.0)
    min_votes: int = 6
    refit: bool = True
    blur: float = 0.0
    blur_growth: float = 0.0
    min_incidence: float = math.radians(5.0)
    max_range: float = 30.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        check_image(self.resolution, self.max_range, self.min_incidence)
        if not 1e-3 <= self.theta_step <= math.pi / 8:
            raise ValueError(f"theta_step must be in [0.001, pi/8] rad, got {self.theta_step!r}")
        if not self.min_votes >= 1:
            raise ValueError(f"min_votes must be >= 1, got {self.min_votes!r}")
        self._blur.check()
        version = tuple(int(part) for part in cv2.__version__.split(".")[:2])
        if self.blur and version < WEIGHTED:
            raise ValueError(f"blur needs OpenCV 4.11 or newer, this is {cv2.__version__}")

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        if self.refit:
            return super().__call__(scan, noise=noise)
        check_gap(scan, self.max_gap)
        table = self.prepared(scan, noise)
        drawn = self._outline(table)
        lines = self._lines(draw(drawn, self.resolution, self._blur))
        found = bins_on(table, len(scan), lines, self.resolution, drawn.noise, self._limits)
        return line_segments(found)

    def propose(self, table: FloatArray) -> FloatArray:
        """Return walls grown from the points near the lines that OpenCV finds."""
        drawn = self._outline(table)
        lines = self._lines(draw(drawn, self.resolution, self._blur))
        return propose(table, lines, self.resolution, drawn.noise, self._limits)

    def _outline(self, table: FloatArray) -> Outline:
        return outline(
            table,
            resolution=self.resolution,
            max_pole_radius=self.max_pole_radius,
            max_range=self.max_range,
            min_incidence=self.min_incidence,
            max_missed=self.max_missed,
        )

    def _lines(self, picture: Picture | None) -> Lines:
        """Return what OpenCV finds in a picture.

        Raises
        ------
        ValueError
            If its accumulator would be too large.
        """
        found = None
        origin = (0.0, 0.0)
        cos, sin = self._directions
        if picture is not None:
            origin = picture.x, picture.y
            cells = 2 * sum(picture.image.shape)
            if cos.size * cells > MAX_CELLS:
                raise ValueError(
                    f"the accumulator of {cos.size} x {cells} cells is too large: take a coarser "
                    "theta_step or resolution, or a smaller max_range"
                )
            step = math.pi / cos.size
            if self.blur:
                least = int(self.min_votes * self._blur.ridge)
                found = cv2.HoughLines(picture.image, 1.0, step, least, use_edgeval=True)
            else:
                found = cv2.HoughLines(picture.image, 1.0, step, self.min_votes - 1)
        lines = np.empty(0) if found is None else found
        return np.asarray(lines, np.float32).reshape(-1, 2), origin, cos, sin

    @cached_property
    def _blur(self) -> Blur:
        return Blur(self.blur, self.blur_growth)

    @cached_property
    def _directions(self) -> tuple[FloatArray, FloatArray]:
        """Cosines and sines of the rows of theta that divide half a turn."""
        rows = round(math.pi / self.theta_step)
        theta = np.arange(rows) * (math.pi / rows)
        return np.cos(theta), np.sin(theta)
