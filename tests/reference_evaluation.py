"""Slow, obvious twins of `laserfeatures.evaluation`: points and vectors instead of (theta, d)."""

import math
from itertools import combinations, permutations

import numpy as np


def truth(sides, surface, pose):
    """Twin of `truth_of`, in the world's frame: lines of beams, pairs, corners, and which are real.

    `sides` (S, 2, 2) are the straight surfaces, `surface` (N,) the number of each beam's or -1.
    """
    groups = []
    for k, side in enumerate(sides):
        mine = [group for group in groups if on_line(side, sides[group[0]])]
        (mine[0] if mine else groups.append([]) or groups[-1]).append(k)
    hit = [int(k) for k in surface if 0 <= k < len(sides)]
    kept = [group for group in groups if sum(k in group for k in hit) >= 4]
    line = [next((n for n, group in enumerate(kept) if k in group), -1) for k in surface]
    pairs, corners, real = [], [], []
    for i, j in combinations(range(len(kept)), 2):
        corner = crossing(sides[kept[i][0]], sides[kept[j][0]])
        if corner is None or math.dist(corner, (pose.x, pose.y)) > 20:
            continue
        pairs.append((i, j))
        corners.append(corner)
        real.append(
            all(
                min(distance(corner, sides[k]) for k in kept[n] if k in hit) <= 1e-3 for n in (i, j)
            )
        )
    return line, pairs, corners, real


def on_line(side, other):
    """Tell whether both ends of a side lie on the line through another."""
    (ax, ay), (bx, by) = other
    length = math.hypot(bx - ax, by - ay)
    return all(abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / length < 1e-6 for x, y in side)


def crossing(side, other):
    """Return where the lines through two sides cross, or None if at less than 15 degrees."""
    u, v = side[1] - side[0], other[1] - other[0]
    if math.degrees(math.acos(min(abs(u @ v) / math.hypot(*u) / math.hypot(*v), 1))) < 15:
        return None
    share, _ = np.linalg.solve(np.stack([u, -v], axis=1), other[0] - side[0])
    return side[0] + share * u


def distance(point, side):
    """Return the distance of a point from a side of finite length."""
    along = side[1] - side[0]
    length = math.hypot(*along)
    way = (point - side[0]) @ along / length
    return math.dist(point, side[0] + min(max(way, 0), length) * along / length)


def best_pairs(weight, allowed):
    """Return how many pairs the best one-to-one choice has, and its total weight.

    The best has the most pairs and, of those with as many, the least total; all are tried.
    """
    if len(weight) > len(weight[0] if len(weight) else ()):
        weight, allowed = weight.T, allowed.T
    best = (0, 0.0)
    for chosen in permutations(range(weight.shape[1]), len(weight)):
        pairs = [(i, j) for i, j in enumerate(chosen) if allowed[i, j]]
        best = min(best, (-len(pairs), sum(weight[pair] for pair in pairs)))
    return -best[0], best[1]
