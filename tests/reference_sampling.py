"""Slow, obvious twins of ransac's kernels."""

import math

import numpy as np
import reference_candidates
import reference_engine


def numbers(state):
    """Yield the random numbers of Park and Miller (1988) after a state."""
    while True:
        state = 48271 * state % (2**31 - 1)
        yield state


def partner(beams, pool, first, window, random):
    """Twin of `partner`: one of the others in the window; where there is none, the next one."""
    others = [k for k in range(len(pool)) if k != first]
    near = [k for k in others if not window or abs(beams[pool[k]] - beams[pool[first]]) <= window]
    if not near:
        return first - 1 if first > 0 else 1
    return near[random % len(near)]


def line_through(a, b):
    """Twin of `line_through`: its normal is the step turned to the left."""
    step = b - a
    normal = np.array([-step[1], step[0]]) / np.linalg.norm(step)
    return *normal, a @ normal


def score(points, line, gate, worth):
    """Twin of `score`: the cost, the inliers and pairs of them, as far as it looks."""
    square = (points @ line[:2] - line[2]) ** 2
    cost = np.cumsum(np.minimum(square, gate**2))
    looked = min(int((cost <= worth).sum()) + 1, len(points))
    inlier = square[:looked] < gate**2
    return cost[looked - 1], inlier.sum(), (inlier[1:] & inlier[:-1]).sum()


def best_line(points, beams, pool, gate, settings, state):
    """Twin of `best_line`: (seed, line, inliers), the state, and how many samples were drawn."""
    window, log_doubt, max_trials, _ = settings
    draws = numbers(state)
    every = max(len(pool) // 128, 1)
    scored = pool[::every]
    least = sum(gate * gate for _ in scored)
    best, trials, drawn = (-1, (1.0, 0.0, 0.0), 0), max_trials, 0
    while drawn < trials:
        drawn += 1
        first = next(draws) % len(pool)
        state = next(draws)
        second = partner(beams, pool, first, window, state)
        line = line_through(points[pool[first]], points[pool[second]])
        cost, inliers, pairs = score(points[scored], line, gate, least)
        if cost < least:
            least = cost
            best = pool[first], line, inliers * every
            # The chance that a sample is a good one: both of its points are on the wall.
            good = pairs / len(scored) if window else (inliers / len(scored)) ** 2
            if good >= 1:
                break
            if good > 0:
                trials = min(trials, math.ceil(log_doubt / math.log(1 - good)))
    return best, state, drawn


def propose(points, settings, max_missed, rules):
    """Twin of `propose`: rows (c, s, d, first, last).

    `rules` are the kernel's (least points, standard deviations of a gate, failures, modulus).
    """
    least, sigmas, failures, modulus = rules
    gate = sigmas * math.sqrt(points.variance.mean())
    at, beams = reference_engine.xy(points), points.beam.astype(int)
    state = 1 + settings[3] % (modulus - 1)
    taken, in_vain = np.zeros((2, len(at)), bool)
    rows, failed = [], 0
    while failed < failures:
        pool = np.flatnonzero(~taken & ~in_vain)
        if len(pool) < least:
            break
        (seed, line, inliers), state, _ = best_line(at, beams, pool, gate, settings, state)
        if inliers < least:
            break
        found = reference_candidates.grow(points, taken, seed, line, gate, max_missed)
        in_vain[seed] = True
        failed += 1
        if found[-1] > 0:
            rows.append(reference_candidates.row(found))
            taken = reference_candidates.taken_by(points, taken, found)
            failed = 0
    return rows
