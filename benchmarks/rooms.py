"""The rooms of the benchmarks: random ones, and one that is known."""

import numpy as np

from laserfeatures import Pose2D
from laserfeatures.simulation import World, random_room

__all__ = ["plain_room", "random_room"]


def plain_room():
    """Return the one known room of the speed tests, 6 m x 4.5 m, and poses in it."""
    outline = [(0, 0), (6, 0), (6, 3), (4.5, 3), (4.5, 4.5), (1, 4.5), (0, 3.5)]
    poses = [
        Pose2D(1.9, 0.6, 0.9),
        Pose2D(3.1, 1.0, 0.8),
        Pose2D(4.6, 0.8, 2.0),
        Pose2D(1.6, 1.5, 1.6),
    ]
    return World.outline(np.array(outline, dtype=float)), poses
