"""An emulated Slamtec RPLIDAR."""

from laserfeatures.emulators.rplidar.device import START_STATES, TROUBLES, RPLidarDevice
from laserfeatures.emulators.rplidar.models import MODELS

__all__ = ["MODELS", "START_STATES", "TROUBLES", "RPLidarDevice"]
