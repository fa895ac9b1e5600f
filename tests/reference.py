"""Slow, obvious twins of the core's kernels: what each must compute, in plain Python and NumPy."""

import math

import numpy as np


def returns(angles, ranges, range_min, range_max):
    """Twin of `LaserScan.points` and `beams`: one beam after another."""
    points, beams = [], []
    for i, (angle, r) in enumerate(zip(angles, ranges, strict=True)):
        if math.isfinite(r) and r > 0 and range_min <= r < range_max:
            points.append((r * math.cos(angle), r * math.sin(angle)))
            beams.append(i)
    return np.array(points).reshape(-1, 2), np.array(beams, dtype=int)


def fit_line(points, w, sigma):
    """Return the line of least squares: the smallest eigenvector of the weighted scatter matrix."""
    centre = np.average(points, axis=0, weights=w)
    away = points - centre
    values, vectors = np.linalg.eigh((w[:, None] * away).T @ away)
    normal = vectors[:, 0]
    theta, d = math.atan2(normal[1], normal[0]), float(centre @ normal)
    if theta < 0:
        theta, d = theta + math.pi, -d
    if theta >= math.pi:
        theta, d = theta - math.pi, -d
    # The line turns about its centre: d has the error of the centre and that of the turn.
    lever = centre @ (-math.sin(theta), math.cos(theta))
    var_theta = sigma**2 / values[1]
    return theta, d, var_theta, lever * var_theta, sigma**2 / w.sum() + lever**2 * var_theta


def split_run(along, beams, max_missed, max_gap, max_growth):
    """Split the points of a line, in order, at its gaps; return lists of their places."""
    pieces = []
    steps = np.abs(np.diff(along)) / np.diff(beams)
    before = math.inf
    for i in range(len(along)):
        if i > 0:
            beside = min(before, steps[i] if i < len(steps) else math.inf)
            if not is_gap(along, beams, i - 1, i, beside, max_missed, max_gap, max_growth):
                pieces[-1].append(i)
                before = steps[i - 1]
                continue
        pieces.append([i])
        before = math.inf
    return pieces


def is_gap(along, beams, i, j, spacing, max_missed, max_gap, max_growth):
    """Tell whether the way from point i to j is wide, and misses beams or jumps."""
    way, apart = abs(along[j] - along[i]), abs(beams[j] - beams[i])
    return way > max_gap and (apart - 1 > max_missed or way > max_growth * apart * spacing)


def cut_segments(points, beams, lines, members, max_missed, max_gap, max_growth):
    """Twin of `cut_segments`: a list of (line, ends, beams held, rms)."""
    segments = []
    for k, (theta, d) in enumerate(lines):
        normal = np.array([math.cos(theta), math.sin(theta)])
        mine = np.flatnonzero(members[k])
        along = points[mine] @ (-normal[1], normal[0])
        for piece in split_run(along, beams[mine], max_missed, max_gap, max_growth):
            held = mine[piece]
            errors = points[held] @ normal - d
            ends = [points[i] - (points[i] @ normal - d) * normal for i in (held[0], held[-1])]
            segments.append((k, ends, beams[held], math.sqrt(np.mean(errors**2))))
    return segments


def is_copy(segments, better, worse, copy_distance):
    """Tell whether a segment shares half of its points with a better one, or runs over it."""
    mine, other = segments.points[worse], segments.points[better]
    if 2 * (mine & other).sum() >= mine.sum():
        return True
    start, end = segments.endpoints[better]
    length = np.linalg.norm(end - start)
    if length == 0:
        return False
    unit = (end - start) / length
    low, high = sorted((segments.endpoints[worse] - start) @ unit)
    away = segments.endpoints[worse].mean(axis=0) - start
    apart = abs(unit[0] * away[1] - unit[1] * away[0])
    common = min(high, length) - max(low, 0.0)
    return common > 0 and common >= (high - low) / 2 and apart < copy_distance


def reliable(segments, stage):
    """Twin of `SegmentFilter`: the indices of the segments that stay."""
    stay = [
        j
        for j in range(len(segments))
        if segments.support[j] >= stage.min_points
        and segments.rms[j] <= stage.max_error
        and segments.lines.evidence[segments.line[j]] >= stage.min_evidence
    ]
    for a in range(len(segments)):
        for b in range(a + 1, len(segments)):
            if a not in stay or b not in stay or segments.line[a] == segments.line[b]:
                continue
            theta = segments.lines.theta[segments.line[[a, b]]]
            if abs(math.sin(theta[1] - theta[0])) >= math.sin(stage.min_angle):
                continue
            rank = {j: (-segments.support[j], segments.rms[j], j) for j in (a, b)}
            better, worse = sorted((a, b), key=rank.get)
            if is_copy(segments, better, worse, stage.copy_distance):
                stay.remove(worse)
    return stay


