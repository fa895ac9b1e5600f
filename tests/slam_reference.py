"""Slow, obvious twins of the filter's parts: full matrices, and all pairings one by one."""

import itertools
import math

import numpy as np


def moved(mean, covariance, step, noise):
    """Twin of `State.move`: the whole Jacobian of the whole state."""
    x, y, theta = mean[:3]
    c, s = math.cos(theta), math.sin(theta)
    after = mean.copy()
    after[:3] = x + c * step.x - s * step.y, y + s * step.x + c * step.y, theta + step.theta
    by_state = np.eye(len(mean))
    by_state[0, 2], by_state[1, 2] = -s * step.x - c * step.y, c * step.x - s * step.y
    by_step = np.zeros((len(mean), 3))
    by_step[:3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    return after, by_state @ covariance @ by_state.T + by_step @ noise @ by_step.T


def corrected(mean, covariance, whole, innovation, noise):
    """Twin of `State.correct` before anything is carried over: Joseph's form as it is written."""
    expected = whole @ covariance @ whole.T + noise
    gain = covariance @ whole.T @ np.linalg.inv(expected)
    left = np.eye(len(mean)) - gain @ whole
    squared = innovation @ np.linalg.inv(expected) @ innovation
    return (
        mean + gain @ innovation,
        left @ covariance @ left.T + gain @ noise @ gain.T,
        float(squared),
    )


def moved_frame(mean, is_wall, anchors, pivot, motion):
    """Return by how much a small motion of the map's frame changes each number of a state.

    The motion (tx, ty, a) shifts everything by t and turns it about the pivot.
    """
    t, a = np.asarray(motion[:2]), motion[2]

    def shift(point):
        off = np.asarray(point) - pivot
        return t + a * np.array([-off[1], off[0]])

    change = np.zeros(len(mean))
    change[:2], change[2] = shift(mean[:2]), a
    for i, (wall, anchor) in enumerate(zip(is_wall, anchors, strict=True)):
        first, second = mean[3 + 2 * i : 5 + 2 * i]
        if wall:  # its normal turns; its anchor is a number and stays where it is
            normal = np.array([math.cos(first), math.sin(first)])
            change[3 + 2 * i : 5 + 2 * i] = a, normal @ shift(anchor)
        else:
            change[3 + 2 * i : 5 + 2 * i] = shift((first, second))
    return change


def pairings(pairs):
    """Yield all sets of pairs in which no measurement and no landmark is twice."""
    for count in range(len(pairs.measurement) + 1):
        for some in itertools.combinations(range(len(pairs.measurement)), count):
            which = list(some)
            if len(set(pairs.measurement[which])) == len(set(pairs.landmark[which])) == count:
                yield which


def joint(pairs, which):
    """Return squared distance and log-likelihood of a set of pairs, as one measurement."""
    rows = [2 * i + k for i in which for k in range(2)]
    total = pairs.covariance[np.ix_(rows, rows)].copy()
    for place, i in enumerate(which):
        total[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] += pairs.noise[i]
    innovation = pairs.innovation[which].ravel()
    squared = float(innovation @ np.linalg.inv(total) @ innovation) if which else 0.0
    sign, log_of = np.linalg.slogdet(math.tau * total) if which else (1.0, 0.0)
    assert sign > 0
    return squared, -(squared + log_of) / 2


def best_pairing(pairs, gates, density):
    """Twin of `joint_compatibility`: the best of all pairings whose every part is compatible."""
    best, highest = [], 0.0
    for which in pairings(pairs):
        fits = all(
            joint(pairs, which[:count])[0] <= gates[count - 1] for count in range(1, len(which) + 1)
        )
        score = joint(pairs, which)[1] - len(which) * math.log(density)
        if fits and score > highest:
            best, highest = which, score
    return best, highest
