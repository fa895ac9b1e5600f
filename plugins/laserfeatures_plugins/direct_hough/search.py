"""The search for walls: vote, take the peaks, let the points that are left vote again."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import helper, inlined, kernel
from laserfeatures.geometry.growth import find_wall
from laserfeatures.geometry.noise import MIN_SIGMA
from laserfeatures.geometry.settle import Found, free_points, settle
from laserfeatures.geometry.walls import FREE, Cut, keep_wall
from laserfeatures_plugins.direct_hough.voting import next_peak, vote_pairs

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
) -> Found:
    """Return what `LineSegments` and `Lines` hold of a scan.

    `sigma` 0 stands for unknown, `cut` is (min_points, max_missed, max_gap), `radius` the largest
    of a round object. `votes` and `epoch` are the accumulator and its count of votes so far.
    """
    x, y, beam, owner, noise = free_points(directions, ranges, limits, sigma, jump, radius)
    walls, noise = search(
        x, y, beam, owner, cos, sin, distance_step, votes, epoch, noise, sigma > 0.0, chord, cut
    )
    return settle(x, y, beam, ranges.size, owner, walls, noise, 0.0, False, cut)


@inlined
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
