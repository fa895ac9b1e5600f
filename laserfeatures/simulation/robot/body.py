"""The robot's body at work: motors in, motion out, by MuJoCo's physics."""

import math

import numpy as np

from laserfeatures.data import Pose2D
from laserfeatures.simulation.mujoco_world import mujoco
from laserfeatures.simulation.robot.model import WHEELS, Wheels, make_model
from laserfeatures.simulation.robot.platform import Robot
from laserfeatures.simulation.world import World

PATCH = 0.05  # [m], how far a wheel rolls before the floor is another
TOUCH = 0.002  # [m], what is nearer is touched


class Body:
    """A robot that stands, and then moves, in a world.

    Parameters
    ----------
    robot : Robot
        What it is like.
    world : World
        Where it is; walls, boxes and poles are solid.
    start : Pose2D
        Its first pose.
    rng : Generator
        Draws its true wheels and the floor.

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    """

    def __init__(self, robot: Robot, world: World, start: Pose2D, rng: np.random.Generator) -> None:
        self._mj = mujoco()
        self._robot = robot
        self._rng = rng
        off = rng.normal(size=3) * (robot.radius_error, robot.radius_error, robot.track_error)
        self.wheels = Wheels(
            left=robot.wheel_radius * (1 + off[0]),
            right=robot.wheel_radius * (1 + off[1]),
            track=robot.track * (1 + off[2]),
        )
        self._model = make_model(robot, world, start, self.wheels)
        self._data = self._mj.MjData(self._model)
        self._joints = [self._model.joint(name).qposadr[0] for name in WHEELS]
        self._next_patch = [0.0, 0.0]
        self._mj.mj_forward(self._model, self._data)

    @property
    def pose(self) -> Pose2D:
        """Where it truly is."""
        x, y, _, w, i, j, k = self._data.qpos[:7].tolist()
        return Pose2D(x, y, math.atan2(2 * (w * k + i * j), 1 - 2 * (j * j + k * k)))

    @property
    def height(self) -> float:
        """How high the middle of the axle stands above where it should [m]."""
        return float(self._data.qpos[2])

    @property
    def tilt(self) -> float:
        """Angle between its own and the true vertical [rad]."""
        i, j = self._data.qpos[4:6].tolist()
        return math.acos(max(-1.0, 1 - 2 * (i * i + j * j)))

    @property
    def wheel_angles(self) -> tuple[float, float]:
        """How far the left and right wheel have turned [rad]."""
        left, right = (float(self._data.qpos[joint]) for joint in self._joints)
        return left, right

    @property
    def touching(self) -> str | None:
        """Name of what of the world the chassis touches, such as "wall 3"; None if nothing."""
        # Not from the contacts: a robot that bounces off a wall has none half of the time.
        name = self._model.geom
        chassis = name("chassis").id
        near = {
            i: self._mj.mj_geomDistance(self._model, self._data, chassis, i, TOUCH, None)
            for i in range(self._model.ngeom)
            if self._model.geom_bodyid[i] == 0 and i != name("floor").id
        }
        nearest = min(near, key=near.__getitem__, default=None)
        if nearest is None or near[nearest] >= TOUCH:
            return None
        return str(name(nearest).name).replace("_", " ")

    def advance(self, speed: float, turn_rate: float, steps: int) -> None:
        """Hold a speed [m/s] and turn rate [rad/s] for some steps of time, as well as motors can.

        Which wheel speeds that takes is reckoned as odometry does.
        """
        across = turn_rate * self._robot.track / 2
        for side, rolling in enumerate((speed - across, speed + across)):
            self._data.ctrl[side] = rolling / self._robot.wheel_radius
            self._roll_on(side)
        self._mj.mj_step(self._model, self._data, steps)

    def _roll_on(self, side: int) -> None:
        """Put another patch of floor under a wheel that has rolled over the last."""
        rolled = abs(self.wheel_angles[side]) * self._robot.wheel_radius
        if rolled < self._next_patch[side]:
            return
        self._next_patch[side] = rolled + PATCH
        geom = self._model.geom(WHEELS[side])
        geom.friction[0] = self._rng.uniform(*self._robot.friction)
        # A bump lifts the wheel's centre: it rolls on a longer or shorter radius.
        bump = 1 + self._robot.unevenness * self._rng.normal()
        radius = self.wheels[side] * bump
        geom.size[0] = geom.size[2] = radius
