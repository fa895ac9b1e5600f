"""What comes before and after every search for walls."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Lines, LineSegments
from laserfeatures.geometry.arcs import set_arcs_aside
from laserfeatures.geometry.compiled import helper
from laserfeatures.geometry.noise import estimate_sigma
from laserfeatures.geometry.points import returns
from laserfeatures.geometry.segments import MAX_GROWTH, Segments, cut_segments
from laserfeatures.geometry.sharing import merge_pieces, share_points
from laserfeatures.geometry.walls import FREE, ROUND, Cut, lines_of, members_of

Found = tuple[FloatArray, FloatArray, FloatArray, FloatArray, Segments]


def check_walls(
    range_sigma: float | None,
    min_points: int,
    max_missed: int,
    max_gap: float,
    max_pole_radius: float,
) -> None:
    """Check the parameters that all detectors of walls have.

    Raises
    ------
    ValueError
        If one is out of its range.
    """
    if range_sigma is not None and not 0 < range_sigma <= 1:
        raise ValueError(f"range_sigma must be in (0, 1] m, got {range_sigma!r}")
    if not min_points >= 3:
        raise ValueError(f"min_points must be >= 3, got {min_points!r}")
    if not max_missed >= 0:
        raise ValueError(f"max_missed must be >= 0, got {max_missed!r}")
    if not 0 < max_gap < math.inf:
        raise ValueError(f"max_gap must be > 0 m, got {max_gap!r}")
    if not max_pole_radius >= 0:
        raise ValueError(f"max_pole_radius must be >= 0 m, got {max_pole_radius!r}")


@helper
def free_points(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    jump: float,
    radius: float,
) -> tuple[FloatArray, FloatArray, IntArray, IntArray, float]:
    """Return x, y and beam of the returns, their owners, all free but for poles, and the noise.

    `sigma` 0 stands for unknown: it is estimated. `jump` is the distance of points on different
    objects, `radius` the largest of a round object; 0 keeps them.
    """
    x, y, beam = returns(directions, ranges, limits[0], limits[1])
    owner = np.empty(x.size, np.int64)
    for i in range(x.size):
        owner[i] = FREE
    if sigma == 0.0:
        sigma = estimate_sigma(x, y)
    if radius > 0.0:
        set_arcs_aside(x, y, beam, sigma, jump, radius, ROUND, owner)
    return x, y, beam, owner, sigma


@helper
def settle(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    beams: int,
    owner: IntArray,
    walls: FloatArray,
    sigma: float,
    cut: Cut,
) -> Found:
    """Merge the pieces of walls, share out the points at corners, cut the lines into segments."""
    merge_pieces(x, y, owner, walls, sigma)
    share_points(x, y, owner, walls, cut[0])
    theta, d, support, covariance = lines_of(walls, cut[0], sigma)
    line, member = members_of(owner, walls, cut[0])
    segments = cut_segments(x, y, beam, beams, theta, d, line, member, cut[1], cut[2], MAX_GROWTH)
    return theta, d, support, covariance, segments


def line_segments(found: Found) -> LineSegments:
    """Return what a kernel found as `LineSegments`."""
    theta, d, support, covariance, (line, endpoints, points_on, rms, points) = found
    return LineSegments.trusted(
        lines=Lines.trusted(theta=theta, d=d, support=support, covariance=covariance),
        line=line,
        endpoints=endpoints,
        support=points_on,
        rms=rms,
        points=points,
    )
