"""Slamtec RPLIDAR, A and C series: pure functions, decoder and driver."""

from laserfeatures.drivers.rplidar.driver import RPLidar

__all__ = ["RPLidar"]
