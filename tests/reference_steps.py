"""Slow, obvious twins of what parts walls at steps, in plain NumPy."""

import numpy as np
import reference_engine

from laserfeatures.engine import steps


def shares(points, wall):
    """Return cos^2 / (cos^2 + floor) of each return's incidence on a wall."""
    cosine = reference_engine.directions(points) @ (wall["c"], wall["s"])
    return cosine**2 / (cosine**2 + points.floor)


def excursions(points, label, walls):
    """Twin of `excursions`: where the cumulative sum is least and most, -1 where it never is."""
    found = []
    for k, wall in enumerate(walls):
        mine = np.flatnonzero(label == k)
        normal = wall["c"], wall["s"]
        off = reference_engine.xy(points)[mine] @ normal - wall["d"]
        cosine = reference_engine.directions(points)[mine] @ normal
        total = np.cumsum(off / (points.variance[mine] * (cosine**2 + points.floor[mine])))
        low = mine[total.argmin()] if total.min(initial=0.0) < 0 else -1
        high = mine[total.argmax()] if total.max(initial=0.0) > 0 else -1
        found.append((low, high))
    return np.reshape(found, (-1, 2))


def parts_of(label, k, at):
    """Return wall k's returns before, between and after two returns."""
    mine = np.flatnonzero(label == k)
    low, high = sorted(at)
    parts = mine[mine <= low], mine[(mine > low) & (mine <= high)], mine[mine > high]
    assert len(parts) == steps.PARTS
    return parts


def part_at_steps(points, label, walls, min_points):
    """Twin of `part_at_steps`: the labels of the returns after walls were parted."""
    label, new = label.copy(), len(walls)
    for k, at in enumerate(excursions(points, label, walls)):
        mine = np.flatnonzero(label == k)
        keep = shares(points, walls[k])
        best = steps.STEP_PRICE
        chosen = None
        for part in parts_of(label, k, at):
            rest = np.setdiff1d(mine, part)
            if min(len(part), len(rest)) < min_points:
                continue
            whole, *both = (
                reference_engine.fit(points, each, keep[each])[2] for each in (mine, part, rest)
            )
            saved = whole - sum(both)
            if saved > max(best, steps.LEAST * len(part) * len(rest) / len(mine)):
                best, chosen = saved, part
        if chosen is not None:
            label[chosen] = new
            new += 1
    return label
