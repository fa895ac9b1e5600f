"""`direct_hough`: a Hough transform run directly on the points of a scan."""

from laserfeatures_plugins.direct_hough.detector import DirectHough

__all__ = ["DirectHough"]
