"""Slow, obvious twins of the kernels that grow, test and share out walls."""

import math

import numpy as np
import reference


def is_arc(points, sigma, max_radius, flat, small, evidence):
    """Twin of `is_arc`: the circle of Kasa by a linear solver, the line by eigenvalues."""
    alone = np.linalg.norm(np.ptp(points, axis=0)) < small
    n = len(points)
    away = points - points.mean(axis=0)
    off_line = np.linalg.eigvalsh(away.T @ away)[0] / (n - 2)
    if off_line < flat**2 and not alone:
        return False
    # x^2 + y^2 = 2 cx x + 2 cy y + (r^2 - cx^2 - cy^2)
    solution = np.linalg.lstsq(
        np.column_stack([2 * away, np.ones(n)]), (away**2).sum(axis=1), rcond=None
    )[0]
    centre = solution[:2] + points.mean(axis=0)
    radius = math.sqrt(solution[2] + solution[:2] @ solution[:2])
    bulges_away = np.linalg.norm(centre) < np.linalg.norm(points.mean(axis=0))
    if radius > max_radius or bulges_away:
        return False
    squares = ((np.hypot(*(points - centre).T) - radius) ** 2).sum()
    off_circle = squares / max(n - 3, 1)
    if alone and off_line * (n - 2) - squares > (evidence * sigma) ** 2:
        return off_circle < max(flat, 1.7 * sigma) ** 2
    if off_line < flat**2:
        return False
    noisy = off_line > (1.5 * sigma) ** 2 and off_circle < (1.7 * sigma) ** 2
    return off_circle < flat**2 or noisy


def arcs(points, beams, sigma, jump, max_radius, rules):
    """Twin of `set_arcs_aside`: which points are on round objects.

    `rules` are the kernel's (width of a post, flatness, beams missed in one object, stray
    points in a round one, width of a small one, evidence that it is round).
    """
    post, flat, max_missed, max_stray, *alone = rules
    aside = np.zeros(len(points), bool)
    for group in objects(points, beams, jump, max_missed):
        if len(group) < 4 or group[-1] - group[0] + 1 - len(group) > max_stray:
            continue
        across = np.linalg.norm(points[group[-1]] - points[group[0]])
        size = np.linalg.norm(np.ptp(points[group], axis=0))
        small = across < post and size < 4 * post
        wide = size >= 2.5 * max_radius
        aside[group] = small or (
            not wide and is_arc(points[group], sigma, max_radius, flat, *alone)
        )
    return aside


def objects(points, beams, jump, max_missed):
    """Return the points of each object: each is near the one before and few beams after it.

    What jumps out of an object and back is on none.
    """
    groups = [[]]
    i = 0
    while i < len(points):
        groups[-1].append(i)
        near = np.hypot(*(points - points[i]).T) <= jump
        soon = (beams > beams[i]) & (beams <= beams[i] + max_missed + 1)
        nexts = np.flatnonzero(near & soon)
        i = int(nexts[0]) if len(nexts) else i + 1
        if not len(nexts):
            groups.append([])
    return groups


def estimate_sigma(points, baseline):
    """Twin of `estimate_sigma` on few points, before its limits; None under eight chords."""
    noise = []
    for i in range(1, len(points) - 1):
        away = np.linalg.norm(points - points[i], axis=1) >= baseline
        a = max(np.flatnonzero(away[:i]), default=0)
        b = i + 1 + min(np.flatnonzero(away[i + 1 :]), default=len(points) - 2 - i)
        chord = points[b] - points[a]
        length = np.linalg.norm(chord)
        if length == 0:
            continue
        normal = np.array([-chord[1], chord[0]]) / length
        share = (points[i] - points[a]) @ chord / length**2
        incidence = abs(points[i] @ normal) / np.linalg.norm(points[i])
        if incidence > 0.2 and 0 < share < 1:
            # The point's own noise, and that of the chord beside it.
            deviation = math.sqrt(1 + share**2 + (1 - share) ** 2)
            noise.append(abs((points[i] - points[a]) @ normal) / incidence / deviation)
    return sorted(noise)[len(noise) // 2] / 0.6745 if len(noise) >= 8 else None


def walk(points, beams, free, start, way, line, gate, max_missed, max_gap, max_growth):
    """Twin of `walk`: the free inliers from `start` (not itself) to the first gap.

    The spacing at the start is that to the inlier on its other side, if there is one.
    """
    theta, d = line
    along = points @ (-math.sin(theta), math.cos(theta))
    inlier = free & (abs(points @ (math.cos(theta), math.sin(theta)) - d) < gate)
    beside = start - way
    spacing = math.inf
    if 0 <= beside < len(points) and inlier[beside]:
        spacing = abs(along[beside] - along[start]) / abs(beams[beside] - beams[start])
    run = [start]
    side = np.arange(start + way, len(points) if way > 0 else -1, way)
    for i in side[inlier[side]]:
        last = run[-1]
        if reference.is_gap(along, beams, last, i, spacing, max_missed, max_gap, max_growth):
            break
        spacing = abs(along[i] - along[last]) / abs(beams[i] - beams[last])
        run.append(int(i))
    return run[1:]


def grow(points, beams, free, seed, *rest):
    """Twin of `grow`: the seed, what lies before it and what lies after it."""
    return [
        seed,
        *walk(points, beams, free, seed, -1, *rest),
        *walk(points, beams, free, seed, 1, *rest),
    ]


def bend(points, line):
    """Return the quadratic term of points' distances along a line, and its standard error.

    The error is that for a unit noise of the distances.
    """
    theta, d = line
    along = points @ (-math.sin(theta), math.cos(theta))
    along -= along.mean()
    off = points @ (math.cos(theta), math.sin(theta)) - d
    design = np.column_stack([np.ones(len(along)), along, along**2])
    scale = np.linalg.norm(design, axis=0)
    q, r = np.linalg.qr(design / scale)
    return np.linalg.solve(r, q.T @ off)[2] / scale[2], 1 / abs(r[2, 2]) / scale[2]


def give_to_nearest(points, owner, lines, neighbourhood, gate):
    """Twin of `give_to_nearest`: each point in turn goes to the nearest wall of its neighbours.

    A free point (owner -1) does where that wall is nearer than the gate.
    """
    owner = owner.copy()
    for i, point in enumerate(points):
        low, high = max(0, i - neighbourhood), min(len(points) - 1, i + neighbourhood)
        if owner[i] < -1 or (owner[i] >= 0 and owner[low] == owner[i] == owner[high]):
            continue
        walls = [k for k in (owner[i], *owner[low : high + 1]) if k >= 0]
        off = [
            abs(point @ (math.cos(lines[k][0]), math.sin(lines[k][0])) - lines[k][1]) for k in walls
        ]
        if walls and (owner[i] >= 0 or min(off) < gate):
            owner[i] = walls[int(np.argmin(off))]
    return owner
