"""Slow, obvious twins of what detectors share to propose lines."""

import numpy as np
import reference_engine

from laserfeatures.engine import candidates
from laserfeatures.engine.prices import PRICE, STRAY_PRICE


def inliers(points, line, width=0.0):
    """Twin of `is_inlier` for all returns: chi squared of what is beyond a width of a line."""
    c, s, d = line
    off = np.maximum(abs(reference_engine.xy(points) @ (c, s) - d) - width, 0)
    cosine = reference_engine.directions(points) @ (c, s)
    return off**2 / points.variance < candidates.INLIER * (cosine**2 + points.floor)


def fit(points, members):
    """Return the line (c, s, d) through some returns, d > 0, and its chi squared."""
    solution, _, chi2 = reference_engine.fit(points, members)
    d = 1 / np.linalg.norm(solution)
    return (*(solution * d), d), chi2


def run(on, places, beams, seed, max_missed):
    """Return those of successive places that are on a line, up to more beams missed in a row."""
    found, last = [], seed
    for i in places:
        if abs(beams[i] - beams[last]) > max_missed + 1:
            break
        if on[i]:
            found.append(i)
            last = i
    return found


def grow(points, taken, seed, line, width, max_missed):
    """Twin of `grow`: (line, first, last, saved)."""
    counts = []
    for _ in range(candidates.FITS):
        on = inliers(points, line, width) & ~taken
        back = run(on, range(seed, -1, -1), points.beam, seed, max_missed)
        ahead = run(on, range(seed + 1, len(on)), points.beam, seed, max_missed)
        members = np.sort([*back, *ahead]).astype(int)
        first, last = min([seed, *members]), max([seed, *members]) + 1
        if len(members) < 3:
            return line, first, last, -PRICE
        line, chi2 = fit(points, members)
        settled = width == 0 and counts[-1:] == [len(members)]
        counts.append(len(members))
        width = 0.0
        if settled:
            break
    return line, first, last, counts[-1] * STRAY_PRICE - chi2 - PRICE


def taken_by(points, taken, found):
    """Return what is taken after a candidate, (line, first, last, saved), was added."""
    line, first, last, _ = found
    place = np.arange(len(taken))
    return taken | (inliers(points, line) & (first <= place) & (place < last))


def row(found):
    """Return a candidate as a row of a table."""
    line, first, last, _ = found
    return [*line, first, last]


def assert_same(rows, expected):
    """Check proposals (K, COLUMNS) against those of a twin."""
    rows, expected = (np.reshape(each, (-1, 5)) for each in (rows, expected))
    np.testing.assert_array_equal(rows[:, 3:], expected[:, 3:])
    np.testing.assert_allclose(rows[:, :3], expected[:, :3], rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(np.hypot(*rows[:, :2].T), 1)
