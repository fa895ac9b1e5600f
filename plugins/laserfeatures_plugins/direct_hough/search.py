"""The search for walls: vote, take the peaks, let the points that are left vote again."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import Segments, cut_segments, helper, kernel, returns
from laserfeatures_plugins.direct_hough.arcs import set_arcs_aside
from laserfeatures_plugins.direct_hough.sharing import merge_pieces, share_points
from laserfeatures_plugins.direct_hough.voting import next_peak, vote_pairs
from laserfeatures_plugins.direct_hough.walls import (
    FREE,
    MAX_GROWTH,
    MIN_SIGMA,
    Cut,
    estimate_sigma,
    find_wall,
    keep_wall,
)

ROUND = -2  # owner of a point on a round object
MIN_VOTES = 3
SEED = 0xFFFFFFFF  # the part of a row's best that names one of the voters
SHORTER = 0.4  # than the chords that found nothing more
MIN_CHORD = 0.05  # [m]; where chords this short vote, every wall of four beams has had its chance
ENOUGH = 15  # degrees of freedom from which the walls tell the noise better than the triples


@kernel
def extract(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    cos: FloatArray,
    sin: FloatArray,
    distance_step: float,
    votes: NDArray[np.int32],
    epoch: IntArray,
    sigma: float,
    chord: float,
    jump: float,
    radius: float,
    cut: Cut,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, Segments]:
    """Return what `LineSegments` and `Lines` hold of a scan.

    `sigma` 0 stands for unknown, `cut` is (min_points, max_missed, max_gap), `radius` the largest
    of a round object. `votes` and `epoch` are the accumulator and its count of votes so far.
    """
    x, y, beam = returns(directions, ranges, limits[0], limits[1])
    owner = np.empty(x.size, np.int64)
    for i in range(x.size):
        owner[i] = FREE
    known = sigma > 0.0
    if not known:
        sigma = estimate_sigma(x, y)
    if radius > 0.0:
        set_arcs_aside(x, y, beam, sigma, jump, radius, ROUND, owner)
    walls, sigma = search(
        x, y, beam, owner, cos, sin, distance_step, votes, epoch, sigma, known, chord, cut
    )
    merge_pieces(x, y, owner, walls, sigma)
    share_points(x, y, owner, walls, cut[0])
    theta, d, support, covariance = lines_of(walls, cut[0], sigma)
    line, member = members_of(owner, walls, cut[0])
    segments = cut_segments(
        x, y, beam, ranges.size, theta, d, line, member, cut[1], cut[2], MAX_GROWTH
    )
    return theta, d, support, covariance, segments


@helper
def lines_of(
    walls: FloatArray, min_points: int, sigma: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return theta, d, support and covariance of the walls that have enough points."""
    lines = 0
    for k in range(walls.shape[0]):
        lines += walls[k, 5] >= min_points
    theta = np.empty(lines)
    d = np.empty(lines)
    support = np.empty(lines)
    covariance = np.empty((lines, 2, 2))
    new = 0
    for k in range(walls.shape[0]):
        if walls[k, 5] >= min_points:
            theta[new] = walls[k, 0]
            d[new] = walls[k, 1]
            covariance[new, 0, 0] = walls[k, 2] * sigma * sigma
            covariance[new, 0, 1] = covariance[new, 1, 0] = walls[k, 3] * sigma * sigma
            covariance[new, 1, 1] = walls[k, 4] * sigma * sigma
            support[new] = walls[k, 5]
            new += 1
    return theta, d, support, covariance


@helper
def members_of(owner: IntArray, walls: FloatArray, min_points: int) -> tuple[IntArray, IntArray]:
    """Return the lines and the points of all points on walls that have enough of them."""
    place = np.empty(walls.shape[0], np.int64)  # where the next point of each wall goes
    number = np.empty(walls.shape[0], np.int64)
    total = lines = 0
    for k in range(walls.shape[0]):
        place[k] = total
        number[k] = lines
        if walls[k, 5] >= min_points:
            total += int(walls[k, 5])
            lines += 1
    line = np.empty(total, np.int64)
    member = np.empty(total, np.int64)
    for i in range(owner.size):
        k = owner[i]
        if k >= 0 and walls[k, 5] >= min_points:
            line[place[k]] = number[k]
            member[place[k]] = i
            place[k] += 1
    return line, member


@helper
def search(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    cos: FloatArray,
    sin: FloatArray,
    distance_step: float,
    votes: NDArray[np.int32],
    epoch: IntArray,
    sigma: float,
    known: bool,
    chord: float,
    cut: Cut,
) -> tuple[FloatArray, float]:
    """Find walls until a round of votes brings none; return them and the noise they show.

    A wall's points do not vote again: its votes are given back, and the short walls that it hid
    come forward. `owner` is filled with the wall of each point. A row of the result is a fit and
    its number of points.
    """
    walls = np.empty((x.size // cut[0] + 1, 6))
    count = 0
    rows = cos.size
    best = np.empty(rows, np.int64)
    done = np.empty(rows, np.bool_)
    members = np.empty(x.size, np.int64)
    most_noise = 2.0 * sigma
    squares = freedom = 0.0
    while chord >= MIN_CHORD:
        free = 0
        for i in range(x.size):
            if owner[i] == FREE:
                members[free] = i
                free += 1
        if free < cut[0]:
            break
        live = members[:free]
        base = fresh_epoch(votes, epoch, free)
        tolerance = 0.25 * distance_step + 2.0 * sigma
        partners = 1 if count == 0 else 2  # a second partner counts where the first is an outlier
        vote_pairs(
            x, y, live, cos, sin, distance_step, chord, tolerance, partners, votes, base, best
        )
        for t in range(rows):
            done[t] = False
        found = count
        peak = next_peak(best, done, MIN_VOTES)
        while peak >= 0:
            seed = best[peak] & SEED
            theta = peak * math.pi / rows
            peak = next_peak(best, done, MIN_VOTES)
            if owner[seed] != FREE:
                continue
            n, fit, variance = find_wall(
                x, y, beam, owner, seed, theta, distance_step, sigma, cut, members
            )
            if n == 0:
                continue
            for i in members[:n]:
                owner[i] = count
            keep_wall(walls[count], fit, n)
            count += 1
            if n >= 10 and not known:
                squares += variance * (n - 2)
                freedom += n - 2
                if freedom >= ENOUGH:
                    sigma = min(max(math.sqrt(squares / freedom), MIN_SIGMA), most_noise)
        if count == found:
            chord *= SHORTER
    return walls[:count], sigma


@helper
def fresh_epoch(votes: NDArray[np.int32], epoch: IntArray, voters: int) -> int:
    """Return a count that every earlier vote is at or below, so that all cells count as empty."""
    base = epoch[0]
    epoch[0] = base + 2 * voters + 1
    if epoch[0] > 2**31 - 2:
        votes[:] = 0
        base = 0
        epoch[0] = 2 * voters + 1
    return int(base)
