"""Slow, obvious twins of the engine's kernels: what each must compute, in plain NumPy."""

import math
from itertools import pairwise

import numpy as np
from reference_arcs import arc_misfit

from laserfeatures.engine import arcs, noise, sequence, walls
from laserfeatures.engine import partition as rules
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE

ARC, STRAY = rules.ARC, rules.STRAY


def xy(points):
    """Return the returns (P, 2) [m]."""
    return np.stack([points.x, points.y], axis=1)


def directions(points):
    """Return the unit vectors along the beams (P, 2)."""
    return np.stack([points.ux, points.uy], axis=1)


def order(scan, first=None):
    """Twin of `in_order`: the beams that returned, and as counted on past the last in a ring.

    Where several steps are the widest but for rounding, it is cut before the beam `first`.
    """
    beams = without_constant(scan)
    period = len(scan)
    if scan.ring == sequence.DOUBLED:
        period -= 1
        if len(beams) > 1 and beams[0] == 0 and beams[-1] == period:
            beams.pop()
    if scan.ring == sequence.OPEN or not beams:
        return beams, beams
    steps = []
    for m, beam in enumerate(beams):
        before = beams[m - 1]
        r, s = scan.ranges[before], scan.ranges[beam]
        turn = abs(math.sin(scan.angles[beam] - scan.angles[before]))
        jumps = abs(s - r) > sequence.GRAZING * min(r, s) * turn
        a, b = r * scan.directions[before], s * scan.directions[beam]
        steps.append((bool(jumps), float(np.hypot(*(b - a)))))
    jumps, widest = max(steps)
    ties = [m for m, step in enumerate(steps) if step[0] == jumps and step[1] > widest - 1e-9]
    start = next((m for m in ties if beams[m] == first), ties[0])
    before, after = beams[:start], beams[start:]
    return after + before, after + [beam + period for beam in before]


def without_constant(scan):
    """Twin of `without_constant`: the beams that returned, but a largest range too many times."""
    beams, ranges = scan.beams.tolist(), scan.ranges[scan.beams]
    farthest = ranges.max(initial=0.0)
    changes = abs(np.diff(np.append(0.0, ranges)))
    resolution = changes[changes > 1e-9 * ranges].min(initial=math.inf)
    constant = (ranges == farthest).sum()
    turn = constant * math.sin(scan.angles[1] - scan.angles[0])
    if constant < sequence.OFTEN or farthest * turn**2 / 8 <= sequence.STEPS * resolution:
        return beams
    return [beam for beam in beams if scan.ranges[beam] < farthest]


def weigh(points, sigma, relative, roughness):
    """Twin of `weigh`: variance, weight, floor and jump."""
    ranges = np.hypot(points.x, points.y)
    variance = sigma**2 + (relative * ranges) ** 2
    floor = sequence.INCIDENCE_FLOOR + roughness**2 / variance
    ways = directions(points)
    jump = [
        steps_off(ranges, ways, variance, points.beam, (i - 1, i)) for i in range(1, len(ranges))
    ]
    return variance, ranges**2 / variance, floor, np.array([True, *jump][: len(ranges)])


def steps_off(ranges, ways, variance, beams, pair):
    """Tell whether the step between two returns is a jump."""
    i, j = pair
    turn = abs(np.linalg.det(ways[[i, j]]))
    more = abs(ranges[j] - ranges[i]) - sequence.GRAZING * min(ranges[i], ranges[j]) * turn
    missed = beams[j] - beams[i] > sequence.MISSED
    return missed or more > sequence.NOISES * math.sqrt(variance[i] + variance[j])


def without_lone(points):
    """Twin of `without_lone`: which returns stay, and where they jump."""
    at, jump = xy(points), points.jump.copy()
    ranges = np.hypot(*at.T)
    stay = []
    for i in range(len(at)):
        if 0 < i < len(at) - 1 and jump[i] and jump[i + 1]:
            before, after, over = (
                np.linalg.norm(at[a] - at[b]) for a, b in ((i, i - 1), (i, i + 1), (i + 1, i - 1))
            )
            if min(before, after) > sequence.LONE * over:
                pair = (i - 1, i + 1)
                jump[i + 1] = steps_off(
                    ranges, directions(points), points.variance, points.beam, pair
                )
                continue
        stay.append(i)
    return stay, jump[stay]


