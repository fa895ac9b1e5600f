"""Which landmark each measurement is of: nearest neighbour, or joint compatibility.

References
----------
Neira and Tardos, Data Association in Stochastic Mapping Using the Joint Compatibility Test, IEEE
Transactions on Robotics and Automation 17(6), 2001.
"""

import math
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper, kernel

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


def gate(degrees: int, probability: float) -> float:
    """Return the quantile of the chi-square distribution, within 1 % from 2 degrees of freedom on.

    References
    ----------
    Wilson and Hilferty, The Distribution of Chi-Square, 1931.

    Examples
    --------
    >>> round(gate(2, 0.95), 1)
    6.0
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


def nearest_neighbours(pairs: Pairs, probability: float) -> IntArray:
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


def joint_compatibility(pairs: Pairs, probability: float) -> IntArray:
    """Return the largest set of pairs (K,) that fit together, of these the one that fits best."""
    starts = np.flatnonzero(np.diff(pairs.measurement, prepend=-1))
    first = np.append(starts, len(pairs.measurement)).astype(np.int64)
    gates = np.array([gate(2 * (i + 1), probability) for i in range(len(starts))])
    found: IntArray = _search(
        np.ascontiguousarray(pairs.innovation),
        np.ascontiguousarray(pairs.covariance),
        np.ascontiguousarray(pairs.noise),
        first,
        pairs.landmark,
        gates,
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
) -> IntArray:
    """Search the tree of pairings, measurement by measurement, depth first."""
    depth_of_all = len(first) - 1
    root = np.zeros((2 * depth_of_all, 2 * depth_of_all))  # Cholesky root of the joint covariance
    white = np.zeros(2 * depth_of_all)  # the innovation, whitened by it
    chosen = np.full(depth_of_all, -1)
    tried = first[:-1].copy()  # next pair to try at each depth; beyond the last: none
    counts = np.zeros(depth_of_all + 1, np.int64)
    totals = np.zeros(depth_of_all + 1)
    best = np.full(depth_of_all, -1)
    best_count, best_total, nodes, depth = 0, np.inf, 0, 0
    while depth >= 0:
        if depth == depth_of_all:
            count, total = counts[depth], totals[depth]
            if count > best_count or (count == best_count and total < best_total):
                best_count, best_total = count, total
                best[:] = chosen
            depth -= 1
            continue
        most = counts[depth] + depth_of_all - depth
        hopeless = most < best_count or (most == best_count and totals[depth] >= best_total)
        if tried[depth] > first[depth + 1] or hopeless or nodes > MOST_NODES:
            tried[depth] = first[depth]
            chosen[depth] = -1
            depth -= 1
            continue
        pair = tried[depth]
        tried[depth] += 1
        count, total = counts[depth], totals[depth]
        if pair == first[depth + 1]:  # the measurement is of no landmark
            chosen[depth] = -1
        else:
            if _taken(landmark, chosen, depth, landmark[pair]):
                continue
            total += _extend(root, white, chosen, depth, count, pair, innovation, covariance, noise)
            if total > gates[count]:
                continue
            count += 1
            chosen[depth] = pair
        nodes += 1
        depth += 1
        counts[depth], totals[depth] = count, total
    return best[best >= 0]


@helper
def _taken(landmark: IntArray, chosen: IntArray, depth: int, wanted: int) -> bool:
    for i in range(depth):
        if chosen[i] >= 0 and landmark[chosen[i]] == wanted:
            return True
    return False


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
