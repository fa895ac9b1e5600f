"""The room that emulated RPLIDARs stand in, for their tests."""

import numpy as np

from laserfeatures.emulators import WorldFeed
from laserfeatures.scan import Pose2D
from laserfeatures.simulation import World
from laserfeatures.simulation.raycast import cast

ROOM = World.outline([(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)])
STAND = Pose2D(2.0, 1.5, 0.3)


def room_feed(range_sigma=0.0, pose=STAND):
    """Return what a device in the room sees."""
    return WorldFeed(ROOM, pose, range_sigma=range_sigma)


def off_the_walls(scan, pose=STAND):
    """Return how far the points of a scan are from the walls [m]."""
    return ROOM.distances(pose.transform(scan.points)).min(axis=-1)


def true_ranges(degrees, pose=STAND):
    """Return the distances [mm] of the walls in the device's directions (clockwise) [degrees]."""
    angles = pose.theta - np.radians(np.asarray(degrees, float))
    ranges, _ = cast(ROOM, np.array((pose.x, pose.y)), angles.ravel())
    return 1000 * ranges.reshape(angles.shape)


def excess(points, off_by=0.1):
    """Return how far [mm] points (degrees, mm) are from what is seen within `off_by` degrees."""
    degrees, distances = np.array(points, float).T
    around = true_ranges(degrees[:, None] + np.linspace(-off_by, off_by, 21))
    return np.maximum(around.min(axis=1) - distances, distances - around.max(axis=1)).clip(0)
