"""Floor plans, and a scanner that sweeps over them."""

from laserfeatures.simulation.hallway import hallway
from laserfeatures.simulation.observation import Observation
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import World

__all__ = ["Observation", "Scanner", "World", "hallway"]
