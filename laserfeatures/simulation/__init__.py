"""Floor plans, and a scanner that sweeps over them."""

from laserfeatures.simulation.hallway import hallway
from laserfeatures.simulation.observation import Observation
from laserfeatures.simulation.plan import Drive, Plan
from laserfeatures.simulation.plan_reader import read_plan
from laserfeatures.simulation.plan_writer import write_plan
from laserfeatures.simulation.random_corridors import random_corridor, random_hallway
from laserfeatures.simulation.random_offices import random_office
from laserfeatures.simulation.random_rooms import random_room
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import World

__all__ = [
    "Drive",
    "Observation",
    "Plan",
    "Scanner",
    "World",
    "hallway",
    "random_corridor",
    "random_hallway",
    "random_office",
    "random_room",
    "read_plan",
    "write_plan",
]
