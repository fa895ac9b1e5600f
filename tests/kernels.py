"""The kernels as tests call them: points as one array, results returned; the one place to adapt."""

from functools import cache

import numpy as np
from laserfeatures_plugins.direct_hough import search, voting
from laserfeatures_plugins.ransac import sampling

from laserfeatures.compiled import kernel
from laserfeatures.engine import (
    arcs,
    certainty,
    columns,
    noise,
    segments,
    sequence,
    steps,
    sums,
    walls,
)
from laserfeatures.engine import partition as partitions
from laserfeatures.engine.prices import PRICE


@cache
def _compiled(function):
    """Return a kernel or helper as one that Python can call: a bare helper would crash it."""
    return kernel(getattr(function, "py_func", function))


def _xy(points):
    return tuple(np.ascontiguousarray(points.T))


def is_gap(*args):
    """Tell whether a step along a line is a gap."""
    return _compiled(segments.is_gap)(*args)


def cut_segments(points, beams, source, total, lines, members, *gaps):
    """Return line, endpoints, support, rms, points of the segments; members (L, P) bool."""
    cut = _compiled(segments.cut_segments)
    return cut(*_xy(points), beams, source, total, *_xy(lines), *np.nonzero(members), *gaps)


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


def partner(beams, pool, first, window, random):
    """Return the place in the pool of a sample's second point."""
    return _compiled(sampling.partner)(beams, pool, first, window, random)


def line_through(points, i, j):
    """Return (cosine and sine of theta, d) of the line through two points."""
    return _compiled(sampling.line_through)(*_xy(points), i, j)


def score(points, pool, line, gate, worth):
    """Return the cost of a line, its inliers and those that follow each other."""
    sample = np.ascontiguousarray(points[pool].T)
    return _compiled(sampling.score)(sample, len(pool), line, gate, worth)


def best_line(points, beams, pool, gate, settings, random):
    """Return a point of the best line, that line, its inliers and the random state."""
    room = np.empty((2, len(pool)))
    return _compiled(sampling.best_line)(*_xy(points), beams, pool, room, gate, settings, random)


def weighed(scan, sigma=0.005, relative=0.0, roughness=0.0):
    """Return the returns of a scan in order, with what follows from its noise."""
    points = sequence.Sequence(*in_order(scan))
    weigh(points, sigma, relative, roughness)
    return points


def in_order(scan):
    """Return the table of a scan's returns."""
    limits = float(scan.range_min), float(scan.range_max)
    return _compiled(sequence.in_order)(scan.directions, scan.ranges, limits, scan.ring)


def weigh(points, sigma, relative, roughness, correlation=0.0):
    """Fill in what follows from the noise."""
    noise = sequence.Noise(float(sigma), float(relative), float(roughness), float(correlation))
    _compiled(sequence.weigh)(points, noise)


def without_lone(points):
    """Return the returns that do not stand out alone."""
    return sequence.Sequence(*_compiled(sequence.without_lone)(np.array(points)))


def turned(points, start, period):
    """Return the returns of a ring from another one on."""
    return sequence.Sequence(*_compiled(sequence.turned)(np.array(points), start, period))


def estimate_noise(points):
    """Return sigma [m], the relative noise, the roughness [m] and the correlation."""
    return _compiled(noise.estimate_noise)(points, sequence.Noise(-1.0, 0.0, 0.0, -1.0))


def stretches(points):
    """Return variance, mean squared range and steps of stretches, the least and the mean range."""
    return _compiled(noise.stretches)(points)


def wall_misfit(points, i, j):
    """Return chi squared of the line through returns i..j-1, and how obliquely it is met."""
    return _compiled(sums.wall_misfit)(running_sums(points), i, j)


def running_sums(points):
    """Return the table of sums."""
    return _compiled(sums.running_sums)(points)


def line_of(*weighted):
    """Return c, s, d and chi squared of the line that weighted sums give."""
    return _compiled(sums.line_of)(*weighted)


def arc_misfit(points, i, j, max_radius, least=arcs.CONVEX):
    """Return chi squared of the circle through returns i..j-1."""
    return _compiled(arcs.arc_misfit)(points, i, j, float(max_radius), float(least))


