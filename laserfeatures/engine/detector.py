"""What all detectors of walls are: parameters, a proposal, and the stage that explains the rest."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.engine.explain import explain, prepare
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.segments import line_segments
from laserfeatures.parameters import settle

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

ALWAYS_WIDE = 0.1  # [m]; beams of a laser scanner are never that far apart at 1 m
NOTHING = np.empty((COLUMNS, 0))


@dataclass(frozen=True, kw_only=True)
class WallDetector:
    """Find walls: propose lines, and explain the scan by them.

    A detector of its own overrides `propose`.

    Parameters
    ----------
    range_sigma : float or None
        Standard deviation of a range [m]. None: estimated from each scan, with what
        follows, or told by a `NoiseModel`.
    range_sigma_relative : float or None
        What that grows by with the range, as a share of it; both add up as squares. None: 0 where
        `range_sigma` is given.
    roughness : float or None
        Standard deviation of walls from planes [m]. None: what a `NoiseModel` or the scan tells,
        as well as how alike the errors of neighbouring ranges are; given, they are independent.
    min_points : int
        Points that a wall has at least.
    max_missed : int
        Successive beams that may miss a wall without a gap in it.
    max_gap : float
        Way along a wall that beams may miss it without a gap in it [m].
    max_pole_radius : float
        Objects that look like part of a circle up to this radius are no walls [m]; 0 keeps them.

    Raises
    ------
    ValueError
        If a parameter is of another type or out of its range; at a scan, if `max_gap` is less than
        the way from beam to beam.
    """

    range_sigma: float | None = None
    range_sigma_relative: float | None = None
    roughness: float | None = None
    rounds: ClassVar[int] = 1
    longest: ClassVar[int] = 48

    min_points: int = 4
    max_missed: int = 3
    max_gap: float = 0.25
    max_pole_radius: float = 1.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        settle(self)
        sigma, relative = self.range_sigma, self.range_sigma_relative
        if sigma is not None and not 0 < sigma <= 1:
            raise ValueError(f"range_sigma must be in (0, 1] m, got {sigma!r}")
        if relative is not None:
            if not 0 <= relative < 1:
                raise ValueError(f"range_sigma_relative must be in [0, 1), got {relative!r}")
            if sigma is None:
                raise ValueError(
                    f"range_sigma_relative {relative!r} needs a range_sigma beside it, got None: "
                    "give both, or none and they are estimated"
                )
        if self.roughness is not None and not 0 <= self.roughness <= 1:
            raise ValueError(f"roughness must be in [0, 1] m, got {self.roughness!r}")
        if not self.min_points >= 3:
            raise ValueError(f"min_points must be >= 3, got {self.min_points!r}")
        if not self.max_missed >= 0:
            raise ValueError(f"max_missed must be >= 0, got {self.max_missed!r}")
        if not 0 < self.max_gap < math.inf:
            raise ValueError(f"max_gap must be > 0 m, got {self.max_gap!r}")
        if not self.max_pole_radius >= 0:
            raise ValueError(f"max_pole_radius must be >= 0 m, got {self.max_pole_radius!r}")

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each.

        `noise` is that of its ranges, where it is known (see `NoiseModel`); parameters count more.
        """
        check_gap(scan, self.max_gap)
        table = self.prepared(scan, noise)
        # 3. Propose lines.
        lines = self.propose(table)
        found = explain(table, lines, scan.ring, len(scan), self._limits, self.rounds)
        return line_segments(found)

    def prepared(self, scan: LaserScan, noise: "RangeNoise | None" = None) -> FloatArray:
        """Return the table of the returns of `scan` (see `Sequence`)."""
        sigma, relative, roughness, correlation = self._noise
        if noise is not None and self.range_sigma is None:
            sigma, relative = noise.sigma, noise.relative
            if self.roughness is None:
                roughness, correlation = noise.roughness, noise.correlation
        limits = (scan.range_min, scan.range_max)
        told = (sigma, relative, roughness, correlation)
        return prepare(scan.directions, scan.ranges, limits, scan.ring, *told)[0]

    def propose(self, table: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the lines to explain a scan by, (COLUMNS, K); none: all are looked for."""
        return NOTHING

    @cached_property
    def _noise(self) -> tuple[float, float, float, float]:
        sigma = -1.0 if self.range_sigma is None else self.range_sigma
        correlation = -1.0 if self.roughness is None else 0.0
        return sigma, self.range_sigma_relative or 0.0, self.roughness or 0.0, correlation

    @cached_property
    def _limits(self) -> tuple[int, int, float, float, int, bool]:
        """`Limits` as a plain tuple, which numba takes fast."""
        return (
            self.min_points, self.max_missed, self.max_gap, self.max_pole_radius,
            self.longest, self.roughness is not None,
        )  # fmt: skip


def check_gap(scan: LaserScan, max_gap: float) -> None:
    """Check that the beams of a scan are not farther apart than a gap may be.

    Raises
    ------
    ValueError
        If beside the nearest return, or at 1 m if that is nearer, they are.
    """
    if max_gap >= ALWAYS_WIDE or len(scan) < 2:
        return
    step = float(np.diff(scan.angles).min())
    nearest = min(1.0, float(scan.ranges[scan.beams].min(initial=math.inf)))
    if max_gap < step * nearest:
        raise ValueError(
            f"max_gap is {max_gap} m, but beams {math.degrees(step):.3g} deg apart are "
            f"{step * nearest:.4f} m apart at {nearest:.2f} m: every step would be a gap"
        )
