"""A differential-drive robot in MuJoCo that carries a scanner through a world (extra `sim`)."""

from laserfeatures.errors import DriveError
from laserfeatures.simulation.robot.driving import drive
from laserfeatures.simulation.robot.platform import Robot
from laserfeatures.simulation.robot.reading import Reading

__all__ = ["DriveError", "Reading", "Robot", "drive"]