def nearest_circle(points, i, j, x, y, radius):
    """Return the centre and radius of the circle nearest to returns, begun at another."""
    return _compiled(arcs.nearest_circle)(points, i, j, float(x), float(y), float(radius))


def is_round(points, i=0, j=None, max_radius=0.4):
    """Tell whether returns i..j-1 are those of a round object."""
    j = points.x.size if j is None else j
    return _compiled(arcs.is_round)(points, i, j, float(max_radius))


def partition(points, lines, limits, price=PRICE, round_objects=()):
    """Return the labels of returns, and the number of walls.

    Lines as (c, s, d, first, last); round objects as where they begin and end.
    """
    label = np.full(points.x.size, -7, np.int64)
    known = partitions.Candidates(*np.ascontiguousarray(np.reshape(lines, (-1, 5)).T, dtype=float))
    found = np.ascontiguousarray(np.reshape(round_objects, (-1, 2)).T, dtype=np.int64)
    of = _compiled(partitions.partition)
    return label, of(points, running_sums(points), known, found, price, limits, label)


def find_columns(points, label, found, max_radius):
    """Return where columns begin and end, (K, 2), and how many points the walls keep."""
    found = found.copy()
    at = _compiled(columns.find_columns)(points, label, found, float(max_radius))
    return at.T, found["points"]


def column_from(points, label, found, begin, max_radius):
    """Return the first and last return of the column whose first face begins at a return."""
    return _compiled(columns.column_from)(points, label, found, begin, float(max_radius))


def excursions(points, label, found):
    """Return where the sum of each wall's offsets has its extremes, (K, 2)."""
    return _compiled(steps.excursions)(points, label, found)


def parts_of(points, label, found, at):
    """Return the sums of each wall's returns before, between and after two of them, (K, 3)."""
    return _compiled(steps.parts_of)(points, label, found, at)


def part_at_steps(points, label, found, min_points):
    """Return the labels after walls were parted at their steps, and the walls."""
    label = label.copy()
    return label, _compiled(steps.part_at_steps)(points, label, found.copy(), min_points)


def fit_walls(points, label, lines=None):
    """Return the walls fitted to labels: weighted by the incidence on `lines` (K, 3) if given."""
    found = np.zeros(label.max(initial=-1) + 1, walls.WALL)
    if lines is not None:
        for row, (c, s, d) in zip(found, lines, strict=True):
            row["c"], row["s"], row["d"] = c, s, d
    _compiled(walls.fit_walls)(points, label, found, lines is not None)
    return found


def settled(points, label):
    """Return the walls fitted to labels and weighted by the incidence on what that gives."""
    found = fit_walls(points, label)
    _compiled(walls.fit_walls)(points, label, found, True)
    return found


def merge_collinear(points, label):
    """Return the labels after the walls on one line were joined, and the walls."""
    label, found = label.copy(), settled(points, label)
    _compiled(walls.merge_collinear)(points, label, found)
    return label, found


def part_at_corners(points, label, found):
    """Return the labels after walls were parted at their corners."""
    label = label.copy()
    _compiled(walls.part_at_corners)(points, label, found)
    return label


def free_outliers(points, label, found, known):
    """Return the labels after outliers were freed."""
    label = label.copy()
    _compiled(walls.free_outliers)(points, label, found, known)
    return label


def prune(label, found, min_points):
    """Return the labels after walls of few points were dropped, and the walls that stay."""
    label, found = label.copy(), found.copy()
    return label, found[: _compiled(walls.prune)(label, found, min_points)]


def weigh_evidence(points, label, found):
    """Return the evidence of each wall [nats]."""
    found = found.copy()
    _compiled(certainty.weigh_evidence)(points, label, found)
    return found["evidence"]


def inflate_covariances(points, found):
    """Return by how much each wall's covariance grows."""
    grown = found.copy()
    _compiled(certainty.inflate_covariances)(points, grown, False)
    ratio = grown["var_theta"] / found["var_theta"]
    np.testing.assert_allclose(grown["cov"], ratio * found["cov"])
    second = certainty.SECOND * (found["d"] * grown["var_theta"]) ** 2
    np.testing.assert_allclose(grown["var_d"], ratio * found["var_d"] + second)
    return ratio
