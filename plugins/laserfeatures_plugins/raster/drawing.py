"""The image of a scan: its surfaces drawn as lines one pixel wide, blurred if wanted."""

import math
import threading
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.engine import kernel
from laserfeatures_plugins.raster.outline import Outline
from laserfeatures_plugins.raster.size import MAX_PIXELS, check_size

FRACTION = 4  # bits of a pixel's coordinates behind the point, as OpenCV's drawing takes them
INK = 255

Image = NDArray[np.uint8]
_thread = threading.local()  # OpenCV lets other threads run meanwhile: each has its own image


class Picture(NamedTuple):
    """An image, and where it lies: the centre of its first pixel is at (x, y) [m]."""

    image: Image
    x: float
    y: float
    resolution: float


class Blur(NamedTuple):
    """A Gaussian: its standard deviation [pixels], and what it grows by with range [m/m]."""

    width: float = 0.0
    growth: float = 0.0

    @property
    def ridge(self) -> float:
        """Brightness of the middle of a blurred line."""
        return INK / (self.width * math.sqrt(2.0 * math.pi)) if self.width else INK

    def check(self) -> None:
        """Check the parameters.

        Raises
        ------
        ValueError
            If one is out of its range.
        """
        if self.width != 0 and not 0.5 <= self.width <= 20:
            raise ValueError(f"blur must be 0 or in [0.5, 20] pixels, got {self.width!r}")
        if not 0 <= self.growth <= 1:
            raise ValueError(f"blur_growth must be in [0, 1] m/m, got {self.growth!r}")
        if self.growth and not self.width:
            raise ValueError(f"blur_growth {self.growth!r} needs a blur to grow from, got 0")


def draw(lines: Outline, resolution: float, blur: Blur, *, margin: int = 0) -> Picture | None:
    """Return a picture of some chains of returns, or None if there are none.

    It is to be used up before the same thread draws the next one.

    Parameters
    ----------
    resolution : float
        Side of a pixel [m].
    blur : Blur
        A straight line is as bright in its middle wherever it is and however wide its blur.
    margin : int
        Empty pixels around the drawing.

    Raises
    ------
    ValueError
        If it would have more than `MAX_PIXELS` pixels.
    """
    x, y, points, ends, _ = lines
    left, low, width, height, pixels = place(x, y, points, resolution, margin)
    check_size(width, height, resolution)
    if len(pixels) == 0:
        return None
    if blur.growth:
        sigma = blur.width + blur.growth * np.hypot(x[points], y[points]) / resolution
        image = _blurred_by_range(pixels, ends, sigma, blur.width, (int(height), int(width)))
    else:
        image = _blank(int(height), int(width))
        chains = [pixels[a:b] for a, b in pairwise(ends.tolist())]
        cv2.polylines(image, chains, False, INK, 1, cv2.LINE_8, FRACTION)
        if blur.width:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), blur.width), np.uint8)
    return Picture(image, left, low, resolution)


@kernel
def place(
    x: FloatArray, y: FloatArray, points: IntArray, resolution: float, margin: int
) -> tuple[float, float, float, float, NDArray[np.int32]]:
    """Return x, y [m], width and height [pixels] of the image that holds `points` and a margin.

    Also the points as OpenCV draws them: in pixels, with `FRACTION` bits behind the point; none
    where the image would be too large.
    """
    if points.size == 0:
        return 0.0, 0.0, 0.0, 0.0, np.empty((0, 2), np.int32)
    left = low = math.inf
    right = high = -math.inf
    for i in points:
        left = min(left, x[i])
        right = max(right, x[i])
        low = min(low, y[i])
        high = max(high, y[i])
    width = math.ceil((right - left) / resolution) + 1.0 + 2.0 * margin
    height = math.ceil((high - low) / resolution) + 1.0 + 2.0 * margin
    left -= margin * resolution
    low -= margin * resolution
    pixels = np.empty((points.size if width * height <= MAX_PIXELS else 0, 2), np.int32)
    scale = (1 << FRACTION) / resolution
    for k in range(pixels.shape[0]):
        pixels[k, 0] = int((x[points[k]] - left) * scale + 0.5)
        pixels[k, 1] = int((y[points[k]] - low) * scale + 0.5)
    return left, low, width, height, pixels


def _blank(height: int, width: int) -> Image:
    """Return an empty image in this thread's buffer, which grows and is reused."""
    size = width * height
    buffer: Image | None = getattr(_thread, "buffer", None)
    if buffer is None or buffer.size < size:
        buffer = _thread.buffer = np.empty(size, np.uint8)
    image = buffer[:size].reshape(height, width)
    image.fill(0)
    return image


def _blurred_by_range(
    pixels: NDArray[np.int32],
    ends: IntArray,
    sigma: FloatArray,
    least: float,
    shape: tuple[int, int],
) -> Image:
    """Return the image of the chains, each piece blurred by about the `sigma` of its first point.

    Pieces whose widths are within a factor of the square root of 2 are blurred together.
    """
    inside = np.ones(len(pixels), np.bool_)
    inside[ends[1:] - 1] = False  # no piece begins at the last point of a chain
    first = np.flatnonzero(inside)
    pieces = np.stack([pixels[first], pixels[first + 1]], axis=1)
    layer = np.round(2.0 * np.log2(sigma[first] / least))
    total = np.zeros(shape, np.float32)
    for number in np.unique(layer):
        mine = layer == number
        width = float(sigma[first][mine].mean())
        sheet = np.zeros(shape, np.float32)
        cv2.polylines(
            sheet, list(pieces[mine]), False, INK * width / least, 1, cv2.LINE_8, FRACTION
        )
        total += cv2.GaussianBlur(sheet, (0, 0), width)
    return np.asarray(cv2.convertScaleAbs(total), np.uint8)
