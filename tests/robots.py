"""What the tests of the robot share: a small plan, and a robot without errors."""

from laserfeatures.simulation import Drive, Plan, World
from laserfeatures.simulation.robot import Robot

PERFECT = Robot(radius_error=0.0, track_error=0.0, unevenness=0.0, friction=(0.8, 0.8))
WAYPOINTS = [(1.0, 1.0), (4.0, 1.0), (4.0, 3.0), (1.5, 2.5)]

PLAN_FILE = """\
[[outline]]
points = [[0, 0], [5, 0], [5, 4], [0, 4]]
[[box]]
center = [2.5, 3.6]
size = [1.0, 0.4]
[drive]
waypoints = [[1, 1], [4, 1], [4, 3], [1.5, 2.5]]
seed = 3
"""


def room(width=5.0, depth=4.0, **rest):
    """Return a plan of one empty room with a drive through it."""
    world = World.outline([(0, 0), (width, 0), (width, depth), (0, depth)])
    return Plan(world=world, drive=Drive(**{"waypoints": WAYPOINTS, **rest}))
