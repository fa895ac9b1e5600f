"""Slow, obvious twins of split_and_merge's kernels."""

import math

import kernels
import numpy as np
import reference_growing


def linked(a, b, sigma, min_incidence, sigmas):
    """Twin of `linked`: no step larger than on a wall through a that the beams graze, and noise.

    The beams and that wall make a triangle: the law of sines gives the step along the wall.
    """
    turn = math.atan2(a[0] * b[1] - a[1] * b[0], a @ b)
    if turn >= min_incidence:
        return True  # such a wall never meets the second beam
    most = np.linalg.norm(a) * math.sin(turn) / math.sin(min_incidence - turn)
    return math.dist(a, b) <= most + sigmas * sigma


def next_chain(points, beams, free, start, max_missed, link):
    """Twin of `next_chain`: each point of a chain is linked to the one before.

    The next point of the scan may be any number of beams on: those between have no return. Points
    that are passed over count as missed beams.
    """
    while start < len(points) and not free[start]:
        start += 1
    if start == len(points):
        return [], start
    chain = [start]
    while True:
        last = chain[-1]
        near = [
            j
            for j in range(last + 1, len(points))
            if j == last + 1 or beams[j] - beams[last] <= max_missed + 1
        ]
        near = [j for j in near if free[j] and link(points[last], points[j])]
        if not near:
            return chain, last + 1
        chain.append(near[0])


def off_chord(points, chain):
    """Return the distances of the points of a chain from the chord through its ends."""
    ends = points[[chain[0], chain[-1]]]
    normal = np.array([ends[0, 1] - ends[1, 1], ends[1, 0] - ends[0, 0]])
    return abs((points[chain] - ends[0]) @ normal) / np.linalg.norm(normal)


def is_spike(points, chain, m, share):
    """Twin of `is_spike`: both neighbours are much nearer to the chord."""
    off = off_chord(points, chain)
    return max(off[m - 1], off[m + 1]) <= share * off[m]


def split(points, chain, sigma, gate, min_points, rules, shared=(False, False)):
    """Twin of `split`: the pieces that are walls, as (points, fit, points fitted, variance).

    `shared` tells whether the first and last point belong to the pieces beside as well. `rules` are
    the kernel's (gates of a sure corner, points from which shared ends are left out, share of a
    spike).
    """
    sure, trimmed, share = rules
    chain = list(chain)
    if len(chain) < min_points - 1:
        return []
    off = off_chord(points, chain)
    corner = int(np.argmax(off[1:-1])) + 1 if len(chain) > 2 else 0
    if off[corner] > gate and is_spike(points, chain, corner, share):
        rest = chain[:corner] + chain[corner + 1 :]
        return split(points, rest, sigma, gate, min_points, rules, shared)
    if off[corner] <= sure * gate:
        ends = [False, False] if len(chain) < trimmed else shared
        inner = np.array(chain[ends[0] : len(chain) - ends[1]])
        fit = reference_growing.fit(points[inner])
        distance = abs(points[inner] @ (math.cos(fit[0]), math.sin(fit[0])) - fit[1])
        if distance.max() <= gate:
            flat, variance, _ = kernels.is_wall(points, inner, fit, sigma)
            return [(chain, fit, inner, variance)] if flat else []
    rest = (sigma, gate, min_points, rules)
    return [
        *split(points, chain[: corner + 1], *rest, (shared[0], True)),
        *split(points, chain[corner:], *rest, (True, shared[1])),
    ]


def owners(count, walls):
    """Return the wall of each point; a corner that two pieces share is the later one's."""
    owner = np.full(count, -1)
    for k, (chain, *_) in enumerate(walls):
        owner[chain] = k
    return owner


def search(points, beams, free, sigma, cut, link, rules):
    """Twin of `search`: the walls of all chains, as `split` gives them, and the noise.

    `rules` are (gate, those of `split`, degrees of freedom that are enough, least noise).
    """
    gate, of_split, enough, least_noise = rules
    min_points, max_missed, _ = cut
    walls, start = [], 0
    while start < len(points):
        chain, start = next_chain(points, beams, free, start, max_missed, link)
        if len(chain) >= min_points - 1:
            walls += split(points, chain, sigma, gate, min_points, of_split)
    freedom = sum(len(inner) - 2 for _, _, inner, _ in walls)
    if freedom >= enough:
        squares = sum(variance * (len(inner) - 2) for _, _, inner, variance in walls)
        sigma = min(max(math.sqrt(squares / freedom), least_noise), 2 * sigma)
    return walls, sigma
