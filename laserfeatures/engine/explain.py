"""The stage that all extractors share: a scan explained as a whole.

The steps, with the numbers that docs/direct-hough.md gives them:

1. order the returns, those of a ring from a jump on
2. estimate the noise, set returns that stand out alone aside
3. propose lines (a detector's own work)
4. explain all returns at the least cost: walls, arcs, strays
5. fit the walls, merge collinear ones, find columns, part walls at steps, explain again with them
6. part the returns of walls that meet by the bearing of their corner, fit again
7. weigh the evidence of each wall, inflate the covariances
8. cut the lines into segments

What follows is the pipeline's: 9 filter the segments, 10 cross the lines.
"""

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.compiled import helper, kernel, leaf
from laserfeatures.engine.certainty import inflate_covariances, weigh_evidence
from laserfeatures.engine.columns import find_columns
from laserfeatures.engine.noise import estimate_noise
from laserfeatures.engine.partition import COLUMNS, Limits, as_candidates, as_limits, partition
from laserfeatures.engine.prices import PRICE, RETURN_PRICE
from laserfeatures.engine.segments import Found, cut_walls
from laserfeatures.engine.sequence import (
    DOUBLED,
    OPEN,
    Noise,
    Sequence,
    as_sequence,
    in_order,
    turned,
    weigh,
    without_lone,
)
from laserfeatures.engine.steps import part_at_steps
from laserfeatures.engine.sums import running_sums
from laserfeatures.engine.walls import (
    WALL,
    Walls,
    fit_walls,
    free_outliers,
    merge_collinear,
    part_at_corners,
    prune,
)

PARTINGS = 2  # at corners, each with a fit


@kernel
def prepare(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    ring: int,
    sigma: float,
    relative: float,
    roughness: float,
    correlation: float,
) -> tuple[FloatArray, tuple[float, float, float, float]]:
    """Return the table of a scan's returns, and its noise: the same four numbers.

    A negative `sigma` or `correlation` is unknown: it is estimated.
    """
    # 1. Order the returns.
    table = in_order(directions, ranges, limits, ring)
    points = as_sequence(table)
    # 2. Estimate the noise.
    noise = Noise(sigma, relative, roughness, correlation)
    if sigma < 0.0 or correlation < 0.0:
        noise = estimate_noise(points, noise)
    weigh(points, noise)
    told = (noise.sigma, noise.relative, noise.roughness, noise.correlation)
    return without_lone(table), told


@kernel
def explain(
    table: FloatArray,
    proposed: FloatArray,
    ring: int,
    beams: int,
    bounds: tuple[int, int, float, float, int, bool],
    rounds: int,
) -> Found:
    """Return the lines and segments that explain a scan's returns.

    Parameters
    ----------
    table : (ROWS, P) array
        What `prepare` returned.
    proposed : (COLUMNS, K) array
        The lines that a detector proposes, as `Candidates`; none: all are looked for.
    ring : int
        How the beams go round.
    beams : int
        Number of beams of the scan.
    bounds : tuple
        What a wall may be, as `Limits`.
    rounds : int
        How often all is explained again with the walls found before.
    """
    limits = as_limits(bounds)
    points = as_sequence(table)
    sums = running_sums(points)
    nothing = np.empty((2, 0), np.int64)
    label, walls = settle(points, sums, proposed, nothing, PRICE, limits)
    columns = find_columns(points, label, walls, limits.max_pole_radius)
    walls = part_at_steps(points, label, walls, limits.min_points)
    start = better_seam(points, label) if ring != OPEN else 0
    if start > 0:
        points = as_sequence(turned(table, start, beams - (ring == DOUBLED)))
        columns = turned_columns(columns, start, label.size)
        sums = running_sums(points)
        rounds = max(rounds, 1)
    for round_ in range(rounds):
        everywhere = label.size if round_ == 0 and start > 0 else 0
        lines = as_proposed(walls, limits.min_points, everywhere)
        label, walls = settle(points, sums, lines, columns, RETURN_PRICE, limits)
    # 6. Part walls at their corners.
    for _ in range(PARTINGS):
        if part_at_corners(points, label, walls) == 0:
            break
        fit_walls(points, label, walls, True)
    walls = walls[: prune(label, walls, limits.min_points)]
    # 7. Weigh evidence, inflate covariances.
    weigh_evidence(points, label, walls)
    walls = walls[: prune(label, walls, limits.min_points)]
    inflate_covariances(points, walls, limits.roughness_told)
    # 8. Cut the lines into segments.
    return cut_walls(points, label, walls, beams, limits)


@helper
def settle(
    points: Sequence,
    sums: FloatArray,
    lines: FloatArray,
    columns: IntArray,
    price: float,
    limits: Limits,
) -> tuple[IntArray, Walls]:
    """Explain the returns by some lines and others, fit the walls and merge those on one line."""
    label = np.empty(points.x.size, np.int64)
    known = as_candidates(lines)
    # 4. Explain all returns at the least cost.
    walls = np.zeros(partition(points, sums, known, columns, price, limits, label), WALL)
    for k in range(known.c.size):
        walls[k].c = known.c[k]
        walls[k].s = known.s[k]
        walls[k].d = known.d[k]
    # 5. Fit the walls, merge collinear ones.
    free_outliers(points, label, walls, known.c.size)
    if walls.size > known.c.size:  # new ones have no incidence yet
        fit_walls(points, label, walls, False)
    fit_walls(points, label, walls, True)
    merge_collinear(points, label, walls)
    return label, walls


@helper
def as_proposed(walls: Walls, min_points: int, everywhere: int) -> FloatArray:
    """Return walls as a table of candidates; if `everywhere` is > 0, for so many returns each."""
    lines = np.empty((COLUMNS, walls.size))
    count = 0
    for k in range(walls.size):
        wall = walls[k]
        if wall.points >= min_points:
            lines[0, count] = wall.c
            lines[1, count] = wall.s
            lines[2, count] = wall.d
            lines[3, count] = 0.0 if everywhere > 0 else wall.first
            lines[4, count] = everywhere if everywhere > 0 else wall.last
            count += 1
    return lines[:, :count].copy()


@helper
def turned_columns(columns: IntArray, start: int, n: int) -> IntArray:
    """Return where columns begin and end when a ring begins at another return."""
    out = np.empty_like(columns)
    count = 0
    for k in range(columns.shape[1]):
        out[0, count] = (columns[0, k] - start) % n
        out[1, count] = (columns[1, k] - 1 - start) % n + 1
        count += out[0, count] < out[1, count]
    return out[:, :count].copy()


@leaf
def better_seam(points: Sequence, label: IntArray) -> int:
    """Return where to cut a ring so that no wall is cut: 0 where it is right already.

    It is the widest step between two walls; strays inside of one wall are no place.
    """
    n = label.size
    if n == 0 or (label[0] >= 0 and label[n - 1] >= 0 and label[0] != label[n - 1]):
        return 0
    widest = step = -1.0
    start = at = 0
    before = -1
    for i in range(n):
        if i > 0 and before >= 0:  # the widest step since the last return of a wall
            square = (points.x[i] - points.x[i - 1]) ** 2 + (points.y[i] - points.y[i - 1]) ** 2
            if square > step:
                step = square
                at = i
        if label[i] >= 0:
            if before >= 0 and label[i] != before and step > widest:
                widest = step
                start = at
            before = label[i]
            step = -1.0
    return start
