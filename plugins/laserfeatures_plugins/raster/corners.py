"""`kanade_tomasi`: the minimum-eigenvalue corner detector on an image of the scan."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple, cast

import cv2
import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.data import LaserScan, PointFeatures
from laserfeatures.engine.explain import prepare
from laserfeatures.parameters import settle
from laserfeatures_plugins.raster.drawing import Blur, Image, Picture, draw
from laserfeatures_plugins.raster.outline import Outline, outline
from laserfeatures_plugins.raster.shape import WINDOW, distinct, structure, turns
from laserfeatures_plugins.raster.size import check_image
from laserfeatures_plugins.raster.uncertainty import covariances, edge_angles

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from laserfeatures.noise_model import RangeNoise

MARGIN = 12  # empty pixels around the drawing, for the blur, the ring and the window
BLOCK = 9  # pixels: side of the square whose gradients make a corner
MIN_DISTANCE = 5  # pixels between what answers
SAME = 8  # pixels within which two corners are one
STEPS = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)  # to the place of a corner


class Corners(NamedTuple):
    """Corners in one scale: places [m], covariances [m^2], angles [rad].

    Also the distance [m] within which another one is the same.
    """

    x: FloatArray
    y: FloatArray
    covariance: FloatArray
    angles: FloatArray
    reach: FloatArray


NONE = Corners(np.empty(0), np.empty(0), np.empty((0, 2, 2)), np.empty(0), np.empty(0))


@dataclass(frozen=True, kw_only=True)
class KanadeTomasi:
    """Draw the scan into an image and take the corners that OpenCV finds there.

    The returns of each surface are joined by lines, which are blurred. Where the gradients have two
    directions, the minimum-eigenvalue detector answers; the place is refined to parts of a pixel.
    It answers at the ends of lines too, where an object hides what is behind it: so at least two
    lines must leave a corner, and turn there. This must hold at two successive scales; the place is
    that of the finer one.

    Parameters
    ----------
    resolution : float
        Side of a pixel at the finest scale [m].
    scales : int
        Number of scales, each half as fine as the one before; at least 2.
    blur : float
        Standard deviation of the Gaussian that the images are blurred with [pixels].
    blur_growth : float
        Growth of that width with range [m/m].
    quality : float
        Least answer of a corner, as a share of the strongest one in the image.
    min_turn : float
        Lines that turn by less have no corner there [rad].
    keep_ends : bool
        Whether the ends of lines are kept too.
    min_incidence : float
        Returns are not joined where a surface between them would be met at less than this [rad].
    max_range : float
        What is farther away is not drawn [m].
    range_sigma : float or None
        Standard deviation of a range [m], from which the covariances follow. None: estimated from
        each scan, or told by a `NoiseModel`.
    max_missed : int
        Successive beams that may miss a surface without a gap in it.
    max_pole_radius : float
        Objects that look like part of a circle up to this radius are not drawn [m]; 0 draws them.

    Raises
    ------
    ValueError
        If a parameter is out of its range, or if the image could have, or at a scan has, more than
        64 million pixels.

    Notes
    -----
    All corners are real ones, and on no lines (-1, -1). Their angle is good to some degrees; one
    that is sharper than about 40 degrees looks like the end of a line. The covariance is the
    inverse of the structure tensor, scaled as `covariances` tells.

    References
    ----------
    Li and Olson (2010), "Extracting general-purpose features from LIDAR data", for the detector on
    images of scans. Shi and Tomasi (1994), "Good features to track", for the detector, which is
    `cv2.goodFeaturesToTrack`. Foerstner and Guelch (1987), "A fast operator for detection and
    precise location of distinct points, corners and centres of circular features", for the place,
    which is found by `cv2.cornerSubPix`, and its covariance.
    """

    resolution: float = 0.02
    scales: int = 2
    blur: float = 1.5
    blur_growth: float = 0.0
    quality: float = 0.05
    min_turn: float = math.radians(25.0)
    keep_ends: bool = False
    min_incidence: float = math.radians(5.0)
    max_range: float = 20.0
    range_sigma: float | None = None
    max_missed: int = 3
    max_pole_radius: float = 0.4

    def __post_init__(self) -> None:
        """Check the parameters."""
        settle(self)
        check_image(self.resolution, self.max_range, self.min_incidence)
        self._blur.check()
        if not self.blur:
            raise ValueError(f"blur must be in [0.5, 20] pixels, got {self.blur!r}")
        if not 2 <= self.scales <= 8:
            raise ValueError(f"scales must be in 2 .. 8, got {self.scales!r}")
        if not 0 < self.quality < 1:
            raise ValueError(f"quality must be in (0, 1), got {self.quality!r}")
        if not 0 < self.min_turn < math.pi / 2:
            raise ValueError(f"min_turn must be in (0, pi/2) rad, got {self.min_turn!r}")
        if self.range_sigma is not None and not 0 < self.range_sigma <= 1:
            raise ValueError(f"range_sigma must be in (0, 1] m, got {self.range_sigma!r}")
        for name in ("max_missed", "max_pole_radius"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} must be >= 0, got {getattr(self, name)!r}")

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> PointFeatures:
        """Return the corners of `scan`; `noise` is that of its ranges, where it is known."""
        sigma, relative = -1.0 if self.range_sigma is None else self.range_sigma, 0.0
        if noise is not None and self.range_sigma is None:
            sigma, relative = noise.sigma, noise.relative
        limits = (scan.range_min, scan.range_max)
        table, _ = prepare(
            scan.directions, scan.ranges, limits, scan.ring, sigma, relative, 0.0, 0.0
        )
        lines = outline(
            table,
            resolution=self.resolution,
            max_pole_radius=self.max_pole_radius,
            max_range=self.max_range,
            min_incidence=self.min_incidence,
            max_missed=self.max_missed,
        )
        pictures = [
            draw(lines, self.resolution * 2**scale, self._blur, margin=MARGIN)
            for scale in range(self.scales)
        ]
        found = [
            self._found(fine, coarse, lines)
            for fine, coarse in pairwise(pictures)
            if fine is not None and coarse is not None
        ]
        corners = Corners(*(np.concatenate(parts) for parts in zip(NONE, *found, strict=True)))
        keep = distinct(corners.x, corners.y, corners.reach)
        positions = np.stack([corners.x[keep], corners.y[keep]], axis=1)
        return PointFeatures(
            positions=positions,
            covariance=corners.covariance[keep],
            lines=np.full(positions.shape, -1),
            angles=corners.angles[keep],
            real=np.ones(len(positions), np.bool_),
        )

    def _found(self, fine: Picture, coarse: Picture, lines: Outline) -> Corners:
        """Return the corners of a picture that are in the coarser one too, strongest first."""
        u, v = self._answers(fine.image)
        x = fine.x + fine.resolution * u
        y = fine.y + fine.resolution * v
        turn = turns(fine.image, u, v, self._blur.ridge)
        u_coarse = (x - coarse.x) / coarse.resolution
        v_coarse = (y - coarse.y) / coarse.resolution
        keep = self._is_kept(turn) & self._is_kept(
            turns(coarse.image, u_coarse, v_coarse, self._blur.ridge)
        )
        x, y, turn = x[keep], y[keep], turn[keep]
        tensor = structure(fine.image, u[keep], v[keep])
        window = WINDOW * fine.resolution
        points = (np.hypot(lines.x - x[:, None], lines.y - y[:, None]) < window).sum(axis=1)
        return Corners(
            x,
            y,
            covariances(tensor, points, window, fine.resolution, lines.noise),
            np.where(turn < 0, edge_angles(tensor), np.minimum(turn, math.pi - turn)),
            np.full(x.size, SAME * fine.resolution),
        )

    def _answers(self, image: Image) -> tuple[FloatArray, FloatArray]:
        """Return column and row of what the detector answers to, strongest first."""
        found = cast(
            "NDArray[np.float32] | None",  # OpenCV's stubs forget None
            cv2.goodFeaturesToTrack(image, 0, self.quality, MIN_DISTANCE, blockSize=BLOCK),
        )
        if found is None:
            return np.empty(0), np.empty(0)
        start = np.asarray(found, np.float32).reshape(-1, 1, 2)
        refined = cv2.cornerSubPix(image, start, (WINDOW, WINDOW), (-1, -1), STEPS)
        u, v = np.asarray(refined, np.float64).reshape(-1, 2).T.copy()
        return u, v

    def _is_kept(self, turn: FloatArray) -> BoolArray:
        return (turn >= self.min_turn) | (self.keep_ends & (turn < 0))

    @cached_property
    def _blur(self) -> Blur:
        return Blur(self.blur, self.blur_growth)
