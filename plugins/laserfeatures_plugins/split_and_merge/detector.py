"""The extractor `split_and_merge`."""

import math
from dataclasses import dataclass

from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.geometry.settle import check_gap, check_walls, line_segments
from laserfeatures_plugins.split_and_merge.splitting import extract


@dataclass(frozen=True, kw_only=True)
class SplitAndMerge:
    """Break the scan where it jumps, split the pieces at their corners, fit and merge.

    The pieces are split at the point farthest from the chord through their ends (iterative
    end-point fit) until a least-squares line explains each. Points that stick out alone are left
    out; collinear pieces become one line; the points at the corners go to the nearer wall.

    Parameters
    ----------
    range_sigma : float or None
        Standard deviation of a range [m], from which the inlier bound and all covariances follow.
        None: estimated from each scan.
    min_incidence : float
        Angle between beams and wall [rad] down to which successive returns count as one surface;
        a larger step is a break.
    min_points : int
        Points that a wall has at least.
    max_missed : int
        Successive beams that may miss a wall without a break.
    max_gap : float
        Way along a wall that beams may miss it without a gap in it [m].
    object_gap : float
        Successive returns farther apart than this are on different objects [m], when round ones
        are looked for.
    max_pole_radius : float
        Objects that look like part of a circle up to this radius are no walls [m]; 0 keeps them.

    Raises
    ------
    ValueError
        If a parameter is out of its range; at a scan, if `max_gap` is less than the way from beam
        to beam.

    References
    ----------
    Nguyen et al. (2007), "A comparison of line extraction algorithms using 2D range data for indoor
    mobile robotics", for the method; Borges and Aldon (2004), "Line extraction in 2D range images
    for mobile robotics", for the adaptive break points.
    """

    range_sigma: float | None = None
    min_incidence: float = math.radians(10.0)
    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    object_gap: float = 0.15
    max_pole_radius: float = 0.4

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_walls(self)
        if not 0 < self.min_incidence < math.pi / 2:
            raise ValueError(f"min_incidence must be in (0, pi/2) rad, got {self.min_incidence!r}")

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        check_gap(scan, self.max_gap)
        found = extract(
            scan.directions,
            scan.ranges,
            (scan.range_min, scan.range_max),
            self.range_sigma or 0.0,
            (math.cos(self.min_incidence), math.sin(self.min_incidence)),
            self.object_gap,
            self.max_pole_radius,
            (self.min_points, self.max_missed, self.max_gap),
        )
        return line_segments(found)
