"""LDROBOT LD06, LD19, STL-06P and STL-19P: they only talk, from power-on."""

from laserfeatures.drivers.ld19.driver import Ld19

__all__ = ["Ld19"]
