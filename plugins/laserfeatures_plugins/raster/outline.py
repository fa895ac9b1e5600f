"""What is drawn of a scan: its surfaces, as chains of returns."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan
from laserfeatures.geometry import kernel
from laserfeatures.geometry.settle import free_points
from laserfeatures.geometry.walls import FREE
from laserfeatures_plugins.raster.surfaces import contours

Returns = tuple[FloatArray, FloatArray, IntArray, IntArray, float]  # x, y, beam, owner, noise
Chains = tuple[IntArray, IntArray]  # points, and where each chain of them begins and the last ends


def outline(
    scan: LaserScan,
    *,
    range_sigma: float | None,
    object_gap: float,
    max_pole_radius: float,
    max_range: float,
    min_incidence: float,
    max_missed: int,
) -> tuple[Returns, Chains]:
    """Return the returns of a scan and the chains of them that are to be drawn.

    The parameters are those of the extractors.
    """
    return surfaces_of(
        scan.directions,
        scan.ranges,
        (scan.range_min, scan.range_max),
        range_sigma or 0.0,
        object_gap,
        max_pole_radius,
        max_range,
        math.tan(min_incidence),
        max_missed,
    )


@kernel
def surfaces_of(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    jump: float,
    radius: float,
    max_range: float,
    slant: float,
    max_missed: int,
) -> tuple[Returns, Chains]:
    """Return the returns of a scan and the chains of each surface (see `contours`).

    Poles (see `free_points`) and what is farther away than `max_range` are on none.
    """
    x, y, beam, owner, noise = free_points(directions, ranges, limits, sigma, jump, radius)
    live = np.empty(x.size, np.int64)
    count = 0
    for i in range(x.size):
        if owner[i] == FREE and x[i] * x[i] + y[i] * y[i] <= max_range * max_range:
            live[count] = i
            count += 1
    return (x, y, beam, owner, noise), contours(x, y, beam, live[:count], slant, noise, max_missed)
