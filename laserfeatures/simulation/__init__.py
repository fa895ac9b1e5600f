"""Floor plans, and a scanner that sweeps over them."""

from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import World, hallway

__all__ = ["Scanner", "World", "hallway"]
