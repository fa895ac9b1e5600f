"""A scanner that casts rays against a floor plan."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.registry import near_names
from laserfeatures.scan import LaserScan, Pose2D
from laserfeatures.simulation.noise import deviation, mixed_pixels
from laserfeatures.simulation.observation import Observation
from laserfeatures.simulation.raycast import cast
from laserfeatures.simulation.world import World

OUTLIERS = (0.3, 10.0)  # [m]; where an outlier may show, if the scanner sees that far


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """A laser rangefinder in a simulated world.

    The defaults are the SICK LMS200 as the paper simulates it (its section III.A). Whatever is 0 is
    off. The deviation of a range r that meets a surface at the angle a off its normal and of which
    the share s comes back is the root of ``range_sigma^2 + (relative_sigma r)^2 +
    (incidence_sigma tan a)^2 + (dark_sigma (1/s - 1))^2``, with a at most 80 degrees.

    Parameters
    ----------
    beams : int
        Number of beams.
    field_of_view : float
        From the first to the last beam [rad], centred on the sensor's x axis.
    range_max : float
        Range of view [m].
    range_sigma : float
        Standard deviation of a range [m].
    range_min : float
        What is nearer gives no return [m].
    relative_sigma : float
        Deviation that grows with the range, as a share of it.
    incidence_sigma : float
        Deviation on a surface met at 45 degrees [m].
    dark_sigma : float
        Deviation on a surface that reflects half of the light [m].
    dropouts : float
        Probability that a beam gives no return.
    outliers : float
        Probability that a beam shows a range anywhere from 0.3 m to 10 m, within the limits.
    beam_width : float
        Angle that a beam covers [rad]; where it falls on two surfaces, the range is the mean.
    resolution : float
        Step of the ranges [m].

    Raises
    ------
    ValueError
        If a parameter makes no sense.
    """

    MODELS: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        # The paper's sections III.A and III.B. That the second prints 0.33 degrees is a slip: the
        # sensor makes 1024 steps a turn, 0.36 degrees. As many as fit into 240 degrees: 667 beams.
        "lms200": {},
        "urg04lx_ug01": {
            "beams": 667,
            "field_of_view": math.radians(666 * 0.36),
            "range_max": 4.0,
        },
    }

    beams: int = 181
    field_of_view: float = math.pi
    range_max: float = 10.0
    range_sigma: float = 0.005
    range_min: float = 0.0
    relative_sigma: float = 0.0
    incidence_sigma: float = 0.0
    dark_sigma: float = 0.0
    dropouts: float = 0.0
    outliers: float = 0.0
    beam_width: float = 0.0
    resolution: float = 0.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        if self.beams < 2:
            raise ValueError(f"beams must be >= 2, got {self.beams}")
        if not 0 < self.field_of_view <= 2 * math.pi:
            raise ValueError(f"field_of_view must be in (0, 2 pi] rad, got {self.field_of_view}")
        if not self.range_max > 0:
            raise ValueError(f"range_max must be > 0 m, got {self.range_max}")
        if not 0 <= self.range_min < self.range_max:
            raise ValueError(
                f"range_min must be >= 0 m and less than range_max, got {self.range_min}"
            )
        for name in ("range_sigma", "incidence_sigma", "dark_sigma", "resolution"):
            if not 0 <= getattr(self, name) < math.inf:
                raise ValueError(f"{name} must be >= 0 m, got {getattr(self, name)}")
        if not 0 <= self.relative_sigma < math.inf:
            raise ValueError(f"relative_sigma must be >= 0, got {self.relative_sigma}")
        if not 0 <= self.beam_width < math.pi:
            raise ValueError(f"beam_width must be in [0, pi) rad, got {self.beam_width}")
        for name in ("dropouts", "outliers"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must be in [0, 1], got {getattr(self, name)}")
        low, high = self._outlier_range
        if self.outliers and not low < high:
            raise ValueError(
                f"outliers need a range of view beyond {low} m, got range_max = {self.range_max}"
            )

    @classmethod
    def model(cls, name: str, **changes: Any) -> Self:
        """Return the scanner `name` of `MODELS`, with some parameters changed.

        Raises
        ------
        ValueError
            If there is no such model; the message names the near ones.
        TypeError
            If there is no such parameter.

        Examples
        --------
        >>> Scanner.model("urg04lx_ug01", range_sigma=0.01).beams
        667
        """
        if name not in cls.MODELS:
            raise ValueError(f"there is no scanner {name!r}; {near_names(name, cls.MODELS)}")
        return cls(**{**cls.MODELS[name], **changes})

    @property
    def angles(self) -> FloatArray:
        """Direction of each beam [rad], (N,)."""
        half = self.field_of_view / 2
        return np.linspace(-half, half, self.beams)

    @property
    def _outlier_range(self) -> tuple[float, float]:
        return max(OUTLIERS[0], self.range_min), min(OUTLIERS[1], self.range_max)

    def cast(self, world: World, pose: Pose2D) -> tuple[FloatArray, IntArray]:
        """Return the true range of each beam [m] (inf where none) and the surface it hits (or -1).

        Surfaces are numbered as `World` counts them.

        Raises
        ------
        ValueError
            If the sensor is inside a box or pole, or within 1 mm of a surface.
        """
        world.check_pose(pose)
        return cast(world, np.array((pose.x, pose.y)), self.angles + pose.theta)

    def observe(
        self, world: World, pose: Pose2D, rng: np.random.Generator, *, stamp: float = math.nan
    ) -> Observation:
        """Return one noisy scan of `world` from `pose` and what is true of it.

        All randomness comes from `rng`; each effect has numbers of its own, so that switching one
        on leaves the others as they were.

        Raises
        ------
        ValueError
            If the sensor is inside a box or pole, or within 1 mm of a surface.
        """
        ranges, surface = self._blur(world, pose, rng)
        if self.dropouts or self.outliers:
            # From a child, so that the noise of later scans stays what it is without these effects.
            lost, false, where = rng.spawn(1)[0].random((3, self.beams))
            low, high = self._outlier_range
            outlier, dropout = false < self.outliers, lost < self.dropouts
            ranges = np.where(outlier, low + (high - low) * where, ranges)
            ranges[dropout] = math.inf
            surface[outlier | dropout] = -1
        if self.resolution:
            ranges = np.round(ranges / self.resolution) * self.resolution
        scan = LaserScan(
            angles=self.angles,
            ranges=ranges,
            range_min=self.range_min,
            range_max=self.range_max,
            stamp=stamp,
            pose=pose,
        )
        return Observation(
            scan=scan, world=world, pose=pose, surface=np.where(scan.valid, surface, -1)
        )

    def scan(
        self, world: World, pose: Pose2D, rng: np.random.Generator, *, stamp: float = math.nan
    ) -> LaserScan:
        """Return one noisy scan of `world` from `pose`; all randomness comes from `rng`."""
        return self.observe(world, pose, rng, stamp=stamp).scan

    def _blur(
        self, world: World, pose: Pose2D, rng: np.random.Generator
    ) -> tuple[FloatArray, IntArray]:
        """Return the ranges with noise and mixed pixels [m], and the surfaces that they show."""
        hits = ranges, surface = self.cast(world, pose)
        position, angles = np.array((pose.x, pose.y)), self.angles + pose.theta
        sigma: float | FloatArray = self.range_sigma
        if self.relative_sigma or self.incidence_sigma or self.dark_sigma:
            more = deviation(
                world,
                position,
                angles,
                hits,
                relative_sigma=self.relative_sigma,
                incidence_sigma=self.incidence_sigma,
                dark_sigma=self.dark_sigma,
            )
            sigma = np.hypot(sigma, more)
        noise = rng.normal(0.0, sigma, self.beams)
        if self.beam_width:
            mixed: BoolArray
            ranges, mixed = mixed_pixels(world, position, angles, hits, self.beam_width)
            surface = np.where(mixed, -1, surface)
        return ranges + noise, surface
