"""Slow, obvious twins of the raster's kernels."""

import math
from itertools import combinations

import numpy as np
import reference_candidates
import reference_engine


def is_near(a, b, incidence):
    """Twin of `is_near`: the bound of Borges and Aldon, from the angle between the beams."""
    r = sorted((math.hypot(*a), math.hypot(*b)))
    phi = abs(math.atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]))
    if phi >= incidence:
        return False
    return math.dist(a, b) <= r[0] * math.sin(phi) / math.sin(incidence - phi)


def behind(points, m, way, other, sigma, rules):
    """Twin of `behind`: the distance from a line, positive where the sensor is on its other side.

    `rules` are the kernel's (standard deviations, baseline).
    """
    noises, baseline = rules
    side = points[m + 1 :] if way > 0 else points[:m][::-1]
    away = np.hypot(*(side - points[m]).T)
    if not (away >= baseline).any():
        return 0.0, math.inf
    partner = side[np.argmax(away >= baseline)]
    along = (partner - points[m]) / math.dist(partner, points[m])
    normal = np.array([along[1], -along[0]])
    if normal @ points[m] < 0:  # it is to point away from the sensor, at the origin
        normal = -normal
    step = points[other] - points[m]
    ahead = math.hypot(*step) / math.dist(partner, points[m])
    return normal @ step, noises * sigma * (1 + 2 * ahead)


def how_joined(points, m, n, sigma, rules):
    """Twin of `how_joined`: whether a surface may be straight, and whether two meet between."""
    first, first_doubt = behind(points, m, -1, n, sigma, rules)
    second, second_doubt = behind(points, n, 1, m, sigma, rules)
    straight = abs(first) <= first_doubt or abs(second) <= second_doubt
    return straight, (first > 0) == (second > 0)


def follows(points, beams, m, n, incidence, sigma, max_missed, plain, rules):
    """Tell whether point n may follow point m on its surface; n is a later one."""
    if beams[n] - beams[m] > max_missed + 1:
        return False
    plainly = is_near(points[m], points[n], plain)
    if n > m + 1:
        return plainly and how_joined(points, m, n, sigma, rules)[0]
    if plainly or math.dist(points[m], points[n]) <= math.sqrt(2) * rules[0] * sigma:
        return True
    return is_near(points[m], points[n], incidence) and any(how_joined(points, m, n, sigma, rules))


def contours(points, beams, incidence, sigma, max_missed, plain, rules):
    """Twin of `contours`: each point followed by the first that may, chains of one left out."""
    chains = [[0]] if len(points) else []
    while chains and chains[-1][-1] < len(points) - 1:
        m = chains[-1][-1]
        later = [
            n
            for n in range(m + 1, len(points))
            if follows(points, beams, m, n, incidence, sigma, max_missed, plain, rules)
        ]
        if later:
            chains[-1].append(later[0])
        else:
            chains.append([m + 1])
    return [chain for chain in chains if len(chain) > 1]


def place(points, resolution, margin):
    """Twin of `place`: the origin, the size and the pixels, these as real numbers."""
    origin = points.min(axis=0) - margin * resolution
    pixels = (points - origin) / resolution
    size = np.ceil(np.ptp(points, axis=0) / resolution) + 1 + 2 * margin
    return origin, size, pixels