def fit(points, members, keep=1.0):
    """Return (A, B), its covariance and chi squared: weighted least squares in inverse range.

    `keep` is the share of each return's weight that counts.
    """
    at = xy(points)[members]
    ranges = np.hypot(*at.T)
    weight = np.sqrt(keep * ranges**4 / points.variance[members])  # of 1/r
    design = weight[:, None] * directions(points)[members]
    inverse = weight / ranges
    solution = np.linalg.lstsq(design, inverse, rcond=None)[0]
    chi2 = ((inverse - design @ solution) ** 2).sum()
    return solution, np.linalg.inv(design.T @ design), chi2


def line(solution):
    """Return (theta, d) of (A, B), with theta in [0, pi)."""
    theta, d = math.atan2(solution[1], solution[0]), 1 / math.hypot(*solution)
    return (theta, d) if 0 <= theta < math.pi else (theta % math.pi, -d)


def line_covariance(solution, covariance, step=1e-6):
    """Return the covariance of (theta, d) through a numerical Jacobian."""
    jacobian = np.empty((2, 2))
    for i in range(2):
        change = step * np.linalg.norm(solution) * (np.arange(2) == i)
        high, low = (
            np.array([math.atan2(b, a), 1 / math.hypot(a, b)])
            for a, b in (solution + change, solution - change)
        )
        jacobian[:, i] = (high - low) / (2 * change[i])
    jacobian[1] *= math.copysign(1, line(solution)[1])
    return jacobian @ covariance @ jacobian.T


def wall_misfit(points, i, j):
    """Twin of `wall_misfit`: chi squared less what grazing incidence explains, and the latter."""
    members = np.arange(i, j)
    solution, _, chi2 = fit(points, members)
    weight = 1 / points.variance[members]
    cosine = abs(line(solution)[1]) / np.hypot(*xy(points)[members].T)
    oblique = np.average(1 / cosine**2, weights=weight)
    return chi2 / (1 + np.average(points.floor[members], weights=weight) * oblique), oblique


def chi_squared(points, line_):
    """Return chi squared (P,) of returns on a line (c, s, d)."""
    c, s, d = line_
    cosine = directions(points) @ (c, s)
    return (xy(points) @ (c, s) - d) ** 2 / (points.variance * (cosine**2 + points.floor))


def wall_cost(points, i, j):
    """Return what a wall through returns i..j-1 costs."""
    misfit, oblique = wall_misfit(points, i, j)
    return misfit + PRICE + rules.OBLIQUE * math.log(oblique)


def objects(points):
    """Return first and last + 1 of the returns between jumps."""
    edges = [0, *(np.flatnonzero(points.jump[1:]) + 1).tolist(), len(points.x)]
    return list(pairwise(edges)) if len(points.x) else []


def partition_cost(points, lines, limits, price=PRICE, columns=()):
    """Twin of `partition`: the least cost of an explanation, by trying each wall and object.

    `price` is that of a line that was proposed.
    """
    n = len(points.x)
    whole = [*objects(points), *columns]
    chi2 = np.array([chi_squared(points, each[:3]) for each in lines]).reshape(len(lines), n)
    near = np.array(
        [
            [first - rules.PAD <= i < last + rules.PAD for i in range(n)]
            for _, _, _, first, last in lines
        ]
    ).reshape(len(lines), n)
    least = np.where(near, chi2, STRAY_PRICE).min(axis=0, initial=STRAY_PRICE)
    doubt = np.concatenate([[0], np.cumsum(np.maximum(least - rules.DOUBTFUL, 0))])
    through = np.full(len(lines), math.inf)
    cost = [0.0]
    for j in range(1, n + 1):
        ends = [cost[j - 1] + STRAY_PRICE]
        through = np.minimum(through, cost[j - 1] + price)
        through = np.where(
            near[:, j - 1], through + np.minimum(chi2[:, j - 1], STRAY_PRICE), math.inf
        )
        ends += through.tolist()
        ends += [
            cost[i] + wall_cost(points, i, j)
            for i in range(max(0, j - limits.longest), j - limits.min_points + 1)
            if not len(lines) or doubt[j] - doubt[i] >= rules.DOUBT
        ]
        ends += [
            cost[i] + ARC_PRICE + arc_misfit(points, i, j, limits.max_pole_radius)
            for i, end in whole
            if end == j and j - i >= arcs.SHORTEST_ARC and limits.max_pole_radius > 0
        ]
        cost.append(min(ends))
    return cost[-1]


