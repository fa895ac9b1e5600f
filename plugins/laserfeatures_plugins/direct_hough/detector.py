"""The default way to run the direct Hough transform."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan
from laserfeatures.engine import WallDetector
from laserfeatures_plugins.direct_hough.accumulator import (
    Accumulator,
    accumulate,
    check_steps,
    theta_rows,
)
from laserfeatures_plugins.direct_hough.paper import PaperHough
from laserfeatures_plugins.direct_hough.search import propose
from laserfeatures_plugins.direct_hough.voting import ROW


@dataclass(frozen=True, kw_only=True)
class DirectHough(WallDetector):
    """Find walls by a Hough transform on the points of a scan.

    Neighbouring points vote together for the lines through both. From each peak a line is grown
    along the scan and refitted; its points do not vote again, so that the walls that it hid come
    forward. The scan is then explained by these lines and what they leave (see `WallDetector`).

    Parameters
    ----------
    theta_step : float
        Angular resolution of the accumulator [rad].
    distance_step : float
        Distance resolution of the accumulator [m].
    pair_distance : float
        Distance of the points that vote together [m].

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
    pair_distance: float = 0.15

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        check_steps(self.theta_step, self.distance_step)
        if not 0 < self.pair_distance < math.inf:
            raise ValueError(f"pair_distance must be > 0 m, got {self.pair_distance!r}")

    def propose(self, table: FloatArray) -> FloatArray:
        """Return the lines grown from the peaks of the votes."""
        last = self.pair_distance, self.max_missed
        found: FloatArray = propose(table, *self._accumulator, *last)  # type: ignore[call-arg]
        return found

    def accumulator(self, scan: LaserScan) -> Accumulator:
        """Return the plain d-theta plane of `scan`, one vote per point and theta."""
        return accumulate(scan, self.theta_step, self.distance_step)

    @cached_property
    def _accumulator(self) -> tuple[Any, ...]:
        """What is the same for all scans.

        The kernel holds the interpreter lock, so threads may share it.
        """
        theta = theta_rows(self.theta_step)
        return (
            np.cos(theta),
            np.sin(theta),
            self.distance_step,
            np.zeros((theta.size, ROW), np.int32),
            np.zeros(1, np.int64),
        )
