"""Slow, obvious twins of what finds round objects: circles by NumPy, columns one by one."""

import math

import numpy as np

from laserfeatures.engine import arcs, columns
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE


def algebraic_circle(points, i, j):
    """Return centre and radius of the algebraic least-squares circle (Kasa)."""
    at = np.stack([points.x, points.y], axis=1)[i:j]
    weight = 1 / np.sqrt(points.variance[i:j])
    middle = at.mean(axis=0)
    away = at - middle
    # u^2 + v^2 = 2 cu u + 2 cv v + (r^2 - cu^2 - cv^2)
    design = weight[:, None] * np.column_stack([2 * away, np.ones(j - i)])
    solution = np.linalg.lstsq(design, weight * (away**2).sum(axis=1), rcond=None)[0]
    return solution[:2] + middle, math.sqrt(solution[2] + solution[:2] @ solution[:2])


def nearest_circle(points, i, j, centre, radius):
    """Twin of `nearest_circle`: Gauss-Newton steps, each a least-squares problem of its own."""
    at = np.stack([points.x, points.y], axis=1)[i:j]
    weight = 1 / np.sqrt(points.variance[i:j])
    for _ in range(arcs.CIRCLE_FITS):
        away = centre - at
        distance = np.linalg.norm(away, axis=1)
        radius = np.average(distance, weights=weight**2)
        # distance + unit * step is the new radius
        design = weight[:, None] * np.column_stack([away / distance[:, None], -np.ones(j - i)])
        x, y, more = np.linalg.lstsq(design, weight * (radius - distance), rcond=None)[0]
        centre, radius = centre + np.array([x, y]), radius + more
        if math.hypot(x, y) < arcs.SETTLED * (radius - more):
            break
    return centre, radius


def circle_misfit(points, i, j, centre, radius, max_radius, least):
    """Return chi squared of a circle, inf where too little of it is seen."""
    at = np.stack([points.x, points.y], axis=1)[i:j]
    along = np.stack([points.ux, points.uy], axis=1)[i:j]
    away = at - centre
    bearing = np.arctan2(away[:, 1], away[:, 0])
    middle = (j - i - 1) // 2
    turns = bearing[[middle, -1]] - bearing[[0, middle]]
    seen = abs((turns + math.pi) % (2 * math.pi) - math.pi).sum()
    convex = np.linalg.norm(centre) > np.linalg.norm(at[middle])
    if seen <= (least if convex else arcs.CONCAVE) or (convex and radius > max_radius):
        return math.inf
    cosine = (along * away).sum(axis=1) / radius
    off = np.linalg.norm(away, axis=1) - radius
    return (off**2 / points.variance[i:j]).sum() / np.mean(cosine**2 + points.floor[i:j])


def arc_misfit(points, i, j, max_radius, least=arcs.CONVEX):
    """Twin of `arc_misfit`: that of the algebraic circle, or of the nearest one if it is less."""
    circle = algebraic_circle(points, i, j)
    misfit = circle_misfit(points, i, j, *circle, max_radius, least)
    if misfit > arcs.HOPELESS * (j - i):
        return misfit
    circle = nearest_circle(points, i, j, *circle)
    return min(misfit, circle_misfit(points, i, j, *circle, max_radius, least))


def faces(label, walls, begin):
    """Return the walls that follow each other without a gap from a return on, FACES at the most."""
    found, end = [], begin
    while len(found) < columns.FACES and end < len(label) and label[end] >= 0:
        k = label[end]
        if walls["first"][k] != end or walls["last"][k] - begin > columns.MOST:
            break
        found.append(k)
        end = walls["last"][k]
    return found


def column_from(points, label, walls, begin, max_radius):
    """Twin of `column_from`: of all numbers of faces the one that saves the most."""
    follows = (label == STRAY) & ~points.jump.astype(bool)  # a return: goes on from the one before
    best, at = 0.0, (begin, begin)
    found = faces(label, walls, begin)
    for count in range(1, len(found) + 1):
        low, high = begin, walls["last"][found[count - 1]]
        strays = high - begin - walls["points"][found[:count]].sum()
        flat = count * PRICE + walls["chi2"][found[:count]].sum() + STRAY_PRICE * strays
        while low > 0 and label[low - 1] == STRAY and not points.jump[low]:
            low -= 1
        end = high
        while high < len(label) and follows[high]:
            high += 1
        saved = flat + STRAY_PRICE * (begin - low + high - end) - ARC_PRICE
        if high - low < columns.FEWEST or saved < high - low + columns.MARGIN:
            continue
        saved -= arc_misfit(points, low, high, max_radius, columns.IN_WALL)
        if saved > max(best, columns.MARGIN):
            best, at = saved, (low, high)
    return at


def find_columns(points, label, walls, max_radius):
    """Twin of `find_columns`: where columns begin and end, and the walls that go into one."""
    found, gone, begin = [], set(), 0
    while begin < len(label):
        k, at = label[begin], (begin, begin)
        if k >= 0 and walls["first"][k] == begin and k not in gone and max_radius > 0:
            at = column_from(points, label, walls, begin, max_radius)
        if at[0] < at[1]:
            found.append(at)
            gone |= {k for k in label[at[0] : at[1]].tolist() if k >= 0}
        begin = max(at[1], begin + 1)
    return found, gone
