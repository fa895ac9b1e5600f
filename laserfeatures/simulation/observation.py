"""What a simulated scan shows, and what is true of it."""

from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import IntArray, Record, read_only
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.simulation.world import World


@dataclass(frozen=True, eq=False, kw_only=True)
class Observation(Record):
    """A scan of a world, and which surface each of its beams truly measures.

    Parameters
    ----------
    scan : LaserScan
        The scan, as a sensor gives it.
    world : World
        What was scanned.
    pose : Pose2D
        Where the sensor stood in it.
    surface : (N,) int array
        Number of the surface that each beam measures, as `World` counts them; -1 where the beam has
        no return, or one that shows no surface (an outlier, a mixed pixel).
    """

    scan: LaserScan
    world: World
    pose: Pose2D
    surface: IntArray

    def __post_init__(self) -> None:
        """Check and lock the surfaces."""
        self._set(surface=read_only(self.surface, "surface", self.scan.angles.shape, np.int64))
