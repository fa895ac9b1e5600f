"""Which landmark each measurement is of: nearest neighbour, or joint compatibility.

References
----------
Neira and Tardos, Data Association in Stochastic Mapping Using the Joint Compatibility Test, IEEE
Transactions on Robotics and Automation 17(6), 2001.
"""

import math
from functools import cache
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.compiled import helper, kernel

DENSITY = 5.0  # of corners [1/m^2], of walls [1/(rad m)]; what serves best on logs
MOST_NODES = 20_000  # of the search; where landmarks stand this close, the best so far is taken


class Pairs(NamedTuple):
    """Measurements and landmarks that may belong together, sorted by measurement.

    Parameters
    ----------
    measurement, landmark : (C,) int arrays
        Their numbers.
    innovation : (C, 2) array
        What was measured, less what was expected.
    covariance : (2C, 2C) array
        Of what was expected, for all pairs together.
    noise : (C, 2, 2) array
        Of what was measured.
    """

    measurement: IntArray
    landmark: IntArray
    innovation: FloatArray
    covariance: FloatArray
    noise: FloatArray


@cache
def gate(degrees: int, probability: float) -> float:
    """Return the quantile of the chi-square distribution, nearly.

    From 2 degrees of freedom on it is within 1 % up to a probability of 0.99; far out it is too
    wide, at 1 - 1e-6 by 10 % for 2 degrees and 1 % for 20.

    References
    ----------
    Wilson and Hilferty, The Distribution of Chi-Square, 1931.

    Examples
    --------
    >>> round(gate(10, 0.95), 1)  # 18.307 in tables
    18.3
    """
    z = NormalDist().inv_cdf(probability)
    part = 2.0 / (9.0 * degrees)
    return degrees * (1.0 - part + z * math.sqrt(part)) ** 3


def distances(pairs: Pairs) -> FloatArray:
    """Return the squared Mahalanobis distance of each pair (C,)."""
    count = len(pairs.measurement)
    own = pairs.covariance.reshape(count, 2, count, 2)[np.arange(count), :, np.arange(count)]
    total = own + pairs.noise
    solved = np.linalg.solve(total, pairs.innovation[:, :, None])[:, :, 0]
    squared: FloatArray = (pairs.innovation * solved).sum(axis=1)
    return squared


def worth(noise: FloatArray, density: float = DENSITY) -> FloatArray:
    """Return the most that a pairing of each measurement can score, from its noise (N, 2, 2).

    Where it is below zero, a measurement is too vague to be recognised.
    """
    score: FloatArray = -math.log(math.tau * density) - np.log(np.linalg.det(noise)) / 2
    return score


def nearest_neighbours(
    pairs: Pairs,
    probability: float,
    density: float = DENSITY,  # noqa: ARG001 - called as `joint_compatibility` is
) -> IntArray:
    """Return the pairs (K,) of nearest neighbours within their gates, each landmark once."""
    squared = distances(pairs)
    chosen: list[int] = []
    measurements: set[int] = set()
    landmarks: set[int] = set()
    for i in np.argsort(squared, kind="stable").tolist():
        if squared[i] > gate(2, probability):
            break
        measurement, landmark = int(pairs.measurement[i]), int(pairs.landmark[i])
        if measurement not in measurements and landmark not in landmarks:
            chosen.append(i)
            measurements.add(measurement)
            landmarks.add(landmark)
    return np.array(sorted(chosen), dtype=np.int64)


def joint_compatibility(pairs: Pairs, probability: float, density: float) -> IntArray:
    """Return the pairs (K,) that fit together and are most likely, if they are likely at all.

    Each set must pass the joint test. Of these the paper takes the largest; here it is the one of
    the highest likelihood against that of its measurements being new, which are spread evenly with
    `density`. A wide gate that anything would pass is worth little then: where the pose is
    uncertain, only several landmarks together are recognised.

    Parameters
    ----------
    pairs : Pairs
        What may belong together.
    probability : float
        That the true pairs pass the joint test.
    density : float
        How many landmarks there are to a unit of their numbers [1/m^2, or 1/(rad m)].
    """
    starts = np.flatnonzero(np.diff(pairs.measurement, prepend=-1))
    first = np.append(starts, len(pairs.measurement)).astype(np.int64)
    gates = np.array([gate(2 * (i + 1), probability) for i in range(len(starts))])
    most = np.maximum(worth(pairs.noise[starts], density), 0.0)
    left = np.append(np.cumsum(most[::-1])[::-1], 0.0)
    found: IntArray = _search(
        np.ascontiguousarray(pairs.innovation),
        np.ascontiguousarray(pairs.covariance),
        np.ascontiguousarray(pairs.noise),
        first,
        pairs.landmark,
        gates,
        left,
        -math.log(math.tau * density),
    )
    return found


