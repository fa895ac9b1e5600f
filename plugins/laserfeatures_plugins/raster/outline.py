"""What is drawn of a scan: its surfaces, as chains of returns."""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.engine import ZERO, kernel
from laserfeatures.engine.arcs import is_round
from laserfeatures.engine.sequence import as_sequence
from laserfeatures_plugins.raster.surfaces import BASELINE, contours


class Outline(NamedTuple):
    """Points x, y (P,) [m], chains ``points[ends[k] : ends[k + 1]]`` of them, the noise [m]."""

    x: FloatArray
    y: FloatArray
    points: IntArray
    ends: IntArray
    noise: float


def outline(
    table: FloatArray,
    *,
    resolution: float,
    max_pole_radius: float,
    max_range: float,
    min_incidence: float,
    max_missed: int,
) -> Outline:
    """Return the chains of a scan's points (see `engine.explain.prepare`) that are to be drawn.

    The parameters are those of the extractors.
    """
    points, ends, noise = surfaces_of(
        table,
        BASELINE * resolution,
        float(max_pole_radius),
        float(max_range),
        math.tan(min_incidence),
        int(max_missed),
    )
    return Outline(table[0], table[1], points, ends, noise)


@kernel
def surfaces_of(
    table: FloatArray,
    baseline: float,
    radius: float,
    max_range: float,
    slant: float,
    max_missed: int,
) -> tuple[IntArray, IntArray, float]:
    """Return the chains of each surface (see `contours`), and the noise [m].

    Round objects and what is farther away than `max_range` are on none.
    """
    points = as_sequence(table)
    n = points.x.size
    beam = np.empty(n, np.int64)
    live = np.empty(n, np.int64)
    count = 0
    start = ZERO
    noise = 0.0
    for end in range(1, n + 1):
        beam[end - 1] = int(points.beam[end - 1])
        noise += points.variance[end - 1]
        if end < n and points.jump[end] == 0.0:
            continue
        if radius == 0.0 or not is_round(points, start, end, radius):
            for i in range(start, end):
                if points.x[i] * points.x[i] + points.y[i] * points.y[i] <= max_range * max_range:
                    live[count] = i
                    count += 1
        start = end
    noise = math.sqrt(noise / max(n, 1))
    chains, ends = contours(
        points.x, points.y, beam, live[:count], slant, noise, baseline, max_missed
    )
    return chains, ends, noise
