"""The default way to run the direct Hough transform."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from laserfeatures.data import LaserScan, Lines, LineSegments
from laserfeatures_plugins.direct_hough.search import extract
from laserfeatures_plugins.direct_hough.voting import ROW


@dataclass(frozen=True, kw_only=True)
class DirectHough:
    """Find walls."""

    theta_step: float = math.radians(1.0)
    distance_step: float = 0.02
    range_sigma: float | None = None
    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    pair_distance: float = 0.15
    jump: float = 0.15
    max_pole_radius: float = 0.4

    @cached_property
    def _workspace(self):
        rows = round(math.pi / self.theta_step)
        theta = np.arange(rows) * (math.pi / rows)
        return (np.cos(theta), np.sin(theta), self.distance_step, np.zeros((rows, ROW), np.int32), np.zeros(1, np.int64),
            self.range_sigma or 0.0, self.pair_distance, self.jump, self.max_pole_radius, (self.min_points, self.max_missed, self.max_gap))

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the line segments in `scan`."""
        theta, d, support, covariance, segments = extract(
            scan.directions, scan.ranges, (scan.range_min, scan.range_max), *self._workspace)
        line, endpoints, points_on, rms, points = segments
        return LineSegments.trusted(
            lines=Lines.trusted(theta=theta, d=d, support=support, covariance=covariance),
            line=line, endpoints=endpoints, support=points_on, rms=rms, points=points)
