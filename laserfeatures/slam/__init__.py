"""EKF-SLAM on corners and walls."""

from laserfeatures.slam.filter import EkfSlam, Step
from laserfeatures.slam.map import Landmark
from laserfeatures.slam.motion import Motion

__all__ = ["EkfSlam", "Landmark", "Motion", "Step"]
