"""A scanner that casts rays against a floor plan."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.simulation.observation import Observation
from laserfeatures.simulation.world import World


@dataclass(frozen=True, kw_only=True)
class Scanner:
    """A laser rangefinder in a simulated world.

    The defaults are the SICK LMS200 as the paper simulates it (its section III.A).

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
    """

    beams: int = 181
    field_of_view: float = math.pi
    range_max: float = 10.0
    range_sigma: float = 0.005

    def __post_init__(self) -> None:
        """Check the parameters."""
        if self.beams < 2:
            raise ValueError(f"beams must be >= 2, got {self.beams}")
        if not 0 < self.field_of_view <= 2 * math.pi:
            raise ValueError(f"field_of_view must be in (0, 2 pi] rad, got {self.field_of_view}")
        if not self.range_max > 0:
            raise ValueError(f"range_max must be > 0 m, got {self.range_max}")
        if not self.range_sigma >= 0:
            raise ValueError(f"range_sigma must be >= 0 m, got {self.range_sigma}")

    @property
    def angles(self) -> FloatArray:
        """Direction of each beam [rad], (N,)."""
        half = self.field_of_view / 2
        return np.linspace(-half, half, self.beams)

    def cast(self, world: World, pose: Pose2D) -> tuple[FloatArray, IntArray]:
        """Return the true range of each beam [m] (inf where none) and the surface it hits (or -1).

        Surfaces are numbered as `World` counts them.
        """
        angles = self.angles + pose.theta
        direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        position = np.array((pose.x, pose.y))
        ranges = np.concatenate(
            [
                _to_sides(world.sides - position, direction),
                _to_poles(world.poles - (*position, 0.0), direction),
                np.full((self.beams, 1), math.inf),
            ],
            axis=1,
        )
        surface = np.argmin(ranges, axis=1)
        nearest = ranges[np.arange(self.beams), surface]
        return nearest, np.where(np.isfinite(nearest), surface, -1)

    def observe(
        self, world: World, pose: Pose2D, rng: np.random.Generator, *, stamp: float = math.nan
    ) -> Observation:
        """Return one noisy scan of `world` from `pose` and what is true of it.

        All randomness comes from `rng`.
        """
        ranges, surface = self.cast(world, pose)
        noisy = ranges + rng.normal(0.0, self.range_sigma, self.beams)
        scan = LaserScan(
            angles=self.angles, ranges=noisy, range_max=self.range_max, stamp=stamp, pose=pose
        )
        return Observation(
            scan=scan, world=world, pose=pose, surface=np.where(scan.valid, surface, -1)
        )

    def scan(
        self, world: World, pose: Pose2D, rng: np.random.Generator, *, stamp: float = math.nan
    ) -> LaserScan:
        """Return one noisy scan of `world` from `pose`; all randomness comes from `rng`."""
        return self.observe(world, pose, rng, stamp=stamp).scan


def _to_sides(sides: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the range [m] at which each ray from the origin meets each side, (N, S), or inf."""
    start, along = sides[:, 0], sides[:, 1] - sides[:, 0]
    # Solve range * direction = start + u * along for each beam (rows) and side (columns).
    with np.errstate(divide="ignore", invalid="ignore"):
        det = direction[:, :1] * along[:, 1] - direction[:, 1:] * along[:, 0]
        ranges = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / det
        u = (start[:, 0] * direction[:, 1:] - start[:, 1] * direction[:, :1]) / det
        hit = (ranges > 0) & (u >= 0) & (u <= 1) & np.isfinite(ranges)
    return np.where(hit, ranges, math.inf)


def _to_poles(poles: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the range [m] at which each ray from the origin meets each pole, (N, P), or inf."""
    ahead = direction @ poles[:, :2].T
    aside = direction[:, :1] * poles[:, 1] - direction[:, 1:] * poles[:, 0]
    half_chord = np.sqrt(np.maximum(poles[:, 2] ** 2 - aside**2, 0.0))
    ranges = ahead - half_chord
    return np.where((abs(aside) < poles[:, 2]) & (ranges > 0), ranges, math.inf)
