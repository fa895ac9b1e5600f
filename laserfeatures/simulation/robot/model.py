"""The robot as a MuJoCo model in its world."""

import math
from typing import Any, NamedTuple

from laserfeatures.data import Pose2D
from laserfeatures.simulation.mujoco_world import add_world, mujoco
from laserfeatures.simulation.robot.platform import Robot
from laserfeatures.simulation.world import World

TIME_STEP = 0.004  # [s]

# Measures [m], from the parameter file that ARIA has for the AmigoBot.
LENGTH, WIDTH, FRONT = 0.330, 0.279, 0.160
# Assumed: measures [m], masses [kg], and what a motor with its gear is like at the wheel.
HEIGHT, CLEARANCE = 0.15, 0.03
MASS_CENTRE = (-0.03, 0.0, 0.07)  # a quarter of the weight is the caster's
WHEEL_WIDTH, WHEEL_MASS = 0.024, 0.2
CASTER_BEHIND, CASTER_RADIUS, CASTER_FRICTION = 0.13, 0.02, 0.05
ROTOR_INERTIA = 0.004  # [kg m^2]
SPEED_GAIN = 0.5  # [N m s/rad], of the loop that holds a wheel's speed
# Stiffer than MuJoCo's own, so that wheels sink in by 0.03 mm and not by 0.4.
STIFF = (0.99, 0.99, 0.001, 0.5, 2.0)

WHEELS = ("left", "right")
# Bits of what collides: the chassis with everything, wheels and caster with the floor alone.
SOLID, ROLLING = 1, 2


class Wheels(NamedTuple):
    """What the wheels truly are, unknown to the odometry: radii and track [m]."""

    left: float
    right: float
    track: float


def make_model(robot: Robot, world: World, start: Pose2D, wheels: Wheels) -> Any:
    """Return the compiled MuJoCo model of a robot that stands at `start` in a world.

    Its geoms are named: those of the world as `add_world` does, the wheels ``left`` and ``right``,
    besides ``floor``, ``chassis`` and ``caster``.

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    """
    mj = mujoco()
    spec = mj.MjSpec()
    spec.option.timestep = TIME_STEP
    spec.option.cone = mj.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0  # friction as stiff as the floor: what slips is the wheel
    spec.worldbody.add_geom(
        name="floor",
        type=mj.mjtGeom.mjGEOM_PLANE,
        size=(0.0, 0.0, 1.0),
        contype=SOLID | ROLLING,
        conaffinity=SOLID,
        solimp=STIFF,
    )
    add_world(spec, world)
    body = spec.worldbody.add_body(
        name="robot",
        pos=(start.x, start.y, 0.0),
        quat=(math.cos(start.theta / 2), 0.0, 0.0, math.sin(start.theta / 2)),
    )
    body.add_freejoint()
    _add_chassis(mj, body, robot)
    for name, side in zip(WHEELS, (1, -1), strict=True):
        _add_wheel(mj, spec, body, robot, name, side * wheels.track / 2, getattr(wheels, name))
    return spec.compile()


def _add_chassis(mj: Any, body: Any, robot: Robot) -> None:
    mass = robot.mass - 2 * WHEEL_MASS
    body.explicitinertial = True
    body.mass = mass
    body.ipos = MASS_CENTRE
    a, b, c = LENGTH**2, WIDTH**2, (HEIGHT - CLEARANCE) ** 2  # those of a solid box
    body.inertia = (mass * (b + c) / 12, mass * (a + c) / 12, mass * (a + b) / 12)
    body.add_geom(
        name="chassis",
        type=mj.mjtGeom.mjGEOM_BOX,
        pos=(FRONT - LENGTH / 2, 0.0, (HEIGHT + CLEARANCE) / 2),
        size=(LENGTH / 2, WIDTH / 2, (HEIGHT - CLEARANCE) / 2),
        contype=SOLID,
        conaffinity=SOLID,
    )
    # A ball that slides: whichever way a real caster points, it hardly drags.
    body.add_geom(
        name="caster",
        type=mj.mjtGeom.mjGEOM_SPHERE,
        pos=(-CASTER_BEHIND, 0.0, CASTER_RADIUS),
        size=(CASTER_RADIUS, 0.0, 0.0),
        contype=0,
        conaffinity=ROLLING,
        priority=1,  # its friction counts, not the floor's
        friction=(CASTER_FRICTION, 0.0, 0.0),
        solimp=STIFF,
    )


def _add_wheel(
    mj: Any, spec: Any, body: Any, robot: Robot, name: str, y: float, radius: float
) -> None:
    wheel = body.add_body(name=name, pos=(0.0, y, radius))
    wheel.add_joint(
        name=name, type=mj.mjtJoint.mjJNT_HINGE, axis=(0.0, 1.0, 0.0), armature=ROTOR_INERTIA
    )
    # The crown of a tyre, that touches the floor in one point: the axis of the ellipsoid is y.
    wheel.add_geom(
        name=name,
        type=mj.mjtGeom.mjGEOM_ELLIPSOID,
        size=(radius, WHEEL_WIDTH / 2, radius),
        mass=WHEEL_MASS,
        contype=0,
        conaffinity=ROLLING,
        priority=1,  # the friction of the patch that it is on is set on it
        friction=(robot.friction[1], 0.0, 0.0),
        solimp=STIFF,
    )
    motor = spec.add_actuator(name=name, target=name, trntype=mj.mjtTrn.mjTRN_JOINT)
    motor.gainprm[0] = SPEED_GAIN
    motor.biastype = mj.mjtBias.mjBIAS_AFFINE
    motor.biasprm[2] = -SPEED_GAIN
    motor.forcelimited = True
    motor.forcerange = (-robot.max_torque, robot.max_torque)
