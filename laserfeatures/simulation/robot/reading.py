"""What the robot reads in one moment, and what is true of it."""

from dataclasses import dataclass

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.simulation.observation import Observation


@dataclass(frozen=True, eq=False, kw_only=True)
class Reading:
    """A scan, where odometry takes the robot to be, and where it is.

    Parameters
    ----------
    scan : LaserScan
        The scan; its pose is the scanner's by odometry.
    odometry : Pose2D
        The robot's pose by odometry. It starts where the robot truly does.
    truth : Pose2D
        The robot's true pose, in the world's frame.
    ticks : (int, int)
        What the encoders of the left and right wheel have counted since the start.
    observation : Observation
        The same scan, with the true pose of the scanner and the surface that each beam measures.
    """

    scan: LaserScan
    odometry: Pose2D
    truth: Pose2D
    ticks: tuple[int, int]
    observation: Observation
