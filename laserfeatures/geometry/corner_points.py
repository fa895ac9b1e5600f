"""Points at the corner of two walls: their bearings tell which wall they are on."""

import math

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.geometry.compiled import helper
from laserfeatures.geometry.walls import FREE

BESIDE = 4  # points between two walls that may meet
LEAST_SINE = math.sin(math.radians(10.0))  # flatter crossings are not known well enough


@helper
def part_at_corners(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    gate: float,
    changed: BoolArray,
) -> bool:
    """Part the points of walls that meet by the bearing of their crossing.

    A beam hits the wall on its side of the corner, whatever its range errs by; to give a point to
    the nearer of both would choose the errors that each wall gets, and turn the short ones. Points
    move that lie within `gate` of the wall on their side. Counts the walls' points anew and marks
    those that changed; returns whether any did.
    """
    moved = False
    last = -1
    for i in range(x.size):
        if owner[i] < 0:
            continue
        if last >= 0 and owner[last] != owner[i] and i - last <= BESIDE:
            moved |= part(x, y, owner, walls, last, i, gate, changed)
        last = i
    return moved


@helper
def part(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    last: int,
    first: int,
    gate: float,
    changed: BoolArray,
) -> bool:
    """Part the points of two walls, one up to the point `last`, the next from the point `first`."""
    a = owner[last]
    b = owner[first]
    ca = math.cos(walls[a, 0])
    sa = math.sin(walls[a, 0])
    cb = math.cos(walls[b, 0])
    sb = math.sin(walls[b, 0])
    det = ca * sb - sa * cb
    if abs(det) < LEAST_SINE:
        return False
    corner_x = (walls[a, 1] * sb - walls[b, 1] * sa) / det
    corner_y = (walls[b, 1] * ca - walls[a, 1] * cb) / det
    ahead = corner_x * x[last] + corner_y * y[last] > 0.0
    if not ahead or corner_x * x[first] + corner_y * y[first] <= 0.0:
        return False
    moved = False
    i = first - 1
    while i >= 0 and (owner[i] == a or owner[i] == FREE):
        if corner_x * y[i] - corner_y * x[i] <= 0.0:
            break
        if abs(x[i] * cb + y[i] * sb - walls[b, 1]) < gate:
            move(owner, i, b, walls, changed)
            moved = True
        i -= 1
    i = last + 1
    while i < x.size and (owner[i] == b or owner[i] == FREE):
        if corner_x * y[i] - corner_y * x[i] >= 0.0:
            break
        if abs(x[i] * ca + y[i] * sa - walls[a, 1]) < gate:
            move(owner, i, a, walls, changed)
            moved = True
        i += 1
    return moved


@helper
def move(owner: IntArray, i: int, wall: int, walls: FloatArray, changed: BoolArray) -> None:
    """Give a point to a wall, and mark both walls."""
    if owner[i] >= 0:
        walls[owner[i], 5] -= 1
        changed[owner[i]] = True
    walls[wall, 5] += 1
    changed[wall] = True
    owner[i] = wall