def crossing(lines):
    """Return where two lines (theta_a, d_a, theta_b, d_b) cross."""
    ta, da, tb, db = lines
    return np.linalg.solve([[math.cos(ta), math.sin(ta)], [math.cos(tb), math.sin(tb)]], [da, db])


def crossing_covariance(lines, covariance_a, covariance_b, step=1e-6):
    """Return the covariance of a crossing, carried through a numerical Jacobian."""
    jacobian = np.empty((2, 4))
    for i in range(4):
        change = step * (np.arange(4) == i)
        jacobian[:, i] = (crossing(lines + change) - crossing(lines - change)) / (2 * step)
    spread = np.zeros((4, 4))
    spread[:2, :2], spread[2:, 2:] = covariance_a, covariance_b
    return jacobian @ spread @ jacobian.T


def reaches(point, spread, segments, k, reach):
    """Tell whether one of line k's segments holds a corner on the line, or ends near it."""
    theta, d = segments.lines.theta[k], segments.lines.d[k]
    way = np.array([-math.sin(theta), math.cos(theta)])
    sigma = math.sqrt(way @ spread @ way)
    for j in np.flatnonzero(segments.line == k):
        a, b = segments.endpoints[j]
        if (point - a) @ (point - b) <= 0:
            return True
        bearings = np.arctan2(*segments.endpoints[j].T[::-1])
        turn = abs((bearings[1] - bearings[0] + math.pi) % (2 * math.pi) - math.pi)
        per_beam = turn / max(segments.support[j] - 1, 1)
        for end in (a, b):
            outward = way if way @ (point - end) > 0 else -way
            bearing = math.atan2(outward @ end, abs(d)) + per_beam  # of the next beam
            unseen = math.inf
            if bearing < math.pi / 2:
                unseen = abs(d) * math.tan(bearing) - outward @ end
            more = min(unseen + 2 * sigma, np.linalg.norm(b - a) / 2)
            if np.linalg.norm(point - end) <= reach + more:
                return True
    return False


def corners(segments, stage):
    """Twin of `Intersections`: a list of (position, covariance, lines, angle, real, evidence)."""
    lines = segments.lines
    far = math.inf if stage.max_distance is None else stage.max_distance
    found = []
    for a in range(len(lines)):
        for b in range(a + 1, len(lines)):
            turn = (lines.theta[b] - lines.theta[a]) % math.pi
            angle = min(turn, math.pi - turn)
            if angle < max(stage.min_angle, 1e-9):
                continue
            both = np.array([lines.theta[a], lines.d[a], lines.theta[b], lines.d[b]])
            point = crossing(both)
            spread = crossing_covariance(both, lines.covariance[a], lines.covariance[b])
            if np.hypot(*point) > far:
                continue
            if np.linalg.eigvalsh(spread)[1] > stage.max_sigma**2:
                continue
            real = all(reaches(point, spread, segments, k, stage.reach) for k in (a, b))
            evidence = corner_evidence(point, spread, segments, (a, b), far)
            found.append((point, spread, (a, b), angle, real, evidence))
    return found


def corner_evidence(point, spread, segments, pair, far):
    """Return how much likelier a corner is at its place than anywhere, by the evidence of both."""
    weaker, stronger = sorted(segments.lines.evidence[list(pair)])
    if far == math.inf:
        far = np.linalg.norm(segments.endpoints, axis=-1).max(initial=0)
    if weaker == 0 or far == 0:
        return 0.0
    sigma = math.sqrt(np.linalg.eigvalsh(spread)[1])
    ends = segments.endpoints[np.isin(segments.line, pair)]
    gap = min((distance_to(point, *piece) for piece in ends), default=math.inf)
    anywhere, here = math.pi * far**2, 2 * math.pi * sigma * (gap + sigma)
    odds = anywhere / here * weaker * math.sqrt(stronger)
    return math.log(odds) if odds > 1 else 0.0


def distance_to(point, start, end):
    """Return how far a point is from a segment."""
    way = end - start
    share = np.clip((point - start) @ way / max(way @ way, 1e-300), 0, 1)
    return np.linalg.norm(point - start - share * way)


def cast(walls, x, y, angle):
    """Twin of `Scanner.cast` for one ray: its range and the wall it hits, (inf, -1) where none."""
    nearest, number = math.inf, -1
    for k, (start, end) in enumerate(walls):
        matrix = np.column_stack([(math.cos(angle), math.sin(angle)), start - end])
        if abs(np.linalg.det(matrix)) < 1e-15:
            continue
        r, share = np.linalg.solve(matrix, start - (x, y))
        if r > 0 and 0 <= share <= 1 and r < nearest:
            nearest, number = r, k
    return nearest, number