def seed_on(points, beams, line, gate, rules):
    """Twin of `seed_on`: the middle of the first of the longest runs near a line.

    `rules` are (least points of a run, beams missed in one, width of a gap).
    """
    theta, d = line
    least, max_missed, max_gap = rules
    near = np.flatnonzero(abs(points @ (math.cos(theta), math.sin(theta)) - d) < gate)
    along = points[near] @ (-math.sin(theta), math.cos(theta))
    wide = (np.diff(beams[near]) > max_missed + 1) & (abs(np.diff(along)) > max_gap)
    runs = np.split(near, np.flatnonzero(wide) + 1)
    longest = max(runs, key=len)
    return longest[len(longest) // 2] if len(longest) >= least else -1


def propose(points, lines, gate, resolution, rules):
    """Twin of `propose`: each line gives walls as long as its longest run grows into one."""
    at, beams = reference_engine.xy(points), points.beam
    taken = np.zeros(len(at), bool)
    rows = []
    for theta, d in lines:
        grows = True
        while grows:
            free = np.flatnonzero(~taken)
            grows = False
            seed = -1
            if len(free) >= rules[0]:
                seed = seed_on(at[free], beams[free], (theta, d), gate, rules)
            if seed < 0:
                continue
            seed = free[seed]
            normal = math.cos(theta), math.sin(theta)
            line = *normal, at[seed] @ normal
            found = reference_candidates.grow(points, taken, seed, line, resolution, rules[1])
            if found[-1] > 0:
                grows = True
                rows.append(reference_candidates.row(found))
                taken = reference_candidates.taken_by(points, taken, found)
    return rows


def bins(points, lines, gate, resolution, step, rules, window):
    """Twin of `bins_on`: the lines that have a run of free points and repeat none before.

    Returned are (theta, d, covariance of a turn about the seed and a shift) and the points of each.
    """
    at = reference_engine.xy(points)
    left = np.arange(len(at))
    taken, rows = [], []
    for theta, d in lines:
        seed = seed_on(at[left], points.beam[left], (theta, d), gate, rules) if len(left) else -1
        if seed < 0 or repeats(theta, at[left[seed]], taken, step, resolution, window):
            continue
        near = abs(at[left] @ (math.cos(theta), math.sin(theta)) - d) < gate
        taken.append((theta, d))
        about = at[left[seed]] @ (-math.sin(theta), math.cos(theta))
        jacobian = np.array([[1.0, 0.0], [about, 1.0]])  # d = d' + about (theta - theta')
        spread = jacobian @ np.diag([step**2 / 12, resolution**2 / 12]) @ jacobian.T
        rows.append((theta, d, spread, left[near]))
        left = left[~near]
    return rows


def repeats(theta, point, lines, step, resolution, window):
    """Twin of `repeats`: directions are compared as axes, by the sine of their difference."""
    for other, d in lines:
        turn = math.asin(min(abs(math.sin(theta - other)), 1.0))
        off = abs(point @ (math.cos(other), math.sin(other)) - d)
        if turn < window * step and off < window * resolution:
            return True
    return False


def brightness(image, u, v):
    """Twin of `brightness`: the mean of the four pixels around, weighted by their nearness."""
    height, width = image.shape
    corners = [(math.floor(v) + j, math.floor(u) + i) for j in (0, 1) for i in (0, 1)]
    if not all(0 <= row < height and 0 <= column < width for row, column in corners):
        return 0.0
    return sum(
        (1 - abs(v - row)) * (1 - abs(u - column)) * float(image[row, column])
        for row, column in corners
    )


def turn_of(ring, least):
    """Twin of `turn_of`: tops of the parabolas through each maximum, most right-angled pair."""
    n = len(ring)
    tops = []
    for k in range(n):
        values = [ring[k - 1], ring[k], ring[(k + 1) % n]]
        if values[1] >= least and values[1] >= values[0] and values[1] > values[2]:
            a, b, _ = np.polyfit([-1, 0, 1], values, 2)
            tops.append((k - b / (2 * a)) * 2 * math.pi / n)
    angles = [abs((a - b + math.pi) % (2 * math.pi) - math.pi) for a, b in combinations(tops, 2)]
    if not angles:
        return -1.0
    return math.pi - min(angles, key=lambda angle: abs(angle - math.pi / 2))


def structure(image, point, window):
    """Twin of `structure`: g g^T summed over the square around the nearest pixel."""
    gy, gx = np.gradient(image.astype(float))
    column, row = np.round(point).astype(int)
    total = np.zeros((2, 2))
    for y in range(row - window, row + window + 1):
        for x in range(column - window, column + window + 1):
            if 0 < y < image.shape[0] - 1 and 0 < x < image.shape[1] - 1:
                g = np.array([gx[y, x], gy[y, x]])
                away = (x - point[0]) ** 2 + (y - point[1]) ** 2
                total += math.exp(-away / window**2) * np.outer(g, g)
    return total


def distinct(points, reach):
    """Twin of `distinct`."""
    kept = []
    for k in range(len(points)):
        if all(math.dist(points[k], points[other]) >= reach[k] for other in kept):
            kept.append(k)
    return [k in kept for k in range(len(points))]
