"""What an emulated device sees: a simulated world, or recorded scans."""

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.errors import SourceError
from laserfeatures.scan import LaserScan, Pose2D
from laserfeatures.simulation import World
from laserfeatures.simulation.raycast import cast

NEAR = 0.75  # steps between beams: what is farther from the nearest lies in a gap


class Feed(Protocol):
    """What a scanner sees, turn after turn."""

    def __call__(self, angles: FloatArray) -> FloatArray:
        """Return the ranges [m] along `angles` (N,) [rad] in the next turn; nan: no return."""


class WorldFeed:
    """A scanner that stands still in a world.

    Parameters
    ----------
    world : World
        The floor plan.
    pose : Pose2D
        Where it stands.
    range_sigma : float
        Standard deviation of the ranges [m].
    range_max : float
        How far it sees [m].
    seed : int
        Seed of the noise.

    Raises
    ------
    ValueError
        If it stands inside a box or pole, or on a surface.
    """

    def __init__(
        self,
        world: World,
        pose: Pose2D,
        *,
        range_sigma: float = 0.01,
        range_max: float = 30.0,
        seed: int = 0,
    ) -> None:
        world.check_pose(pose)
        self._world, self._pose = world, pose
        self._sigma, self._range_max = range_sigma, range_max
        self._rng = np.random.default_rng(seed)
        self._angles = self._true = np.empty(0)

    def __call__(self, angles: FloatArray) -> FloatArray:
        """Return the ranges of the next turn."""
        if not np.array_equal(angles, self._angles):
            position = np.array((self._pose.x, self._pose.y))
            ranges, _ = cast(self._world, position, angles + self._pose.theta)
            ranges[ranges > self._range_max] = math.nan
            self._angles, self._true = angles, ranges
        return self._true + self._rng.normal(0.0, self._sigma, angles.size)


class ScansFeed:
    """Recorded scans in order, from the first again when all are through.

    A direction gets the range of the nearest beam, and no return beyond the scan's ends.

    Parameters
    ----------
    scans : callable
        Returns the scans, each time from the first.
    """

    def __init__(self, scans: Callable[[], Iterable[LaserScan]]) -> None:
        self._scans = scans
        self._iterator: Iterator[LaserScan] = iter(())

    def __call__(self, angles: FloatArray) -> FloatArray:
        """Return the ranges of the next scan.

        Raises
        ------
        SourceError
            If there is no scan.
        """
        scan = next(self._iterator, None)
        if scan is None:
            self._iterator = iter(self._scans())
            scan = next(self._iterator, None)
        if scan is None or not len(scan):
            raise SourceError("expected a scan to play, got none")
        return sampled(scan, angles)


def sampled(scan: LaserScan, angles: FloatArray) -> FloatArray:
    """Return the ranges [m] of a scan along other directions (N,) [rad]; nan: no return."""
    ranges = np.where(scan.valid, scan.ranges, math.nan)
    step = float(np.median(np.diff(scan.angles))) if len(scan) > 1 else math.tau
    turned = (angles - scan.angles[0] + step) % math.tau + scan.angles[0] - step
    # Once more a turn earlier and later: the nearest beam of a scan all round may be there.
    around = np.concatenate([scan.angles + turns * math.tau for turns in (-1, 0, 1)])
    right = np.searchsorted(around, turned).clip(1, around.size - 1)
    left = right - 1
    nearer = np.where(turned - around[left] <= around[right] - turned, left, right)
    near = abs(turned - around[nearer]) <= NEAR * step
    return np.where(near, ranges[nearer % len(scan)], math.nan)
