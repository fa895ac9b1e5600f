"""Slow, obvious twins of direct_hough's kernels."""

import math

import numpy as np
import reference_candidates
import reference_engine


def votes(points, theta, d):
    """Twin of `accumulate`: each point votes, in each row, for the nearest distance."""
    counts = np.zeros((theta.size, d.size), int)
    for x, y in points:
        for t in range(theta.size):
            counts[t, np.argmin(abs(d - (x * math.cos(theta[t]) + y * math.sin(theta[t]))))] += 1
    return counts


def peaks(counts, threshold, max_peaks, window_d, window_theta):
    """Twin of `_find_peaks`: the highest cell outside the windows of the peaks before it."""
    rows, columns = counts.shape
    found = []
    free = np.ones(counts.shape, bool)
    while len(found) < max_peaks:
        left = np.where(free, counts, -1)
        row, column = np.unravel_index(np.argmax(left), counts.shape)
        if left[row, column] < threshold:
            break
        found.append((row, column))
        for t in range(rows):
            for k in range(columns):
                # One half turn on, the cell stands for the same line with -d.
                for turns in range(-3, 4):
                    there = k if turns % 2 == 0 else columns - 1 - k
                    near_theta = abs(t + turns * rows - row) <= window_theta // 2
                    if near_theta and abs(there - column) <= window_d // 2:
                        free[t, k] = False
    return found


def pair_votes(points, live, rows, distance_step, chord, tolerance, partners, rules, slack):
    """Twin of `vote_pairs`: the most votes of one cell in each row.

    The kernel's angles are good to 1e-3 rad: windows are made wider by `slack` rows, or narrower.
    `rules` are the kernel's (thinning, first whole number of the bins, number of bins).
    """
    thinning, origin, bins = rules
    cells = np.zeros((rows, bins), int)
    last, partner = np.array([math.inf, math.inf]), 0
    for a in range(len(live) - 1):
        here = points[live[a]]
        if np.linalg.norm(here - last) < thinning * chord:
            continue
        last = here
        partner = max(partner, a + 1)  # the search for partners never goes back
        while partner < len(live) and np.linalg.norm(points[live[partner]] - here) < chord:
            partner += 1
        for b in range(partner, min(partner + partners, len(live))):
            step = points[live[b]] - here
            normal = math.atan2(step[0], -step[1]) * rows / math.pi
            width = min(tolerance / np.linalg.norm(step) * rows / math.pi, rows / 2) + slack
            middle = (here + points[live[b]]) / 2 / distance_step
            if slack > 0:
                width = max(width, 1.0)  # a window has a row, however narrow it is
            for row in range(rows):
                off = (row - normal + rows / 2) % rows - rows / 2
                if abs(off) <= width:
                    angle = row * math.pi / rows
                    cell = middle[0] * math.cos(angle) + middle[1] * math.sin(angle)
                    cells[row, int(cell + origin) % bins] += 1
    return cells.max(axis=1)


def peak_rows(counts, min_votes, flank):
    """Twin of repeated `next_peak`: rows by falling votes, but not those beside a higher one."""
    done = set()
    found = []
    for row in sorted(range(len(counts)), key=lambda t: -counts[t]):
        if row not in done and counts[row] >= min_votes << 32:
            found.append(row)
            for t in range(row - flank, row + flank + 1):
                if counts[t % len(counts)] <= counts[row]:
                    done.add(t % len(counts))
    return found


def propose(points, rows, distance_step, max_missed, vote, rules):
    """Twin of `propose`: rows (c, s, d, first, last).

    `vote` lets points vote, with so many partners, and returns what `vote_pairs` fills. `rules` are
    the kernel's (least points, partners, least votes, rows beside a peak).
    """
    least, partners, min_votes, flank = rules
    at = reference_engine.xy(points)
    tolerance = distance_step / 4 + 2 * math.sqrt(points.variance.mean())
    taken = np.zeros(len(at), bool)
    found, grew = [], True
    while grew and (~taken).sum() >= least:
        grew = False
        best = vote(at, np.flatnonzero(~taken), tolerance, partners if found else 1)
        for row in peak_rows(best.tolist(), min_votes, flank):
            seed = int(best[row]) & 0xFFFFFFFF
            if taken[seed]:
                continue
            normal = math.cos(row * math.pi / rows), math.sin(row * math.pi / rows)
            line = *normal, at[seed] @ normal
            wall = reference_candidates.grow(points, taken, seed, line, distance_step, max_missed)
            if wall[-1] > 0:
                found.append(reference_candidates.row(wall))
                taken = reference_candidates.taken_by(points, taken, wall)
                grew = True
    return found
