"""An emulated SICK LMS200, LMS211, LMS220, LMS221 or LMS291 (type 6)."""

from laserfeatures.emulators.lms.device import LmsDevice
from laserfeatures.emulators.lms.memory import Memory

__all__ = ["LmsDevice", "Memory"]
