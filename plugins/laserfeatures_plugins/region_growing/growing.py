"""The kernels: walls grown from pairs of neighbouring points, in the order of the scan."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry import Fit, fit_line, helper, inlined, is_gap, kernel
from laserfeatures.geometry.fit import direction, line_of_sums
from laserfeatures.geometry.growth import gate_of
from laserfeatures.geometry.noise import MIN_SIGMA
from laserfeatures.geometry.segments import MAX_GROWTH
from laserfeatures.geometry.settle import Found, free_points, settle
from laserfeatures.geometry.walls import FREE, Cut, is_wall, keep_wall

ENOUGH = 15  # degrees of freedom from which they do
PARTNERS = 2  # points that a seed tries as its second: one outlier may stand between


@kernel
def extract(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    sigma: float,
    jump: float,
    radius: float,
    cut: Cut,
) -> Found:
    """Return what `line_segments` takes; `sigma` 0 stands for unknown."""
    x, y, beam, owner, noise = free_points(directions, ranges, limits, sigma, jump, radius)
    walls, seen = search(x, y, beam, owner, noise, cut)
    return settle(x, y, beam, ranges.size, owner, walls, sigma or seen, gate_of(noise), True, cut)


@inlined
def search(
    x: FloatArray, y: FloatArray, beam: IntArray, owner: IntArray, sigma: float, cut: Cut
) -> tuple[FloatArray, float]:
    """Grow a wall from each point that is free when its turn comes; fill `owner`.

    Returns the walls and the noise that they show.
    """
    least = cut[0] - 1
    walls = np.empty((x.size // least + 1, 6))
    members = np.empty(x.size, np.int64)
    count = 0
    squares = freedom = 0.0
    gate = gate_of(sigma)
    for seed in range(x.size - 1):
        if owner[seed] != FREE:
            continue
        partner = seed
        for _ in range(PARTNERS):
            partner = next_free(beam, owner, partner, beam[seed] + cut[1] + 1)
            if partner < 0:
                break
            found, fit = grow_region(
                x, y, beam, owner, seed, partner, gate, cut[1], cut[2], members
            )
            if found < least:
                continue
            flat, variance, worst = is_wall(x, y, members[:found], fit, sigma)
            if worst > gate:
                found, fit = refine(x, y, members, found, fit, gate, least)
                if found < least:
                    continue
                flat, variance, worst = is_wall(x, y, members[:found], fit, sigma)
            if not flat:
                continue
            for i in members[:found]:
                owner[i] = count
            keep_wall(walls[count], fit, found)
            count += 1
            squares += variance * (found - 2)
            freedom += found - 2
            break
    if freedom >= ENOUGH:
        sigma = min(max(math.sqrt(squares / freedom), MIN_SIGMA), 2.0 * sigma)
    return walls[:count], sigma


@helper
def next_free(beam: IntArray, owner: IntArray, i: int, last_beam: int) -> int:
    """Return the free point that follows point i, up to that beam, or -1."""
    for j in range(i + 1, owner.size):
        if beam[j] > last_beam:
            break
        if owner[j] == FREE:
            return j
    return -1


@helper
def grow_region(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    owner: IntArray,
    seed: int,
    partner: int,
    gate: float,
    max_missed: int,
    max_gap: float,
    members: IntArray,
) -> tuple[int, Fit]:
    """Put two points and what continues their line into `members`.

    Returns how many, and the line, with the variances of a fit without weights. A point belongs
    where it is within `gate` of the line so far, widened by that line's own uncertainty there. The
    line follows from running sums whenever nearly as many points have come again. More than
    `max_missed` beams off the line, or a gap, end the region.
    """
    members[0] = seed
    members[1] = partner
    n = 2
    sx = x[partner] - x[seed]
    sy = y[partner] - y[seed]
    sxx = sx * sx
    sxy = sx * sy
    syy = sy * sy
    last = partner
    spacing = math.sqrt(sxx + syy) / (beam[partner] - beam[seed])
    refit_at = 2
    mx = my = ux = uy = tightness = inverse = 0.0
    for i in range(partner + 1, x.size):
        if refit_at == n:
            refit_at = 2 * n - 1 if n > 2 else 3
            inverse = 1.0 / n
            mx = sx * inverse
            my = sy * inverse
            ux, uy, spread = direction(sxx - sx * mx, sxy - sx * my, syy - sy * my)
            tightness = 1.0 / spread
        apart = beam[i] - beam[last]
        if apart > max_missed + 1:
            break
        dx = x[i] - x[seed]
        dy = y[i] - y[seed]
        along = (dx - mx) * ux + (dy - my) * uy
        off = (dy - my) * ux - (dx - mx) * uy
        if owner[i] != FREE or off * off > gate * gate * (
            1.0 + inverse + along * along * tightness
        ):
            continue
        step = abs((x[i] - x[last]) * ux + (y[i] - y[last]) * uy)
        if is_gap(apart, step, spacing, max_missed, max_gap, MAX_GROWTH):
            break
        spacing = step / apart
        members[n] = i
        n += 1
        sx += dx
        sy += dy
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
        last = i
    return n, line_of_sums(x[seed], y[seed], n, sx, sy, sxx, sxy, syy)


@helper
def refine(
    x: FloatArray,
    y: FloatArray,
    members: IntArray,
    count: int,
    fit: Fit,
    gate: float,
    min_points: int,
) -> tuple[int, Fit]:
    """Drop the points of a region that are off its line and refit, until none is."""
    while count >= min_points:
        c = math.cos(fit[0])
        s = math.sin(fit[0])
        kept = 0
        for i in members[:count]:
            members[kept] = i
            kept += abs(x[i] * c + y[i] * s - fit[1]) <= gate
        if kept == count:
            break
        count = kept
        if count >= min_points:
            fit = fit_line(x, y, members[:count], fit[0])
    return count, fit
