"""The scanner's rays against those of MuJoCo, in the same worlds."""

import re
import sys
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from laserfeatures import Pose2D
from laserfeatures.errors import MissingDependencyError
from laserfeatures.optional import install_line
from laserfeatures.simulation import (
    Scanner,
    World,
    hallway,
    random_corridor,
    random_hallway,
    random_office,
    random_room,
)
from laserfeatures.simulation.mujoco_world import add_world
from laserfeatures.simulation.raycast import cos_incidence

HEIGHT = 1.0  # [m]
THICKNESS = 1e-4  # [m]; MuJoCo has no walls without any
EDGE = 4e-4  # [rad]; a beam nearer to an edge than this may meet the wall's thin end
STEEPEST = 0.02  # cosine of the incidence; such a beam runs within 1.2 degrees of its wall
MOST_LEFT_OUT = 0.02  # share of the beams that either concerns
SCANNER = Scanner(beams=181, field_of_view=2 * np.pi * 180 / 181)


def clutter(seed):
    """Return boxes, poles and loose walls at random, and three free poses among them."""
    rng = np.random.default_rng(seed)
    centres = rng.uniform(-4, 4, (6, 2, 1))
    world = World(
        walls=rng.uniform(-6, 6, (5, 2, 2)),
        boxes=np.column_stack([*centres[:, :, 0].T, *rng.uniform(0.2, 1.5, (2, 6)), range(6)]),
        poles=rng.uniform((-5, -5, 0.02), (5, 5, 0.4), (7, 3)),
    )
    tries = rng.uniform(-5, 5, (200, 2))
    free = tries[world.distances(tries).min(axis=1) > 0.4][:3]
    return world, [Pose2D(x, y, rng.uniform(-3, 3)) for x, y in free]


def office(seed):
    plan = random_office(seed)
    return plan.world, [Pose2D(x, y, 0.3 * k) for k, (x, y) in enumerate(plan.drive.waypoints)]


def room(seed):
    world, pose = random_room(seed, poles=6)
    return world, [pose]


def mujoco_cast(world, pose, angles):
    """Return range, number of the object hit or -1, and the surface's normal, of each ray."""
    spec = mujoco.MjSpec()
    add_world(spec, world, height=HEIGHT, thickness=THICKNESS)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    count = angles.size
    rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)
    geom, ranges, normals = np.zeros(count, np.int32), np.zeros(count), np.zeros(3 * count)
    position = np.array([pose.x, pose.y, HEIGHT / 2])
    mujoco.mj_multiRay(
        model, data, position, rays.ravel(), None, 1, -1, geom, ranges, normals, count, 1e6
    )
    first = {"wall": 0, "box": len(world.walls), "pole": len(world.walls) + len(world.boxes)}
    named = [model.geom(g).name.split("_") if g >= 0 else None for g in geom]
    objects = [first[name[0]] + int(name[1]) if name else -1 for name in named]
    ranges[geom < 0] = np.inf
    return ranges, np.array(objects), normals.reshape(-1, 3)[:, :2]


def normal_of(world, pose, angles, ranges, surface):
    """Return the unit normals, towards the sensor, of the surfaces that beams hit."""
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sides = len(world.sides)
    normals = np.empty_like(direction)
    for k, s in enumerate(surface):
        if s < sides:
            (dx, dy) = world.sides[s, 1] - world.sides[s, 0]
            normals[k] = (dy, -dx)
        else:
            normals[k] = (pose.x, pose.y) + ranges[k] * direction[k] - world.poles[s - sides, :2]
    normals *= -np.sign((normals * direction).sum(axis=1))[:, None]
    return normals / np.hypot(*normals.T)[:, None]


FAMILIES = [clutter, room, random_corridor, random_hallway, office]
WORLDS = [
    pytest.param(family, seed, id=f"{family.__name__} {seed}")
    for family in FAMILIES
    for seed in range(8)
]


@pytest.mark.parametrize(
    ("family", "seed"), [*WORLDS, pytest.param(lambda _: hallway(), 0, id="the hallway")]
)
def test_every_beam_goes_as_far_as_mujocos_and_hits_the_same_surface(family, seed):
    world, poses = family(seed)
    left_out = 0
    for pose in poses:
        angles = SCANNER.angles + pose.theta
        ranges, surface = SCANNER.cast(world, pose)
        theirs, objects, normals = mujoco_cast(world, pose, angles)
        position = np.array((pose.x, pose.y))
        cosine = cos_incidence(world, position, angles, surface)
        beside = [
            SCANNER.cast(world, replace(pose, theta=pose.theta + off))[1] for off in (-EDGE, EDGE)
        ]
        clear = (beside[0] == surface) & (beside[1] == surface) & (cosine > STEEPEST)
        left_out += (~clear).sum()
        hit = clear & (surface >= 0)
        assert (objects[clear & ~hit] == -1).all()
        assert np.isinf(ranges[clear & ~hit]).all()
        assert objects[hit].tolist() == world.object_of[surface[hit]].tolist()
        thick = np.where(surface < len(world.walls), THICKNESS / 2, 0.0)[hit]
        np.testing.assert_array_less(
            abs(ranges[hit] - thick / cosine[hit] - theirs[hit]), 1e-9 + 1e-9 * ranges[hit]
        )
        own = normal_of(world, pose, angles[hit], ranges[hit], surface[hit])
        np.testing.assert_allclose((own * normals[hit]).sum(axis=1), 1.0, atol=1e-9)
    assert left_out <= MOST_LEFT_OUT * len(poses) * SCANNER.beams


@pytest.mark.parametrize("sizes", [{"height": 0.0}, {"thickness": -1.0}])
def test_what_has_no_size_is_refused(sizes):
    ((name, length),) = sizes.items()
    with pytest.raises(ValueError, match=rf"{name} must be > 0 m, got {length}"):
        add_world(mujoco.MjSpec(), hallway()[0], **sizes)


def test_without_mujoco_the_error_says_how_to_install_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)  # as if it were not there
    with pytest.raises(MissingDependencyError, match=re.escape(install_line("sim"))):
        add_world(None, hallway()[0])
