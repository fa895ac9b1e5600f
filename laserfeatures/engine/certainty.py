"""How sure a wall is, and how well its line is known (step 7)."""

import math

import numpy as np

from laserfeatures.arrays import IntArray
from laserfeatures.compiled import helper, leaf
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.prices import PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import INCIDENCE_FLOOR, Sequence
from laserfeatures.engine.walls import Walls, misfit

SECOND = 0.75  # of d^2 var_theta^2: the mean and the variance of d turn^2 / 2
LARGEST = 4.0  # chi squared of a wall for each degree of freedom, as far as it counts
PRIOR = 5.0  # degrees of freedom that show no roughness
ALIKE = 16.0  # returns of a rough wall whose errors are alike


@helper
def weigh_evidence(points: Sequence, label: IntArray, walls: Walls) -> None:
    """Fill in by how much the scan is more likely with each wall than without [nats].

    Without it, its returns would be stray ones, or on the walls beside it.
    """
    n = label.size
    after = np.empty(n, np.int64)
    following = here = STRAY
    for i in range(n - 1, -1, -1):
        if label[i] >= 0 and label[i] != here:
            following = here
            here = label[i]
        after[i] = following
    for k in range(walls.size):
        walls[k].evidence = -0.5 * PRICE
    before = here = STRAY
    for i in range(n):
        k = label[i]
        if k < 0:
            continue
        if k != here:
            before = here
            here = k
        wall = walls[k]
        without = STRAY_PRICE
        for other in (before, after[i]):
            if other >= 0 and other != k:
                beside = walls[other]
                chi2 = misfit(points, i, beside.c, beside.s, beside.d)
                without = min(without, chi2)
        chi2 = misfit(points, i, wall.c, wall.s, wall.d)
        wall.evidence += 0.5 * (without - min(chi2, STRAY_PRICE))
    for k in range(walls.size):
        if walls[k].evidence <= 0.0:
            walls[k].evidence = 0.0
            walls[k].points = 0  # as likely without: it is none


@leaf
def excess_of(walls: Walls) -> tuple[float, float]:
    """Return what walls show beyond the noise, in its variances, and the degrees of freedom.

    What one wall can show is bounded: it may be none.
    """
    chi2 = freedom = 0.0
    for k in range(walls.size):
        free = walls[k].points - 2.0
        chi2 += min(walls[k].chi2, LARGEST * free)
        freedom += free
    return chi2 / max(freedom, 1.0) - 1.0, freedom


@leaf
def inflate_covariances(points: Sequence, walls: Walls, told: bool) -> None:
    """Inflate the covariances of lines by what does not average out along a wall.

    That is its roughness: over `ALIKE` returns its errors are alike. Where no roughness is told,
    what the walls show beyond the noise tells it, with `PRIOR` degrees of freedom that show none.
    """
    share = 0.0
    for i in range(points.x.size):
        rough = points.floor[i] - points.lasting[i] - INCIDENCE_FLOOR
        share += rough / (1.0 + rough)
    share /= max(points.x.size, 1)
    if not told:
        excess, freedom = excess_of(walls)
        sure = max(excess - math.sqrt(2.0 / max(freedom, 1.0)), 0.0)
        share += sure * freedom / (freedom + PRIOR)
    for k in range(walls.size):
        wall = walls[k]
        ratio = 1.0 + share * min(wall.points, ALIKE)
        # To second order: d (1 - cos) of the turn, which for a short wall is more than its var_d.
        wall.var_d = ratio * wall.var_d + SECOND * (wall.d * ratio * wall.var_theta) ** 2
        wall.var_theta *= ratio
        wall.cov *= ratio
