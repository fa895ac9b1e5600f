"""The kernels as tests call them: points as one array, results returned; the one place to adapt."""

from functools import cache

import numpy as np
from laserfeatures_plugins.direct_hough import search, voting
from laserfeatures_plugins.ransac import sampling
from laserfeatures_plugins.region_growing import growing
from laserfeatures_plugins.split_and_merge import splitting
from numba import njit

from laserfeatures import geometry
from laserfeatures.geometry import arcs, fit, growth, noise, settle, sharing, walls


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


def estimate_sigma(points):
    """Return the noise [m]."""
    return _compiled(noise.estimate_sigma)(*_xy(points))


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


def share_points(points, owner, table, min_points, *, gate=0.0, sigma=0.005, refit=False):
    """Return owners and walls afterwards."""
    owner, table = owner.copy(), table.copy()
    _compiled(sharing.share_points)(*_xy(points), owner, table, gate, sigma, refit, min_points)
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


def major_axis(scatter):
    """Return the unit vector of a scatter matrix's major axis and the scatter along it."""
    return _compiled(fit.direction)(scatter[0, 0], scatter[0, 1], scatter[1, 1])


def fit_unweighted(points, members):
    """Return (theta, d, var_theta, cov_theta_d, var_d), the variances for a noise of 1 m."""
    return _compiled(fit.fit_unweighted)(*_xy(points), members)


def line_of_sums(away, origin):
    """Return the unweighted fit to points given by how far they are from an origin."""
    dx, dy = _xy(away)
    sums = dx.sum(), dy.sum(), (dx * dx).sum(), (dx * dy).sum(), (dy * dy).sum()
    return _compiled(fit.line_of_sums)(*origin, len(away), *sums)


def gate_of(sigma):
    """Return the largest distance of an inlier [m]."""
    return _compiled(growth.gate_of)(sigma)


def median(values):
    """Return the upper median."""
    return _compiled(noise.median)(values)


def pack(theta, d, support, covariance, segments):
    """Return the numbers, the line of each segment and the beams it holds."""
    return _compiled(settle.pack)(theta, d, support, covariance, segments)


def next_free(beams, free, i, last_beam):
    """Return the free point after point i, or -1."""
    return _compiled(growing.next_free)(beams, _owner(free), i, last_beam)


def grow_region(points, beams, free, seed, partner, gate, *gaps):
    """Return the members of a region and their line."""
    members = np.empty(len(points), np.int64)
    count, line = _compiled(growing.grow_region)(
        *_xy(points), beams, _owner(free), seed, partner, gate, *gaps, members
    )
    return members[:count].tolist(), line


def refine(points, members, line, gate, min_points):
    """Return the members that are left and their line."""
    members = np.array(members)
    count, line = _compiled(growing.refine)(
        *_xy(points), members, members.size, line, gate, min_points
    )
    return members[:count].tolist(), line


def grown_walls(points, beams, free, sigma, cut):
    """Return the owners after the search of `region_growing`, its walls and the noise."""
    owner = np.where(free, walls.FREE, walls.ROUND)
    found = _compiled(growing.search)(*_xy(points), beams, owner, sigma, cut)
    return owner, *found


def linked(points, i, j, sigma, min_incidence):
    """Tell whether two points may be on one surface."""
    grazing = np.cos(min_incidence), np.sin(min_incidence)
    return _compiled(splitting.linked)(*_xy(points), i, j, sigma, grazing)


def next_chain(points, beams, free, start, sigma, min_incidence, max_missed):
    """Return the points of a chain and where the next one may start."""
    chain = np.empty(len(points), np.int64)
    grazing = np.cos(min_incidence), np.sin(min_incidence)
    size, after = _compiled(splitting.next_chain)(
        *_xy(points), beams, _owner(free), start, sigma, grazing, max_missed, chain
    )
    return chain[:size].tolist(), after


def farthest(points, chain, a, b):
    """Return the place in a chain that is farthest from its chord, and how far."""
    return _compiled(splitting.farthest)(*_xy(points), np.array(chain), a, b)


def is_spike(points, chain, a, b, m, off):
    """Tell whether a place sticks out of a chain alone."""
    return _compiled(splitting.is_spike)(*_xy(points), np.array(chain), a, b, m, off)


def split(points, chain, sigma, gate, min_points):
    """Return the owners after a chain was split, the walls and the sums of the noise."""
    owner = _owner(np.ones(len(points), bool))
    table, squares = np.empty((len(points), 6)), np.zeros(2)
    count = _compiled(splitting.split)(
        *_xy(points), np.array(chain), owner, sigma, gate, min_points, table, 0, squares
    )
    return owner, table[:count], squares


def split_walls(points, beams, free, sigma, min_incidence, cut):
    """Return the owners after the search of `split_and_merge`, its walls and the noise."""
    owner = np.where(free, walls.FREE, walls.ROUND)
    grazing = np.cos(min_incidence), np.sin(min_incidence)
    found = _compiled(splitting.search)(*_xy(points), beams, owner, sigma, grazing, cut)
    return owner, *found


def partner(beams, pool, first, window, random):
    """Return the place in the pool of a sample's second point."""
    return _compiled(sampling.partner)(beams, pool, first, window, random)


def line_through(points, i, j):
    """Return (cosine and sine of theta, d) of the line through two points."""
    return _compiled(sampling.line_through)(*_xy(points), i, j)


def score(points, pool, line, gate, worth):
    """Return the cost of a line, its inliers and those that follow each other."""
    return _compiled(sampling.score)(*_xy(points), pool, line, gate, worth)


def best_line(points, beams, pool, gate, settings, random):
    """Return a point of the best line, its theta, its inliers and the random state."""
    return _compiled(sampling.best_line)(*_xy(points), beams, pool, gate, settings, random)
