"""The search for lines: vote, grow walls from the peaks, let what is left vote again (step 3)."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.engine import helper, kernel
from laserfeatures.engine.candidates import add, grow
from laserfeatures.engine.partition import COLUMNS
from laserfeatures.engine.sequence import as_sequence
from laserfeatures_plugins.direct_hough.voting import next_peak, vote_pairs

MIN_VOTES = 3
SEED = 0xFFFFFFFF  # the part of a row's best that names one of the voters
PARTNERS = 2  # that a point votes with: a second counts where the first is an outlier
LEAST = 4  # points of a wall


@kernel
def propose(
    table: FloatArray,
    cos: FloatArray,
    sin: FloatArray,
    distance_step: float,
    votes: NDArray[np.int32],
    epoch: IntArray,
    chord: float,
    max_missed: int,
) -> FloatArray:
    """Return the candidates among the points of a scan, (COLUMNS, K).

    The points of a wall do not vote again: its votes are given back, and the walls that it hid come
    forward. `votes` and `epoch` are the accumulator and its count of votes so far.
    """
    points = as_sequence(table)
    n = points.x.size
    lines = np.empty((COLUMNS, n // LEAST + 1))
    rows = cos.size
    best = np.empty(rows, np.int64)
    done = np.empty(rows, np.bool_)
    taken = np.zeros(n, np.bool_)
    live = np.empty(n, np.int64)
    noise = 0.0
    for i in range(n):
        noise += points.variance[i]
    tolerance = 0.25 * distance_step + 2.0 * math.sqrt(noise / max(n, 1))
    count = 0
    found = True
    while found and count < lines.shape[1]:
        found = False
        voters = 0
        for i in range(n):
            live[voters] = i
            voters += not taken[i]
        if voters < LEAST:
            break
        base = fresh_epoch(votes, epoch, voters)
        vote_pairs(
            points.x, points.y, live[:voters], cos, sin, distance_step, chord, tolerance,
            PARTNERS if count > 0 else 1, votes, base, best,
        )  # fmt: skip
        for t in range(rows):
            done[t] = False
        peak = next_peak(best, done, MIN_VOTES)
        while peak >= 0:
            seed = best[peak] & SEED
            if not taken[seed] and count < lines.shape[1]:
                c = cos[peak]
                s = sin[peak]
                d = points.x[seed] * c + points.y[seed] * s
                wall = grow(points, taken, seed, c, s, d, distance_step, max_missed)
                if wall.saved > 0.0:
                    add(points, taken, wall, lines, count)
                    count += 1
                    found = True
            peak = next_peak(best, done, MIN_VOTES)
    return lines[:, :count].copy()


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
