"""Sequential RANSAC on the points of a scan."""

from laserfeatures_plugins.ransac.detector import Ransac

__all__ = ["Ransac"]
