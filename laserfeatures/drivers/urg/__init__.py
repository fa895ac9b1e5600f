"""Hokuyo URG-04LX-UG01, URG-04LX and others that speak SCIP 2.0."""

from laserfeatures.drivers.urg.driver import Urg

__all__ = ["Urg"]
