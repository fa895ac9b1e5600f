"""Random rooms for the benchmarks: rectangles with niches, corridors, a cut corner, boxes."""

import math

import numpy as np

from laserfeatures import Pose2D
from laserfeatures.simulation import World

CLEARANCE = 0.4  # [m], least distance of the sensor from a wall


def random_room(seed: int, *, scale: float = 1.0):
    """Return a room and a pose in it; the same `seed`, the same room."""
    rng = np.random.default_rng(seed)
    width, depth = rng.uniform(3, 9), rng.uniform(3, 7)
    outline = _outline(rng, width, depth)
    while True:
        boxes = [_box(rng, width, depth) for _ in range(rng.integers(0, 4))]
        world = World.outline(outline * scale, *(box * scale for box in boxes))
        for _ in range(50):
            x, y = rng.uniform(0.7, width - 0.7), rng.uniform(0.7, depth - 0.7)
            pose = Pose2D(x * scale, y * scale, rng.uniform(-math.pi, math.pi))
            if _clear(world, pose) and not any(_inside(box, x, y) for box in boxes):
                return world, pose


def plain_room():
    """Return the one known room of the speed tests, 6 m x 4.5 m, and poses in it."""
    outline = [(0, 0), (6, 0), (6, 3), (4.5, 3), (4.5, 4.5), (1, 4.5), (0, 3.5)]
    poses = [
        Pose2D(1.9, 0.6, 0.9),
        Pose2D(3.1, 1.0, 0.8),
        Pose2D(4.6, 0.8, 2.0),
        Pose2D(1.6, 1.5, 1.6),
    ]
    return World.outline(np.array(outline, dtype=float)), poses


def _outline(rng, width, depth):
    """Return a rectangle whose sides may have a niche, pillar or corridor, and one cut corner."""
    corners = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    cut = rng.integers(0, 4) if rng.random() < 0.4 else -1
    points = []
    for k in range(4):
        start, end = corners[k], corners[(k + 1) % 4]
        length = math.dist(start, end)
        along = (end - start) / length
        inward = np.array([-along[1], along[0]])
        free = [0.9, length - 0.9]
        if k == cut:  # the corner at the start of this side: replaced by an oblique wall
            off = rng.uniform(0.4, 0.8)
            points += [start + inward * off, start + along * off]
        else:
            points.append(start)
        if rng.random() < 0.6:
            wide = min(rng.uniform(0.5, 1.5), free[1] - free[0])
            at = free[0] + rng.random() * (free[1] - free[0] - wide)
            deep = rng.choice([rng.uniform(0.1, 0.5), -rng.uniform(0.1, 0.5), -3.0])
            points += [
                start + along * at,
                start + along * at + inward * deep,
                start + along * (at + wide) + inward * deep,
                start + along * (at + wide),
            ]
    return np.array(points)


def _box(rng, width, depth):
    """Return a rectangle of 0.3 m to 1.2 m, turned anyhow, with its centre in the room."""
    half = rng.uniform(0.15, 0.6, 2)
    turn = rng.uniform(0, math.pi)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    c, s = math.cos(turn), math.sin(turn)
    centre = rng.uniform((0.8, 0.8), (width - 0.8, depth - 0.8))
    return corners @ np.array([[c, s], [-s, c]]) + centre


def _clear(world, pose):
    start, along = world.walls[:, 0], world.walls[:, 1] - world.walls[:, 0]
    position = np.array((pose.x, pose.y))
    share = ((position - start) * along).sum(axis=1) / (along**2).sum(axis=1)
    nearest = start + np.clip(share, 0, 1)[:, None] * along
    return np.hypot(*(nearest - position).T).min() > CLEARANCE


def _inside(polygon, x, y):
    """Tell whether a point lies in a polygon whose corners go counter-clockwise."""
    step = np.roll(polygon, -1, axis=0) - polygon
    return bool((step[:, 0] * (y - polygon[:, 1]) > step[:, 1] * (x - polygon[:, 0])).all())
