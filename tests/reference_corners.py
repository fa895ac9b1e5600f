"""Slow, obvious twins of the kernels that mend walls already found."""

import math
from itertools import combinations

import numpy as np
import reference

FREE = -1


def normal(theta):
    """Return the unit normal of a line."""
    return np.array([math.cos(theta), math.sin(theta)])


def part_at_corners(points, owner, lines, gate, rules):
    """Twin of `part_at_corners`; `rules` are (points beside, least sine of a crossing)."""
    beside, least_sine = rules
    owner = owner.copy()
    last = None
    for first in range(len(points)):
        if owner[first] < 0:
            continue
        if last is not None and owner[last] != owner[first] and first - last <= beside:
            _part(points, owner, lines, (last, first), gate, least_sine)
        last = first
    return owner


def _part(points, owner, lines, ends, gate, least_sine):
    last, first = ends
    a, b = owner[last], owner[first]
    normals = np.array([normal(lines[k][0]) for k in (a, b)])
    if abs(np.linalg.det(normals)) < least_sine:
        return
    crossing = np.linalg.solve(normals, [lines[a][1], lines[b][1]])
    if (points[[last, first]] @ crossing <= 0).any():
        return  # behind the sensor
    # Bearings count from that of the crossing, so that none wraps where it matters.
    turn = np.arctan2(*crossing[::-1])
    bearing = (np.arctan2(points[:, 1], points[:, 0]) - turn + math.pi) % (2 * math.pi) - math.pi
    for past, way, old, new in ((first, -1, a, b), (last, 1, b, a)):
        side = np.arange(past + way, len(points) if way > 0 else -1, way)
        wrong = np.isin(owner[side], (old, FREE)) & (-way * bearing[side] > 0)
        for i in side[: len(side) if wrong.all() else wrong.argmin()]:
            if abs(points[i] @ normal(lines[new][0]) - lines[new][1]) < gate:
                owner[i] = new


def add_short_walls(points, beams, owner, counts, sigma, cut, rules):
    """Twin of `add_short_walls`: the owners afterwards.

    `rules` are (fewest free points, growth of a step that is no gap, `is_wall` of members).
    """
    fewest, max_growth, test = rules
    owner, counts = owner.copy(), list(counts)
    min_points = cut[0]
    for first, last in free_runs(owner):
        if not fewest <= last - first + 1 < min_points + fewest:
            continue
        sparing = [
            i
            for i in (first - 1, last + 1)
            if 0 <= i < len(points) and owner[i] >= 0 and counts[owner[i]] > min_points
        ]
        walls = []
        for more in ((), *combinations(sparing, 1), sparing):
            if any(
                counts[owner[i]] - list(owner[list(more)]).count(owner[i]) < min_points
                for i in more
            ):
                continue
            members = np.sort([*range(first, last + 1), *more]).astype(int)
            if len(members) < min_points:
                continue
            theta, flat, variance = test(points, members, sigma)
            along = points[members] @ (-math.sin(theta), math.cos(theta))
            if flat and not broken(along, beams[members], cut, max_growth):
                walls.append((variance, members))
        if walls:
            members = min(walls, key=lambda wall: wall[0])[1]
            for k in owner[members]:
                if k >= 0:
                    counts[k] -= 1
            counts.append(len(members))
            owner[members] = len(counts) - 1
    return owner


def broken(along, beams, cut, max_growth):
    """Tell whether a step between successive points of a wall is a gap or misses too many beams."""
    _, max_missed, max_gap = cut
    apart = np.diff(beams)
    spacing = min(abs(np.diff(along)) / apart)
    return max(apart) > max_missed + 1 or any(
        reference.is_gap(along, beams, i, i + 1, spacing, max_missed, max_gap, max_growth)
        for i in range(len(along) - 1)
    )


def free_runs(owner):
    """Return the first and last of each run of free points."""
    free = np.concatenate([[False], np.asarray(owner) == FREE, [False]])
    edges = np.flatnonzero(np.diff(free.astype(int)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def drop_crumbs(owner, member, support, min_points):
    """Twin of `drop_crumbs`: the owners afterwards, and the walls to be fitted anew."""
    owner = owner.copy()
    touched = set()
    for piece in np.split(member, np.cumsum(support).astype(int)[:-1]):
        if len(piece) < min_points:
            touched |= set(owner[piece].tolist())
            owner[piece] = FREE
    return owner, {k for k in touched if (owner == k).sum() >= min_points}


def widen(points, line, member, lines, sigma, rules):
    """Twin of `widen`: the factor of each covariance; `rules` are (prior points, floor)."""
    prior, floor = rules
    factors = np.ones(len(lines))
    for k, (theta, d) in enumerate(lines):
        mine = points[member[line == k]]
        weight = reference.weights(mine, theta, floor)
        chi2 = (weight * (mine @ normal(theta) - d) ** 2).sum() / sigma**2
        factors[k] = max(1.0, (prior + chi2) / (prior + len(mine) - 2))
    return factors
