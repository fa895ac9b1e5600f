"""Slow, obvious twins of region_growing's kernels."""

import numpy as np
import reference_candidates

from laserfeatures.engine.prices import PRICE, STRAY_PRICE


def grow_region(points, first, max_missed, seed, flat):
    """Twin of `grow_region`: (line, first, last, saved).

    The line is fitted to `seed` returns, whose chi squared is below `flat`, and again when half as
    many more have come, and one.
    """
    edges = np.flatnonzero(points.jump[first + 1 :]) + first + 1
    end = min([*edges, len(points.x)])
    members = list(range(first, min(first + seed, end)))
    if len(members) < seed:
        return None, first, members[-1] + 1, -PRICE
    line, chi2 = reference_candidates.fit(points, members)
    due, missed = seed + 1 + seed // 2, 0
    for i in range(first + seed, len(points.x) if chi2 < flat else 0):
        if not reference_candidates.inliers(points, line)[i]:
            missed += 1
            if missed > max_missed:
                break
            continue
        missed = 0
        members.append(i)
        if len(members) == due:
            line, _ = reference_candidates.fit(points, members)
            due += 1 + due // 2
    line, chi2 = reference_candidates.fit(points, members)
    return line, first, members[-1] + 1, len(members) * STRAY_PRICE - chi2 - PRICE


def propose(points, max_missed, seed, flat, pace):
    """Twin of `propose`: rows (c, s, d, first, last)."""
    rows, i = [], 0
    while i + seed <= len(points.x):
        found = grow_region(points, i, max_missed, seed, flat)
        if found[-1] > 0:
            rows.append(reference_candidates.row(found))
            i = found[2] - 1
        else:
            i += 1 + (found[2] - i) // pace
    return rows
