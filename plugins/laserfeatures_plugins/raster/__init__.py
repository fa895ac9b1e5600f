"""`raster_hough` and `kanade_tomasi`: lines and corners out of an image of the scan."""

from laserfeatures_plugins.raster.corners import KanadeTomasi
from laserfeatures_plugins.raster.hough import RasterHough

__all__ = ["KanadeTomasi", "RasterHough"]
