"""Region growing in scan order with running sums."""

from laserfeatures_plugins.region_growing.detector import RegionGrowing

__all__ = ["RegionGrowing"]
