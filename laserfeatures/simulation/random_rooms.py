"""Random rooms: rectangles with niches, corridors, a cut corner, furniture and poles."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.world import World

CLEARANCE = 0.4  # [m], least distance of the sensor from a wall or pole
MOST_POLES = 20
LEAST_SCALE = 0.5  # in a smaller room there may be no place for the sensor


def random_room(seed: int, *, scale: float = 1.0, poles: int = 0) -> tuple[World, Pose2D]:
    """Return a room and a pose in it; the same `seed`, the same room.

    A rectangle of 3 m to 9 m by 3 m to 7 m. A side may have a niche, a pillar or a corridor, one
    corner may be cut by an oblique wall, and up to three boxes of four walls, turned anyhow, stand
    in it.

    Parameters
    ----------
    seed : int
        Seed of all randomness.
    scale : float
        Factor of all lengths, at least 0.5.
    poles : int
        How many poles of 3 cm to 15 cm radius stand in it besides, 0 to 20; they change nothing
        else of the room.

    Raises
    ------
    ValueError
        If a parameter is out of its range.
    """
    if not LEAST_SCALE <= scale < math.inf:
        raise ValueError(f"scale must be >= {LEAST_SCALE}, got {scale}")
    if not 0 <= poles <= MOST_POLES:
        raise ValueError(f"poles must be 0 to {MOST_POLES}, got {poles}")
    rng = np.random.default_rng(seed)
    width, depth = rng.uniform(3, 9), rng.uniform(3, 7)
    outline = _outline(rng, width, depth)
    while True:
        boxes = [_box(rng, width, depth) for _ in range(rng.integers(0, 4))]
        world = World.outline(outline * scale, *(box * scale for box in boxes))
        for _ in range(50):
            x, y = rng.uniform(0.7, width - 0.7), rng.uniform(0.7, depth - 0.7)
            pose = Pose2D(x * scale, y * scale, rng.uniform(-math.pi, math.pi))
            clear = world.distances((pose.x, pose.y)).min() > CLEARANCE
            if clear and not any(_inside(box, x, y) for box in boxes):
                standing = _poles(rng, poles, (width, depth), boxes, (x, y, CLEARANCE / scale))
                return World(walls=world.walls, poles=standing * scale), pose


def _outline(rng: np.random.Generator, width: float, depth: float) -> FloatArray:
    """Return a rectangle whose sides may have a niche, pillar or corridor, and one cut corner."""
    corners = np.array([(0, 0), (width, 0), (width, depth), (0, depth)])
    cut = rng.integers(0, 4) if rng.random() < 0.4 else -1
    points: list[FloatArray] = []
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


def _box(rng: np.random.Generator, width: float, depth: float) -> FloatArray:
    """Return a rectangle of 0.3 m to 1.2 m, turned anyhow, with its centre in the room."""
    half = rng.uniform(0.15, 0.6, 2)
    turn = rng.uniform(0, math.pi)
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
    c, s = math.cos(turn), math.sin(turn)
    centre = rng.uniform((0.8, 0.8), (width - 0.8, depth - 0.8))
    box: FloatArray = corners @ np.array([[c, s], [-s, c]]) + centre
    return box


def _inside(polygon: FloatArray, x: float, y: float) -> bool:
    """Tell whether a point lies in a polygon whose corners go counter-clockwise."""
    step = np.roll(polygon, -1, axis=0) - polygon
    return bool((step[:, 0] * (y - polygon[:, 1]) > step[:, 1] * (x - polygon[:, 0])).all())


def _poles(
    rng: np.random.Generator,
    count: int,
    size: tuple[float, float],
    boxes: list[FloatArray],
    sensor: tuple[float, float, float],
) -> FloatArray:
    """Return poles in a room of that size, outside its boxes and a circle round the sensor."""
    poles: list[tuple[float, float, float]] = []
    while len(poles) < count:
        radius = rng.uniform(0.03, 0.15)
        x, y = rng.uniform((0.6, 0.6), (size[0] - 0.6, size[1] - 0.6))
        off_sensor = math.dist((x, y), sensor[:2]) > sensor[2] + radius
        if off_sensor and not any(_inside(box, x, y) for box in boxes):
            poles.append((x, y, radius))
    return np.array(poles).reshape(-1, 3)
