"""Kernels that settle which wall each point belongs to: merge pieces, share corners out."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.geometry.compiled import helper, inlined
from laserfeatures.geometry.corner_points import part_at_corners
from laserfeatures.geometry.fit import fit_line, off_line
from laserfeatures.geometry.growth import gate_of
from laserfeatures.geometry.walls import FREE, gather, is_wall, keep_wall, members_of

TURN = 0.05  # [rad]; pieces of one real wall differ by no more
NEAR = 0.1  # [m]
BEND = 0.02  # [m]; pieces of one real wall lie no farther off one line
NEIGHBOURHOOD = 4  # points beside the end of a wall that may belong to the next one
ROUNDS = 2  # of sharing points out and refitting


@helper
def may_be_one(a: FloatArray, b: FloatArray, sigma: float) -> bool:
    """Tell whether two walls have nearly one direction and the middle of one is near the other."""
    turn = abs(b[0] - a[0])
    turn = min(turn, math.pi - turn)  # theta wraps
    if turn > 4.0 * sigma * math.sqrt(a[2] + b[2]) + TURN:
        return False
    return min(middle_off(a, b), middle_off(b, a)) < NEAR


@helper
def middle_off(a: FloatArray, b: FloatArray) -> float:
    """Return the distance of the middle of wall a from the line of wall b [m]."""
    along = a[3] / a[2]  # the covariance of a fit holds where its points' centre is
    c = math.cos(a[0])
    s = math.sin(a[0])
    x = a[1] * c - along * s
    y = a[1] * s + along * c
    return abs(x * math.cos(b[0]) + y * math.sin(b[0]) - b[1])


@inlined
def merge_pieces(
    x: FloatArray, y: FloatArray, owner: IntArray, walls: FloatArray, sigma: float
) -> bool:
    """Join walls that one line explains, in place: the pieces beside a door are one line.

    Returns whether there were any.
    """
    merged = False
    bound = max(1.5 * sigma, BEND)
    members = np.empty(x.size, np.int64)
    for a in range(walls.shape[0]):
        for b in range(a + 1, walls.shape[0]):
            if walls[a, 5] == 0 or walls[b, 5] == 0 or not may_be_one(walls[a], walls[b], sigma):
                continue
            mine = gather(owner, a, members)
            both = mine + gather(owner, b, members[mine:])
            fit = fit_line(x, y, members[:both], walls[a, 0])
            if (
                off_line(x, y, members[:mine], fit[0], fit[1]) < bound
                and off_line(x, y, members[mine:both], fit[0], fit[1]) < bound
                and is_wall(x, y, members[:both], fit, sigma)[0]
            ):
                for i in members[mine:both]:
                    owner[i] = a
                keep_wall(walls[a], fit, both)
                walls[b, 5] = 0
                merged = True
    return merged


@inlined
def share_points(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    gate: float,
    sigma: float,
    refit: bool,
    min_points: int,
) -> tuple[IntArray, IntArray]:
    """Give the points at the ends of walls to the wall that they are on and refit, in place.

    Free points within `gate` of a wall beside them join it. The walls that change are refitted, or
    all where `refit`. A wall that loses too many of its points keeps its fit but not the right to
    be a line. Returns what `members_of` does.
    """
    changed = np.empty(walls.shape[0], np.bool_)
    for round_ in range(ROUNDS):
        for k in range(walls.shape[0]):
            changed[k] = refit and round_ == 0
        moved = give_to_nearest(x, y, owner, walls, gate, changed)
        moved |= part_at_corners(x, y, owner, walls, gate_of(sigma), changed)
        if not moved and round_ > 0:
            break
        line, member = members_of(owner, walls, min_points)
        first = 0
        for k in range(walls.shape[0]):
            if walls[k, 5] >= min_points:
                count = int(walls[k, 5])
                if changed[k]:
                    fit = fit_line(x, y, member[first : first + count], walls[k, 0])
                    keep_wall(walls[k], fit, count)
                first += count
    return line, member


@helper
def give_to_nearest(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    gate: float,
    changed: BoolArray,
) -> bool:
    """Move each point near the end of its wall to the neighbouring wall if that is nearer.

    A free point goes to the nearest wall beside it that is within `gate`; 0 leaves it free. Counts
    the walls' points anew and marks those that changed; returns whether any did.
    """
    moved = False
    cos = np.empty(walls.shape[0])
    sin = np.empty(walls.shape[0])
    for k in range(walls.shape[0]):
        cos[k] = math.cos(walls[k, 0])
        sin[k] = math.sin(walls[k, 0])
    for i in range(x.size):
        own = owner[i]
        low = max(0, i - NEIGHBOURHOOD)
        high = min(x.size - 1, i + NEIGHBOURHOOD)
        if own < FREE or (own >= 0 and owner[low] == own == owner[high]):
            continue
        least = math.inf if own >= 0 else gate
        nearest = own
        before = -1
        for j in range(low, high + 1):
            k = owner[j]
            if k >= 0 and k != before:
                before = k
                error = abs(x[i] * cos[k] + y[i] * sin[k] - walls[k, 1])
                if error < least:
                    least = error
                    nearest = k
        if nearest != own:
            owner[i] = nearest
            if own >= 0:
                walls[own, 5] -= 1
                changed[own] = True
            walls[nearest, 5] += 1
            changed[nearest] = moved = True
    return moved