def explanation_cost(points, label, lines, limits, price=PRICE, columns=()):
    """Return what an explanation by labels costs."""
    cost = STRAY_PRICE * (label == STRAY).sum()
    edges = np.flatnonzero(np.diff(label, prepend=-9, append=-9))
    for i, j in pairwise(edges):
        k = label[i]
        if k >= len(lines):
            cost += wall_cost(points, i, j)
        elif k >= 0:
            chi2 = chi_squared(points, lines[k][:3])[i:j]
            cost += price + np.minimum(chi2, STRAY_PRICE).sum()
    return cost + arcs_cost(points, label, sorted([*objects(points), *columns]), limits)


def arcs_cost(points, label, whole, limits):
    """Return what the round objects of an explanation cost: the cheapest that make them up."""
    least = np.zeros(len(label) + 1)  # of those among the first returns
    for j in range(1, len(label) + 1):
        if label[j - 1] != ARC:
            least[j] = least[j - 1]
            continue
        least[j] = min(
            (
                least[i] + ARC_PRICE + arc_misfit(points, i, j, limits.max_pole_radius)
                for i, end in whole
                if end == j and (label[i:j] == ARC).all()
            ),
            default=math.inf,
        )
    return least[-1]


def part_at_corners(points, label, lines):
    """Twin of `part_at_corners`: lines (K, 3) of (c, s, d)."""
    label = label.copy()
    last = None
    for first in range(len(label)):
        if label[first] < 0:
            continue
        if last is not None and label[last] != label[first] and first - last <= walls.MEETING:
            _part(points, label, lines, (last, first))
        last = first
    return label


def _part(points, label, lines, ends):
    last, first = ends
    a, b = label[last], label[first]
    normals = lines[[a, b], :2]
    if abs(np.linalg.det(normals)) < walls.LEAST_SINE:
        return
    crossing = np.linalg.solve(normals, lines[[a, b], 2])
    if (xy(points)[[last, first]] @ crossing <= 0).any():
        return  # behind the sensor
    # Bearings count from that of the crossing, so that none wraps where it matters.
    turn = math.atan2(crossing[1], crossing[0])
    bearing = (np.arctan2(points.uy, points.ux) - turn + math.pi) % (2 * math.pi) - math.pi
    for past, way, old, new in ((first, -1, a, b), (last, 1, b, a)):
        side = np.arange(past + way, len(label) if way > 0 else -1, way)
        wrong = np.isin(label[side], (old, STRAY)) & (-way * bearing[side] > 0)
        for i in side[: len(side) if wrong.all() else wrong.argmin()]:
            if chi_squared(points, lines[new])[i] < walls.INLIER:
                label[i] = new


def evidence(points, label, lines, k):
    """Return the evidence of wall k of two [nats]: the scan with it, and without."""
    stray = np.full(len(label), STRAY_PRICE)
    chi2 = [np.minimum(chi_squared(points, each), stray) for each in lines]
    mine = label == k
    return max((chi2[1 - k] - chi2[k])[mine].sum() - PRICE, 0) / 2


def stretch_errors(points, i):
    """Return the errors of the ranges of a stretch about its line [m]."""
    stretch = slice(i, i + noise.STRETCH)
    weight = np.hypot(points.x, points.y)[stretch]
    seen = weight[:, None] * np.stack([points.x, points.y], axis=1)[stretch]
    normal, *_ = np.linalg.lstsq(seen, weight, rcond=None)
    return weight - seen @ normal


def stretch_noise(points, i):
    """Return the variance of a stretch's ranges about its line [m^2], and von Neumann's ratio.

    That is without the part of a parabola that the stretch before has, too.
    """
    error = stretch_errors(points, i)
    before = stretch_errors(points, i - noise.STRETCH) if i else np.zeros(noise.STRETCH)
    parabola = (np.arange(noise.STRETCH) - 3.5) ** 2
    parabola -= parabola.mean()
    bend, bend_before = (parabola @ each / np.linalg.norm(parabola) for each in (error, before))
    curved = np.clip(bend * bend_before, 0, bend**2)
    steps = (np.diff(error) ** 2).sum() - noise.PARABOLA * curved
    square = (error**2).sum()
    return square / noise.FREEDOM, steps / (square - curved)
