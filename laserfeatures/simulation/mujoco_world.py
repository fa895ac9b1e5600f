"""Worlds in MuJoCo: the one place of the simulation's static side that needs it."""

import math
from typing import Any

import numpy as np

from laserfeatures.optional import optional
from laserfeatures.simulation.world import World


def mujoco() -> Any:
    """Return the package mujoco.

    Raises
    ------
    MissingDependencyError
        If it is not installed, or lacks a library of the system.
    """
    return optional("mujoco", "driving a robot needs mujoco", "sim")


def add_world(spec: Any, world: World, *, height: float = 1.0, thickness: float = 0.02) -> None:
    """Add a world's walls, boxes and poles to a MuJoCo model as static geoms that stand on z = 0.

    They are named ``wall_0``, ``box_0``, ``pole_0`` and so on, and as grey as they reflect.

    Parameters
    ----------
    spec : mujoco.MjSpec
        The model to add them to.
    world : World
        The floor plan.
    height : float
        How high all of it stands [m].
    thickness : float
        Of a wall [m], half of it on either side of the plan's line. Contacts need some; rays come
        nearest to the plan's where there is little.

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    ValueError
        If a length is not > 0.
    """
    for name, length in (("height", height), ("thickness", thickness)):
        if not 0 < length < math.inf:
            raise ValueError(f"{name} must be > 0 m, got {length}")
    types = mujoco().mjtGeom
    geoms = []
    for i, (start, end) in enumerate(world.walls):
        (x, y), (dx, dy) = (start + end) / 2, end - start
        size = (math.hypot(dx, dy) / 2, thickness / 2, height / 2)
        geoms.append((f"wall_{i}", types.mjGEOM_BOX, x, y, math.atan2(dy, dx), size))
    for i, (x, y, length, width, heading) in enumerate(world.boxes):
        size = (length / 2, width / 2, height / 2)
        geoms.append((f"box_{i}", types.mjGEOM_BOX, x, y, heading, size))
    for i, (x, y, radius) in enumerate(world.poles):
        geoms.append((f"pole_{i}", types.mjGEOM_CYLINDER, x, y, 0.0, (radius, height / 2, 0.0)))
    greys = np.asarray(world.reflectivity)
    for (name, kind, x, y, heading, size), grey in zip(geoms, greys, strict=True):
        spec.worldbody.add_geom(
            name=name,
            type=kind,
            pos=(x, y, height / 2),
            quat=(math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)),
            size=np.array(size),
            rgba=(grey, grey, grey, 1.0),
        )
