"""The kernels as tests call them: points as one array, results returned; the one place to adapt."""

from functools import cache

import numpy as np
from laserfeatures_plugins.direct_hough import search, voting
from numba import njit

from laserfeatures import geometry
from laserfeatures.geometry import arcs, fit, growth, noise, sharing, walls


@cache
def _compiled(function):
    """Return a kernel or helper as one that Python can call: a bare helper would crash it."""
    return njit(error_model="numpy")(getattr(function, "py_func", function))


def _xy(points):
    return tuple(np.ascontiguousarray(points.T))


def _owner(free):
    return np.where(free, walls.FREE, 5)


def returns(scan):
    """Return points and beams."""
    limits = scan.range_min, scan.range_max
    x, y, beam = _compiled(geometry.returns)(scan.directions, scan.ranges, *limits)
    return np.stack([x, y], axis=1), beam


def fit_line(points, members, theta):
    """Return (theta, d, var_theta, cov_theta_d, var_d), the variances for a noise of 1 m."""
    return _compiled(geometry.fit_line)(*_xy(points), members, theta)


def is_gap(*args):
    """Tell whether a step along a line is a gap."""
    return _compiled(geometry.is_gap)(*args)


def cut_segments(points, beams, total, lines, members, *gaps):
    """Return line, endpoints, support, rms, points of the segments; members (L, P) bool."""
    cut = _compiled(geometry.cut_segments)
    return cut(*_xy(points), beams, total, *_xy(lines), *np.nonzero(members), *gaps)


def vote_pairs(points, live, theta, distance_step, chord, tolerance, partners, votes, base):
    """Return each row's most votes and the number of a voter."""
    best = np.full(theta.size, -7, np.int64)
    _compiled(voting.vote_pairs)(
        *_xy(points),
        *(live, np.cos(theta), np.sin(theta), distance_step, chord, tolerance, partners),
        *(votes, base, best),
    )
    return best >> 32, best & search.SEED


def peaks(best, min_votes):
    """Return the rows that repeated `next_peak` gives."""
    done = np.zeros(best.size, bool)
    found = []
    while (peak := _compiled(voting.next_peak)(best, done, min_votes)) >= 0:
        found.append(peak)
    return found


def direction(x, y):
    """Return the angle of a normal."""
    return _compiled(voting.direction)(x, y)


def fresh_epoch(votes, epoch, voters):
    """Return the base of the next votes."""
    return _compiled(search.fresh_epoch)(votes, epoch, voters)


def estimate_sigma(points, chords=50):
    """Return the noise [m]."""
    return _compiled(noise.estimate_sigma)(*_xy(points), chords)


def grow(points, beams, free, seed, line, gate, *gaps):
    """Return the members of the run around a seed."""
    members = np.empty(len(points), np.int64)
    owner = _owner(free)
    count = _compiled(growth.grow)(*_xy(points), beams, owner, seed, *line, gate, *gaps, members)
    return members[:count].tolist()


def is_wall(points, members, fit, sigma):
    """Tell whether members are what a wall gives, and the variance of their range noise."""
    return _compiled(walls.is_wall)(*_xy(points), members, fit, sigma)


def find_wall(points, beams, free, seed, theta, *, sigma, cut):
    """Return the members (none where there is no wall), the fit and the variance."""
    members = np.empty(len(points), np.int64)
    owner = _owner(free)
    count, fit, variance = _compiled(growth.find_wall)(
        *_xy(points), beams, owner, seed, theta, 0.02, sigma, cut, members
    )
    return members[:count], fit, variance


def nearest_member(points, members, line):
    """Return the member nearest to a line."""
    return _compiled(growth.nearest_member)(*_xy(points), members, *line)


def off_line(points, members, line):
    """Return the root mean square distance from a line."""
    return _compiled(fit.off_line)(*_xy(points), members, *line)


def set_arcs_aside(points, beams, sigma, jump, max_radius):
    """Return which points are on round objects."""
    owner = _owner(np.ones(len(points), bool))
    _compiled(arcs.set_arcs_aside)(*_xy(points), beams, sigma, jump, max_radius, walls.ROUND, owner)
    return owner == walls.ROUND


def fitted(points, owner):
    """Return the table of walls that owners imply: a fit and a number of points in each row."""
    rows = []
    for k in range(owner.max() + 1):
        mine = np.flatnonzero(owner == k)
        normal = np.linalg.svd(points[mine] - points[mine].mean(axis=0))[2][1]
        theta = np.arctan2(normal[1], normal[0]) % np.pi
        rows.append((*fit_line(points, mine, theta), mine.size))
    return np.array(rows)


def give_to_nearest(points, owner, table, gate=0.0):
    """Return the owners afterwards and which walls changed."""
    owner, table, changed = owner.copy(), table.copy(), np.zeros(len(table), bool)
    table[:, 5] = np.bincount(owner[owner >= 0], minlength=len(table))
    moved = _compiled(sharing.give_to_nearest)(*_xy(points), owner, table, gate, changed)
    assert moved == changed.any()
    np.testing.assert_array_equal(table[:, 5], np.bincount(owner[owner >= 0], minlength=len(table)))
    return owner, changed


def share_points(points, owner, table, min_points, *, gate=0.0, refit=False):
    """Return owners and walls afterwards."""
    owner, table = owner.copy(), table.copy()
    _compiled(sharing.share_points)(*_xy(points), owner, table, gate, refit, min_points)
    return owner, table


def merge_pieces(points, owner, sigma):
    """Return owners and walls afterwards."""
    owner, table = owner.copy(), fitted(points, owner)
    _compiled(sharing.merge_pieces)(*_xy(points), owner, table, sigma)
    return owner, table


def may_be_one(a, b, sigma):
    """Tell whether two walls may be one; a wall is (theta, d, var_theta, its middle along it)."""
    rows = [np.array([w[0], w[1], w[2], w[3] * w[2], 1.0, 9.0]) for w in (a, b)]
    return _compiled(sharing.may_be_one)(*rows, sigma)
