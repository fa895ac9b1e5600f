"""What comes between a true range and the one that a rangefinder shows.

References
----------
C. Ye and J. Borenstein, Characterization of a 2-D laser scanner for mobile robot obstacle
negotiation, ICRA 2002 (SICK LMS200: range, incidence, colour, mixed pixels).
L. Kneip, F. Tache, G. Caprari and R. Siegwart, Characterization of the compact Hokuyo URG-04LX 2D
laser range scanner, ICRA 2009 (the same for the URG-04LX).
S. Soudarissanane, R. Lindenbergh, M. Menenti and P. Teunissen, Scanning geometry: influencing
factor on the quality of terrestrial laser scanning points, ISPRS Journal 66, 2011 (incidence).
"""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.simulation.raycast import cast, cos_incidence
from laserfeatures.simulation.world import World

GRAZING = math.cos(math.radians(80.0))  # beyond 80 degrees the deviation grows no more
STEP = 0.01  # [m]; a smaller step inside a footprint leaves the beam on one surface
HALVINGS = 12  # find an edge to 1/4096 of half a footprint


def deviation(
    world: World,
    position: FloatArray,
    angles: FloatArray,
    hits: tuple[FloatArray, IntArray],
    *,
    relative_sigma: float,
    incidence_sigma: float,
    dark_sigma: float,
) -> FloatArray:
    """Return what range, incidence and colour add to each range's deviation [m], (N,).

    Parameters
    ----------
    world, position, angles
        As `cast` takes them.
    hits : tuple
        What `cast` returned.
    relative_sigma, incidence_sigma, dark_sigma : float
        As `Scanner` has them.
    """
    ranges, surface = hits
    hit = surface >= 0
    far = np.where(hit, ranges, 0.0) * relative_sigma
    cosine = np.maximum(cos_incidence(world, position, angles, surface), GRAZING)
    oblique = np.sqrt(1.0 - cosine**2) / cosine * incidence_sigma
    share = np.ones(angles.size)
    share[hit] = world.reflectivity_of_surface[surface[hit]]
    dark = (1.0 / share - 1.0) * dark_sigma
    total: FloatArray = np.hypot(np.hypot(far, oblique), dark)
    return total


def mixed_pixels(
    world: World,
    position: FloatArray,
    angles: FloatArray,
    hits: tuple[FloatArray, IntArray],
    beam_width: float,
) -> tuple[FloatArray, BoolArray]:
    """Return each range as the mean over its footprint [m], and whether that covers an edge.

    A beam whose footprint lies on one surface, on two that meet, or partly on none keeps its range.

    Parameters
    ----------
    world, position, angles
        As `cast` takes them.
    hits : tuple
        What `cast` returned: the middle of each footprint.
    beam_width : float
        Angle from one side of a footprint to the other [rad].
    """
    right, right_mixed = _half_footprint(world, position, angles, hits, -beam_width / 2)
    left, left_mixed = _half_footprint(world, position, angles, hits, beam_width / 2)
    mixed = right_mixed | left_mixed
    return np.where(mixed, (right + left) / 2, hits[0]), mixed


def _half_footprint(
    world: World,
    position: FloatArray,
    angles: FloatArray,
    hits: tuple[FloatArray, IntArray],
    side: float,
) -> tuple[FloatArray, BoolArray]:
    """Return the mean range from each footprint's middle to its `side` [rad], and where it jumps.

    The edge between the two surfaces is found by bisection.
    """
    ranges, surface = hits
    outer_range, outer_surface = cast(world, position, angles + side)
    at = np.flatnonzero((outer_surface != surface) & np.isfinite(outer_range) & (surface >= 0))
    inner, outer = np.zeros(at.size), np.full(at.size, side)
    before, behind = ranges[at], outer_range[at]
    for _ in range(HALVINGS):
        middle = (inner + outer) / 2
        middle_range, middle_surface = cast(world, position, angles[at] + middle)
        own = middle_surface == surface[at]
        inner, outer = np.where(own, middle, inner), np.where(own, outer, middle)
        before = np.where(own, middle_range, before)
        behind = np.where(own, behind, middle_range)
    jumps = np.isfinite(behind) & (abs(np.where(np.isfinite(behind), behind, 0) - before) > STEP)
    share = inner[jumps] / side
    mean, mixed = ranges.copy(), np.zeros(ranges.size, np.bool_)
    mean[at[jumps]] = share * before[jumps] + (1 - share) * behind[jumps]
    mixed[at[jumps]] = True
    return mean, mixed
