"""The kernels that propose lines as tests call them: returns as `Sequence`, results returned."""

import math

import numpy as np
from kernels import _compiled
from laserfeatures_plugins.direct_hough import search
from laserfeatures_plugins.ransac import sampling
from laserfeatures_plugins.region_growing import growing
from laserfeatures_plugins.split_and_merge import splitting

from laserfeatures.engine import candidates
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.sums import running_sums


def is_inlier(points, i, line, width):
    """Tell whether a return is on a line (c, s, d), give or take a width."""
    return _compiled(candidates.is_inlier)(points, i, *line, width)


def grow(points, taken, seed, line, width, max_missed):
    """Return the candidate grown from a line (c, s, d)."""
    return _compiled(candidates.grow)(points, taken, seed, *line, width, max_missed)


def add(points, taken, found):
    """Return the column of a candidate, and what is taken with it."""
    taken, lines = taken.copy(), np.zeros((COLUMNS, 1))
    _compiled(candidates.add)(points, taken, found, lines, 0)
    return lines[:, 0], taken


def grow_region(points, first, max_missed):
    """Return the candidate grown forwards from a return."""
    return _compiled(growing.grow_region)(points, first, max_missed)


def regions(points, max_missed):
    """Return what region_growing proposes, (K, COLUMNS)."""
    return growing.propose(np.array(points), max_missed).T


def farthest(points, a, b):
    """Return the return that is farthest from the chord of two."""
    return _compiled(splitting.farthest)(points, a, b)


def split(points, start, end):
    """Return the pieces of returns start..end, (K, COLUMNS)."""
    lines = np.empty((COLUMNS, len(points.x) + 1))
    sums = _compiled(running_sums)(points)
    return lines[:, : _compiled(splitting.split)(points, sums, start, end, lines, 0)].T


def pieces(points):
    """Return what split_and_merge proposes, (K, COLUMNS)."""
    return splitting.propose(np.array(points)).T


def sampled(points, settings, max_missed):
    """Return what ransac proposes, (K, COLUMNS)."""
    return sampling.propose(np.array(points), settings, max_missed).T


def voted(points, rows, distance_step, chord, max_missed, *, row):
    """Return what direct_hough proposes, (K, COLUMNS); `row` is the length of its rows."""
    theta = np.arange(rows) * math.pi / rows
    votes, epoch = np.zeros((rows, row), np.int32), np.zeros(1, np.int64)
    args = np.cos(theta), np.sin(theta), distance_step, votes, epoch, chord, max_missed
    return search.propose(np.array(points), *args).T
