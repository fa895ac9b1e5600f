"""What can go wrong on the way."""

from laserfeatures.errors import LaserFeaturesError


class DriveError(LaserFeaturesError, RuntimeError):
    """The robot cannot go on: it does not fit, is stuck, or has tipped over."""
