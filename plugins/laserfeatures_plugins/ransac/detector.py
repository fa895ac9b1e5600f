"""The extractor `ransac`."""

import math
from dataclasses import dataclass

from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.geometry.settle import check_gap, check_walls, line_segments
from laserfeatures_plugins.ransac.sampling import extract


@dataclass(frozen=True, kw_only=True)
class Ransac:
    """Draw two points, keep the line that explains the others best, refit, repeat.

    Sequential RANSAC: a line is scored by all points that no wall owns yet; the best is refitted
    to its inliers along the scan until they settle. Points of walls are not drawn again.

    Parameters
    ----------
    range_sigma : float or None
        Standard deviation of a range [m], from which the inlier bound and all covariances follow.
        None: estimated from each scan.
    window : int
        The second point of a sample is at most so many beams from the first; 0: anywhere.
    confidence : float
        Probability with which a sample free of outliers is drawn before a search for a wall ends.
    max_trials : int
        Samples drawn for one wall at the most.
    seed : int
        Of the random numbers; each scan starts from it anew.
    min_points : int
        Points that a wall has at least.
    max_missed : int
        Successive beams that may miss a wall without a gap in it.
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
        If a parameter is out of its range; at a scan, if `window` is wider than the scan or
        `max_gap` less than the way from beam to beam.

    References
    ----------
    Fischler and Bolles (1981), "Random sample consensus"; the score is the MSAC of Torr and
    Zisserman (2000), "MLESAC"; samples of near points follow Myatt et al. (2002), "NAPSAC".
    """

    range_sigma: float | None = None
    window: int = 12
    confidence: float = 0.99
    max_trials: int = 200
    seed: int = 0
    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    object_gap: float = 0.15
    max_pole_radius: float = 0.4

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_walls(self)
        if not 0 < self.confidence < 1:
            raise ValueError(f"confidence must be in (0, 1), got {self.confidence!r}")
        for name, least in (("window", 0), ("max_trials", 1), ("seed", 0)):
            if not getattr(self, name) >= least:
                raise ValueError(f"{name} must be >= {least}, got {getattr(self, name)!r}")
        if not (isinstance(self.seed, int) and self.seed < 2**63):
            raise ValueError(f"seed must be a whole number under 2**63, got {self.seed!r}")

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        check_gap(scan, self.max_gap)
        if self.window > len(scan) and self.window != Ransac.window:
            raise ValueError(f"window is {self.window} beams, the scan has only {len(scan)}")
        found = extract(
            scan.directions,
            scan.ranges,
            (scan.range_min, scan.range_max),
            self.range_sigma or 0.0,
            (self.window, math.log(1 - self.confidence), self.max_trials, self.seed),
            self.object_gap,
            self.max_pole_radius,
            (self.min_points, self.max_missed, self.max_gap),
        )
        return line_segments(found)
