"""The default way to run the direct Hough transform."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.geometry.settle import check_gap, check_walls, line_segments
from laserfeatures_plugins.direct_hough.accumulator import (
    Accumulator,
    accumulate,
    check_steps,
    theta_rows,
)
from laserfeatures_plugins.direct_hough.paper import PaperHough
from laserfeatures_plugins.direct_hough.search import extract
from laserfeatures_plugins.direct_hough.voting import ROW


@dataclass(frozen=True, kw_only=True)
class DirectHough:
    """Find walls by a Hough transform on the points of a scan, refitted to the noise bound.

    Neighbouring points vote together for the lines through both. The peaks are taken one by one:
    the wall is grown along the scan and refitted until it settles; its points do not vote again, so
    that the short walls that it hid come forward. Round objects are set aside, pieces of one wall
    are merged, and the points at corners go to the nearest wall.

    Parameters
    ----------
    theta_step : float
        Angular resolution of the accumulator [rad].
    distance_step : float
        Distance resolution of the accumulator [m].
    range_sigma : float or None
        Standard deviation of a range [m], from which the inlier bound and all covariances follow.
        None: estimated from each scan.
    min_points : int
        Points that a wall has at least.
    max_missed : int
        Successive beams that may miss a wall without a gap in it.
    max_gap : float
        Way along a wall that beams may miss it without a gap in it [m].
    pair_distance : float
        Distance of the points that vote together at first [m]; later they may be nearer.
    object_gap : float
        Successive returns farther apart than this are on different objects [m].
    max_pole_radius : float
        Objects that look like part of a circle up to this radius are no walls [m]; 0 keeps them.

    Raises
    ------
    ValueError
        If a parameter is out of its range; at a scan, if `max_gap` is less than the way from beam
        to beam.

    Notes
    -----
    ``preset="paper"`` is the paper's literal algorithm, `PaperHough`.

    References
    ----------
    The paper, section II, for the transform on raw points. Voting by pairs is the idea of Xu, Oja
    and Kultanen (1990); giving back the votes of what was found, of Gerig and Klein (1986).
    """

    presets: ClassVar[Mapping[str, Any]] = {"paper": PaperHough}

    theta_step: float = math.radians(1.0)
    distance_step: float = 0.02
    range_sigma: float | None = None
    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    pair_distance: float = 0.15
    object_gap: float = 0.15
    max_pole_radius: float = 0.4

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_steps(self.theta_step, self.distance_step)
        check_walls(self)
        if not 0 < self.pair_distance < math.inf:
            raise ValueError(f"pair_distance must be > 0 m, got {self.pair_distance!r}")

    def __call__(self, scan: LaserScan) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        check_gap(scan, self.max_gap)
        limits = (scan.range_min, scan.range_max)
        return line_segments(extract(scan.directions, scan.ranges, limits, *self._arguments))

    def accumulator(self, scan: LaserScan) -> Accumulator:
        """Return the plain d-theta plane of `scan`, one vote per point and theta."""
        return accumulate(scan, self.theta_step, self.distance_step)

    @cached_property
    def _arguments(self) -> tuple[Any, ...]:
        """The kernel's arguments that are the same for all scans, the accumulator among them.

        The kernel holds the interpreter lock, so threads may share the accumulator.
        """
        theta = theta_rows(self.theta_step)
        return (
            np.cos(theta),
            np.sin(theta),
            self.distance_step,
            np.zeros((theta.size, ROW), np.int32),
            np.zeros(1, np.int64),
            self.range_sigma or 0.0,
            self.pair_distance,
            self.object_gap,
            self.max_pole_radius,
            (self.min_points, self.max_missed, self.max_gap),
        )
