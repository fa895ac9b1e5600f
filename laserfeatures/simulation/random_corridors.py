"""Random corridors with doors, straight and L-shaped, and poses along them."""

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.random_furniture import furnish, piece
from laserfeatures.simulation.random_sides import side, walk, walls_of
from laserfeatures.simulation.world import World

STEP = 1.0  # [m], from pose to pose
CLEARANCE = 0.4  # [m], least distance of a pose from a surface
PATH_CLEARANCE = 0.5  # [m], of the furniture from the path
PROPOSALS = 60  # of pieces of furniture; most find no place in a narrow corridor


def random_corridor(seed: int) -> tuple[World, list[Pose2D]]:
    """Return a corridor with doors, and poses about every metre along it; all from `seed`.

    8 m to 25 m long, 1.4 m to 2.6 m wide, its ends square or oblique. Half of the doors stand open
    to a room, the others are closed, in niches; up to four boxes and poles stand about. Surfaces
    reflect 20 % to 90 %.
    """
    rng = np.random.default_rng(seed)
    length, width = rng.uniform(8, 25), rng.uniform(1.4, 2.6)
    skew = rng.uniform(-0.8, 0.8, 2) * (rng.random(2) < 0.5)
    corners = np.array([(0, 0), (length, 0), (length + skew[0], width), (skew[1], width)])
    bottom, _ = side(rng, corners[0], corners[1], rooms=0.5)
    top, _ = side(rng, corners[2], corners[3], rooms=0.5)
    path = np.array([(1.4, width / 2), (length - 1.4, width / 2)])
    world = _furnished(rng, walls_of([*bottom, corners[1], *top, corners[3]]), path)
    return world, _poses(rng, world, path)


def random_hallway(seed: int) -> tuple[World, list[Pose2D]]:
    """Return an L-shaped hallway, and poses about every metre along it; all from `seed`.

    It is in the manner of the paper's Fig. 5, as `hallway` is: a first part of 8 m to 14 m between
    parallel walls with doors, then one with oblique walls. Up to four boxes and poles stand
    off its middle. Surfaces reflect 20 % to 90 %.
    """
    rng = np.random.default_rng(seed)
    length, height = rng.uniform(8, 14), rng.uniform(6, 9)
    width, wide = rng.uniform(1.8, 2.6, 2)
    cut, lean, bend = rng.uniform(0.4, 1.0), rng.uniform(-0.4, 0.6), rng.uniform(0.5, 0.8)
    inner = length - wide
    outer_bend, inner_bend = height - rng.uniform(0.8, 1.5), width + bend * (height - width)
    corners = np.array([
        (0, 0), (length, 0), (length, outer_bend), (length - cut, height),
        (inner + lean, height), (inner, inner_bend), (inner, width), (0, width),
    ])  # fmt: skip
    points = []
    for k, corner in enumerate(corners):
        if k in {0, 1, 5, 6}:  # the straight sides; behind the inner corner there is no room
            points += side(rng, corner, corners[k + 1], rooms=0.5 if k < 2 else 0.0)[0]
        else:
            points.append(corner)
    middle = inner + wide / 2
    path = np.array([(0.8, width / 2), (middle, width / 2), (middle, height - 1.6)])
    world = _furnished(rng, walls_of(points), path)
    return world, _poses(rng, world, path)


def _furnished(rng: np.random.Generator, walls: FloatArray, path: FloatArray) -> World:
    """Return a world of these walls with up to four boxes and poles off the path."""
    way, headings = walk(path, 0.1)
    places = rng.integers(len(way), size=PROPOSALS)
    aside = rng.uniform(-1.3, 1.3, (PROPOSALS, 2))
    pieces = [
        piece(rng, way[k] + off, float(headings[k])) for k, off in zip(places, aside, strict=True)
    ]
    most = int(rng.integers(0, 5))
    return furnish(rng, walls, pieces, way=way, clearance=PATH_CLEARANCE, most=most)


def _poses(rng: np.random.Generator, world: World, path: FloatArray) -> list[Pose2D]:
    """Return poses along a path, a little off it and turned a little."""
    poses = []
    for (x, y), heading in zip(*walk(path, STEP), strict=True):
        dx, dy = rng.uniform(-0.3, 0.3, 2)
        turn = rng.uniform(-0.4, 0.4)
        clear = world.distances((x + dx, y + dy)).min() > CLEARANCE
        off = np.array((dx, dy)) if clear else np.zeros(2)
        poses.append(Pose2D(float(x + off[0]), float(y + off[1]), float(heading + turn)))
    return poses
