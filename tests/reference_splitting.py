"""Slow, obvious twins of split_and_merge's kernels."""

import math

import numpy as np
import reference_candidates
import reference_engine


def off_chord(points, a, b):
    """Return the distances of returns a..b from the chord through both."""
    at = reference_engine.xy(points)[a : b + 1]
    normal = np.array([at[0, 1] - at[-1, 1], at[-1, 0] - at[0, 0]])
    return abs((at - at[0]) @ normal) / np.linalg.norm(normal)


def farthest(points, a, b):
    """Twin of `farthest`."""
    return a + 1 + int(np.argmax(off_chord(points, a, b)[1:-1]))


def split(points, start, end, rules):
    """Twin of `split`: rows (c, s, d, first, last) of the pieces of returns start..end.

    `rules` are the kernel's (least returns, chi squared for a degree of freedom, and standard
    deviations of that besides).
    """
    least, flat, doubt = rules
    if end - start + 1 < least:
        return []
    line, chi2 = reference_candidates.fit(points, range(start, end + 1))
    freedom = end - start - 1
    if chi2 < flat * freedom + doubt * math.sqrt(2 * freedom):
        return [[*line, start, end + 1]]
    corner = farthest(points, start, end)
    return split(points, start, corner, rules) + split(points, corner, end, rules)


def propose(points, rules):
    """Twin of `propose`: the pieces between jumps."""
    rows = []
    for first, last in reference_engine.objects(points):
        rows += split(points, first, last - 1, rules)
    return rows
