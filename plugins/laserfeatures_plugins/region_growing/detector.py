"""The extractor `region_growing`."""

from dataclasses import dataclass

from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.geometry.settle import check_gap, check_walls, line_segments
from laserfeatures_plugins.region_growing.growing import extract


@dataclass(frozen=True, kw_only=True)
class RegionGrowing:
    """Grow walls from neighbouring points along the scan, with running sums.

    Each point that is still free starts a wall with the next one; the points that follow join as
    long as they are near the line so far, whose parameters follow from running sums. Single beams
    that miss the line do not end it.

    Parameters
    ----------
    range_sigma : float or None
        Standard deviation of a range [m], from which the inlier bound and all covariances follow.
        None: estimated from each scan.
    min_points : int
        Points that a wall has at least.
    max_missed : int
        Successive beams that may miss a wall without an end to it.
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
    Gao et al. (2018), "A line segment extraction algorithm using laser data based on seeded region
    growing", for seeds and growth in scan order; the gate that widens with the line's uncertainty,
    and the skipped outliers, are this project's.
    """

    range_sigma: float | None = None
    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    object_gap: float = 0.15
    max_pole_radius: float = 0.4

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_walls(self)

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        check_gap(scan, self.max_gap)
        found = extract(
            scan.directions,
            scan.ranges,
            (scan.range_min, scan.range_max),
            self.range_sigma or 0.0,
            self.object_gap,
            self.max_pole_radius,
            (self.min_points, self.max_missed, self.max_gap),
        )
        return line_segments(found)
