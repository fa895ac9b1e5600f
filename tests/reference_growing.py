"""Slow, obvious twins of region_growing's kernels."""

import math

import kernels
import numpy as np
import reference


def next_free(beams, free, i, last_beam):
    """Twin of `next_free`: the first free point after point i, no farther than a beam."""
    there = [j for j in range(i + 1, len(beams)) if free[j] and beams[j] <= last_beam]
    return there[0] if there else -1


def fit(points):
    """Return the unweighted fit to points, the variances for a unit noise."""
    return reference.fit_line(points, np.ones(len(points)), 1.0)


class Line:
    """The line through some points, and how well they tell where it is."""

    def __init__(self, points):
        away = points - points.mean(axis=0)
        self.centre, self.count = points.mean(axis=0), len(points)
        self.along = np.linalg.svd(away)[2][0]
        self.spread = ((away @ self.along) ** 2).sum()

    def holds(self, point, gate):
        """Tell whether a point is near, in view of the errors of the mean and of the slope."""
        along = (point - self.centre) @ self.along
        across = (point - self.centre) @ (-self.along[1], self.along[0])
        return abs(across) <= gate * math.sqrt(1 + 1 / self.count + along**2 / self.spread)


def grow_region(points, beams, free, seed, partner, gate, max_missed, max_gap, max_growth):
    """Twin of `grow_region`: the members.

    The line is fitted anew when 1, 2, 4, 8.. points have come since the first.
    """
    members = [seed, partner]
    spacing = math.dist(points[seed], points[partner]) / (beams[partner] - beams[seed])
    fitted = 0
    for i in range(partner + 1, len(points)):
        if len(members) > fitted and math.log2(len(members) - 1).is_integer():
            fitted = len(members)
            line = Line(points[members])
        last = members[-1]
        if beams[i] - beams[last] - 1 > max_missed:
            break
        if free[i] and line.holds(points[i], gate):
            along = points @ line.along
            if reference.is_gap(along, beams, last, i, spacing, max_missed, max_gap, max_growth):
                break
            spacing = abs(along[i] - along[last]) / (beams[i] - beams[last])
            members.append(i)
    return members


def refine(points, members, line, gate, min_points, floor):
    """Twin of `refine`: drop what is off the line and fit with weights, until nothing is."""
    members = list(members)
    while len(members) >= min_points:
        off = abs(points[members] @ (math.cos(line[0]), math.sin(line[0])) - line[1])
        if (off <= gate).all():
            break
        members = [i for i, far in zip(members, off > gate, strict=True) if not far]
        if len(members) >= min_points:
            w = reference.weights(points[members], line[0], floor)
            line = reference.fit_line(points[members], w, 1.0)
    return members, line


def search(points, beams, free, sigma, cut, rules):
    """Twin of `search`: the owners, the walls' fits and the noise; what is a wall the kernel says.

    `rules` are the kernel's (gate, growth, weights' floor, partners, degrees of freedom that are
    enough, least noise).
    """
    gate, growth, floor, partners, enough, least_noise = rules
    min_points, max_missed, max_gap = cut
    owner = np.where(free, -1, -2)
    fits, squares, freedom = [], 0.0, 0
    for seed in range(len(points) - 1):
        partner = seed
        for _ in range(partners):
            free = owner == -1
            if not free[seed]:
                break
            partner = next_free(beams, free, partner, beams[seed] + max_missed + 1)
            if partner < 0:
                break
            members = grow_region(
                points, beams, free, seed, partner, gate, max_missed, max_gap, growth
            )
            line = fit(points[members])
            if len(members) < min_points - 1:
                continue
            members, line = refine(points, members, line, gate, min_points - 1, floor)
            if len(members) < min_points - 1:
                continue
            flat, variance, _ = kernels.is_wall(points, np.array(members), line, sigma)
            if flat:
                owner[members] = len(fits)
                fits.append(line)
                squares += variance * (len(members) - 2)
                freedom += len(members) - 2
    if freedom >= enough:
        sigma = min(max(math.sqrt(squares / freedom), least_noise), 2 * sigma)
    return owner, fits, sigma