@kernel
def _search(
    innovation: FloatArray,
    covariance: FloatArray,
    noise: FloatArray,
    first: IntArray,
    landmark: IntArray,
    gates: FloatArray,
    left: FloatArray,  # the most that the measurements from each on can add to the score
    each: float,  # what a pair adds but for its spread and its distance
) -> IntArray:
    """Search the tree of pairings, measurement by measurement, depth first."""
    depth_of_all = len(first) - 1
    root = np.zeros((2 * depth_of_all, 2 * depth_of_all))  # Cholesky root of the joint covariance
    white = np.zeros(2 * depth_of_all)  # the innovation, whitened by it
    chosen = np.full(depth_of_all, -1)
    tried = first[:-1].copy()  # next pair to try at each depth; beyond the last: none
    counts = np.zeros(depth_of_all + 1, np.int64)
    totals = np.zeros(depth_of_all + 1)
    scores = np.zeros(depth_of_all + 1)
    best = np.full(depth_of_all, -1)
    highest, nodes, depth = 0.0, 0, 0
    while depth >= 0:
        if depth == depth_of_all:
            if scores[depth] > highest:
                highest = scores[depth]
                best[:] = chosen
            depth -= 1
            continue
        hopeless = scores[depth] + left[depth] <= highest
        if tried[depth] > first[depth + 1] or hopeless or nodes > MOST_NODES:
            tried[depth] = first[depth]
            chosen[depth] = -1
            depth -= 1
            continue
        pair = tried[depth]
        tried[depth] += 1
        count, total, score = counts[depth], totals[depth], scores[depth]
        if pair == first[depth + 1]:  # the measurement is of no landmark
            chosen[depth] = -1
        else:
            if _taken(landmark, chosen, depth, landmark[pair]):
                continue
            added = _extend(root, white, chosen, depth, count, pair, innovation, covariance, noise)
            total += added
            if total > gates[count]:
                continue
            spread = root[2 * count, 2 * count] * root[2 * count + 1, 2 * count + 1]
            score += each - added / 2 - math.log(spread)
            count += 1
            chosen[depth] = pair
        nodes += 1
        depth += 1
        counts[depth], totals[depth], scores[depth] = count, total, score
    return best[best >= 0]


@helper
def _taken(landmark: IntArray, chosen: IntArray, depth: int, wanted: int) -> bool:
    taken = False
    for i in range(depth):
        taken |= chosen[i] >= 0 and landmark[chosen[i]] == wanted
    return taken


@helper
def _extend(
    root: FloatArray,
    white: FloatArray,
    chosen: IntArray,
    depth: int,
    count: int,
    pair: int,
    innovation: FloatArray,
    covariance: FloatArray,
    noise: FloatArray,
) -> float:
    """Add a pair's two rows to the root; return what it adds to the squared distance."""
    added = 0.0
    for r in range(2):
        row = 2 * count + r
        value = innovation[pair, r]
        column = 0
        for i in range(depth + 1):
            other = pair if i == depth else chosen[i]
            if other < 0:
                continue
            for q in range(2 if i < depth else r + 1):
                entry = covariance[2 * pair + r, 2 * other + q]
                if i == depth:
                    entry += noise[pair, r, q]
                for k in range(column):
                    entry -= root[row, k] * root[column, k]
                if column == row:
                    root[row, row] = math.sqrt(max(entry, 1e-300))
                else:
                    root[row, column] = entry / root[column, column]
                column += 1
        for k in range(row):
            value -= root[row, k] * white[k]
        white[row] = value / root[row, row]
        added += white[row] ** 2
    return added
