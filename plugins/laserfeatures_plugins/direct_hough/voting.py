"""Kernels that let neighbouring points vote together, and find the peaks of their votes."""

import math

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.engine import leaf

THINNING = 0.5  # of a chord: points closer than that have the same to say
FLANK = 3  # rows of theta beside a peak that only repeat it
BINS = 1024  # of d, used in turns: lines so far apart that they share a bin are told apart later
ROW = BINS + 16  # a row that is no power of two long keeps the cache's sets apart
ORIGIN = 2.0**40  # a multiple of BINS that keeps the bins of negative d positive


@leaf
def direction(nx: float, ny: float) -> float:
    """Return the angle of the normal (nx, ny) in [0, pi], to 1e-3 rad: rows are wider than that."""
    if ny < 0.0:
        nx, ny = -nx, -ny
    if abs(nx) > ny:
        z = ny / nx
        theta = 0.0 if nx > 0.0 else math.pi
    else:
        z = -nx / ny
        theta = 0.5 * math.pi
    zz = z * z
    return theta + z * (0.99535795 - zz * (0.28869091 - 0.0793395 * zz))


@leaf
def at_least(value: int, floor: int) -> int:
    """Return the larger of two numbers without a branch: the processor would guess half wrong."""
    above = value - floor
    return floor + (above & ~(above >> 63))


@leaf
def vote_pairs(
    x: FloatArray,
    y: FloatArray,
    live: IntArray,
    cos: FloatArray,
    sin: FloatArray,
    distance_step: float,
    chord: float,
    tolerance: float,
    partners: int,
    votes: NDArray[np.int32],
    base: int,
    best: IntArray,
) -> None:
    """Let pairs of neighbouring points vote for the lines through both.

    A point whose neighbour along the scan is at least `chord` metres away can only lie on one wall
    with it if the wall's normal is the chord's, give or take `tolerance` / length. So each of the
    first `partners` such neighbours adds votes in that window of theta, at the middle of the chord.
    Of points much closer to each other than `chord` one votes for all.

    Parameters
    ----------
    live : (M,) int array
        The points that may vote, in beam order.
    votes : (T, ROW) int32 array
        The accumulator. Cells at or below `base` are empty, so that it needs no clearing.
    best : (T,) int array
        Filled with each theta's most votes << 32 | one of the points that cast them.
    """
    rows = cos.size
    per_radian = rows / math.pi
    scale = 1.0 / distance_step
    for t in range(rows):
        best[t] = 0
    partner = 0
    last_x = last_y = math.inf
    for a in range(live.size - 1):
        i = live[a]
        if (x[i] - last_x) ** 2 + (y[i] - last_y) ** 2 < (THINNING * chord) ** 2:
            continue
        last_x = x[i]
        last_y = y[i]
        partner = max(partner, a + 1)
        while partner < live.size:
            j = live[partner]
            if (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 >= chord * chord:
                break
            partner += 1
        for b in range(partner, min(partner + partners, live.size)):
            j = live[b]
            dx = x[j] - x[i]
            dy = y[j] - y[i]
            width = min(tolerance / math.sqrt(dx * dx + dy * dy) * per_radian, 0.5 * rows)
            centre = direction(-dy, dx) * per_radian
            t = math.ceil(centre - width)
            window = min(max(math.floor(centre + width) - t + 1, 1), rows)
            if t < 0:
                t += rows
            mx = 0.5 * (x[i] + x[j]) * scale
            my = 0.5 * (y[i] + y[j]) * scale
            while window > 0:
                end = min(t + window, rows)
                for row in range(t, end):
                    k = int(mx * cos[row] + my * sin[row] + ORIGIN) & (BINS - 1)
                    cell = at_least(int(votes[row, k]), base) + 1
                    votes[row, k] = cell
                    best[row] = at_least(int(best[row]), (cell - base) << 32 | i)
                window -= end - t
                t = 0  # theta wraps


@leaf
def next_peak(best: IntArray, done: BoolArray, min_votes: int) -> int:
    """Return the theta with most votes that is not `done`, or -1; mark it and its flanks."""
    rows = best.size
    peak = -1
    most = (min_votes << 32) - 1
    for t in range(rows):
        if best[t] > most and not done[t]:
            most = best[t]
            peak = t
    if peak >= 0:
        for flank in range(peak - FLANK, peak + FLANK + 1):
            t = flank % rows  # theta wraps
            done[t] = done[t] or best[t] <= most
    return peak
