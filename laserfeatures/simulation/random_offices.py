"""Random offices: rooms round a corridor that closes a loop, and a drive through them."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.simulation.plan import Drive, Plan
from laserfeatures.simulation.random_furniture import furnish, piece
from laserfeatures.simulation.random_sides import Room, side, walk, walls_of

INTO = 1.3  # [m], how far the robot drives into a room
PATH_CLEARANCE = 0.6  # [m], of the furniture from the robot's path
SHORT_SIDE, LONG_SIDE = (10.0, 14.0), (17.0, 22.0)  # [m], of the block within the corridor


def random_office(seed: int) -> Plan:
    """Return an office floor and a robot's drive through it, all from `seed`.

    A corridor 1.8 m to 2.4 m wide runs round a block of 17 m to 22 m by 10 m to 14 m: the drive is
    one round of at least 60 m, with a look into two rooms, and on to the second corner again.
    Behind most doors is a room with furniture; the others are closed. Surfaces reflect 20 % to
    90 %. The path stays at least 0.4 m clear of all surfaces.
    """
    rng = np.random.default_rng(seed)
    block = np.array((rng.uniform(*LONG_SIDE), rng.uniform(*SHORT_SIDE)))
    width = rng.uniform(1.8, 2.4)
    outside = _rectangle(np.array((-width, -width)), block + width)
    inside = _rectangle(np.zeros(2), block)[::-1]  # clockwise: the corridor is to its left
    outer, inner, sides = [], [], []
    for k in range(4):
        points, rooms = side(rng, outside[k], outside[(k + 1) % 4], rooms=0.8)
        outer += points
        sides.append(rooms)
        inner += side(rng, inside[k], inside[(k + 1) % 4], rooms=0.0)[0]
    path = _path(rng, _rectangle(np.full(2, -width / 2), block + width / 2), sides)
    walls = np.concatenate([walls_of(outer), walls_of(inner)])
    pieces = _pieces(rng, [room for rooms in sides for room in rooms])
    way, _ = walk(path, 0.1)
    world = furnish(rng, walls, pieces, way=way, clearance=PATH_CLEARANCE, most=len(pieces))
    return Plan(world=world, drive=Drive(waypoints=path, seed=seed))


def _rectangle(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the corners of a rectangle, counter-clockwise, (4, 2)."""
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def _path(rng: np.random.Generator, loop: FloatArray, sides: list[list[Room]]) -> FloatArray:
    """Return the way-points of one round of the loop with a look into two rooms, (K, 2)."""
    visited = rng.permutation([k for k in range(4) if sides[k]])[:2]
    points: list[FloatArray] = []
    for k in range(4):
        points.append(loop[k])
        if k in visited:
            room = sides[k][rng.integers(len(sides[k]))]
            before = loop[k] + ((room.door - loop[k]) @ room.along) * room.along
            points += [before, room.door + INTO * room.outward, before]
    return np.array([*points, loop[0], loop[1]])


def _pieces(rng: np.random.Generator, rooms: list[Room]) -> list[FloatArray]:
    """Return boxes and poles in the rooms, not all of which need find a place."""
    pieces = []
    for room in rooms:
        heading = math.atan2(room.along[1], room.along[0])
        low, high = (0.4 - room.left, 0.8), (room.right - 0.4, room.depth - 0.3)
        for _ in range(rng.integers(2, 7)):
            along, outward = rng.uniform(low, high)
            at = room.door + along * room.along + outward * room.outward
            pieces.append(piece(rng, at, heading))
    return pieces
