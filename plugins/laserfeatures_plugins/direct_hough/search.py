"""The search for walls: vote, take the peaks, let the points that are left vote again."""

import math

import numpy as np
from numba import njit

from laserfeatures.geometry import cut_segments, returns
from laserfeatures_plugins.direct_hough.arcs import set_arcs_aside
from laserfeatures_plugins.direct_hough.sharing import merge_pieces, share_points
from laserfeatures_plugins.direct_hough.voting import next_peak, vote_pairs
from laserfeatures_plugins.direct_hough.walls import (
    FLATNESS,
    FREE,
    MIN_SIGMA,
    estimate_sigma,
    find_wall,
    is_wall,
)

ROUND = -2  # owner of a point on a round object
MIN_VOTES = 3
MIN_CHORD = 0.05  # [m]; where chords this short vote, every wall of four beams has had its chance
SIGMAS = 3.0  # an inlier's distance from its line in standard deviations
ENOUGH = 15  # degrees of freedom from which the walls tell the noise better than the triples


@njit(cache=True)
def extract(
    directions, ranges, limits, cos, sin, distance_step, votes, epoch, sigma, chord, jump, radius, cut
):
    """Return what `LineSegments` and `Lines` hold of a scan.

    `sigma` 0 stands for unknown, `cut` is (min_points, max_missed, max_gap), `radius` the largest
    of a round object. `votes` and `epoch` are the accumulator and its count of votes so far.
    """
    x, y, beam = returns(directions, ranges, limits[0], limits[1])
    owner = np.full(x.size, FREE)
    known = sigma > 0.0
    if not known:
        sigma = estimate_sigma(x, y)
    if radius > 0.0:
        set_arcs_aside(x, y, beam, sigma, jump, radius, ROUND, owner)
    walls, sigma = search(
        x, y, beam, owner, cos, sin, distance_step, votes, epoch, sigma, known, chord, cut
    )
    merge_pieces(x, y, owner, walls, sigma)
    share_points(x, y, owner, walls, cut[0], sigma)
    kept = np.flatnonzero(walls[:, 5] >= cut[0])
    lines = walls[kept]
    members = np.zeros((kept.size, x.size), np.bool_)
    for new, k in enumerate(kept):
        for i in range(x.size):
            members[new, i] = owner[i] == k
    covariance = np.empty((kept.size, 2, 2))
    covariance[:, 0, 0] = lines[:, 2]
    covariance[:, 0, 1] = covariance[:, 1, 0] = lines[:, 3]
    covariance[:, 1, 1] = lines[:, 4]
    theta = lines[:, 0].copy()
    d = lines[:, 1].copy()
    segments = cut_segments(x, y, beam, ranges.size, theta, d, members, cut[1], cut[2])
    return theta, d, lines[:, 5].copy(), covariance, segments


@njit(cache=True)
def search(x, y, beam, owner, cos, sin, distance_step, votes, epoch, sigma, known, chord, cut):
    """Find walls until a round of votes brings none; return them and the noise they show.

    A wall's points do not vote again: its votes are given back, and the short walls that it hid
    come forward. `owner` is filled with the wall of each point.
    """
    walls = np.empty((x.size // cut[0] + 1, 6))
    count = 0
    rows = cos.size
    best = np.empty(rows, np.int64)
    members = np.empty(x.size, np.int64)
    first_guess = sigma
    squares = freedom = 0.0
    while chord >= MIN_CHORD:
        live = np.flatnonzero(owner == FREE)
        if live.size < cut[0]:
            break
        vote_pairs(x, y, live, cos, sin, distance_step, chord, 0.5 * distance_step + 2.0 * sigma,
                   votes, fresh_epoch(votes, epoch, live.size), best, 1 if count == 0 else 2)  # fmt: skip
        done = np.zeros(rows, np.bool_)
        found = count
        while True:
            peak = next_peak(best, done, MIN_VOTES)
            if peak < 0:
                break
            seed = best[peak] & 0xFFFFFFFF
            if owner[seed] != FREE:
                continue
            gate = max(SIGMAS * sigma, 1.5 * FLATNESS)
            d = x[seed] * cos[peak] + y[seed] * sin[peak]
            n, fit = find_wall(x, y, beam, owner, seed, peak * math.pi / rows, d,
                               distance_step + gate, gate, sigma, cut, members)  # fmt: skip
            if n == 0:
                continue
            good, variance = is_wall(x, y, members[:n], fit, sigma)
            if not good:
                continue
            owner[members[:n]] = count
            walls[count, 0], walls[count, 1], walls[count, 2], walls[count, 3], walls[count, 4] = fit
            walls[count, 5] = n
            count += 1
            if n >= 10 and not known:
                squares += variance * (n - 2)
                freedom += n - 2
                if freedom >= ENOUGH:
                    sigma = min(max(math.sqrt(squares / freedom), MIN_SIGMA), 2.0 * first_guess)
        if count == found:
            chord *= 0.4
    return walls[:count], sigma


@njit(cache=True)
def fresh_epoch(votes, epoch, voters):
    """Return a count that every earlier vote is at or below, so that all cells count as empty."""
    base = epoch[0]
    epoch[0] = base + 2 * voters + 1
    if epoch[0] > 2**31 - 2:
        votes[:] = 0
        base = 0
        epoch[0] = 2 * voters + 1
    return base
