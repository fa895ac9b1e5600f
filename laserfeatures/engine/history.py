"""What many scans show of the noise, gathered in cells so that it takes no more room as they come.

A cell holds the stretches (see `noise`) whose variances and whose squared ranges are about the
same: how many, and the sums of both. What is fitted to the cells is what would be fitted to all of
the stretches.
"""

import math

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.compiled import helper, kernel
from laserfeatures.engine.noise import (
    FEWEST,
    LOW,
    UNKNOWN,
    WIDTH,
    fit_noise,
    likeness,
    stretches,
)
from laserfeatures.engine.sequence import as_sequence, in_order

# Rows of the cells: so many stretches, and sums over them.
COUNT, VARIANCE, SQUARE, STEPS = range(4)
VARIANCES = (1e-10, 0.2, 120)  # [m^2]: least, logarithm of the ratio of two cells, how many
SQUARES = (1e-4, 0.5, 40)  # [m^2]
CELLS = VARIANCES[2] * SQUARES[2]
PURE = 1.081  # what the fit says where all stretches show a variance of 1 and have 6 freedoms


@helper
def cell_of(value: float, axis: tuple[float, float, int]) -> int:
    """Return the number of the cell that a value is in, along one axis."""
    least, ratio, count = axis
    return min(max(int(math.log(max(value, least) / least) / ratio), 0), count - 1)


@kernel
def gather(
    directions: FloatArray,
    ranges: FloatArray,
    limits: tuple[float, float],
    ring: int,
    cells: FloatArray,
    keep: float,
) -> tuple[int, float, float]:
    """Add the stretches of a scan to the cells (4, CELLS), which first forget all but `keep`.

    Returns
    -------
    stretches : int
        How many the scan has; where it has none, nothing is forgotten.
    least : float
        The variance that the steps in which the sensor counts have by themselves [m^2].
    mean : float
        The mean range [m].
    """
    points = as_sequence(in_order(directions, ranges, limits, ring))
    variance, square, steps, least, mean = stretches(points)
    if variance.size == 0:
        return 0, least, mean
    cells *= keep
    for k in range(variance.size):
        cell = cell_of(variance[k], VARIANCES) * SQUARES[2] + cell_of(square[k], SQUARES)
        cells[COUNT, cell] += 1.0
        cells[VARIANCE, cell] += variance[k]
        cells[SQUARE, cell] += square[k]
        cells[STEPS, cell] += steps[k]
    return variance.size, least, mean


@kernel
def fit_cells(cells: FloatArray, least: float, mean: float, alike: float) -> FloatArray:
    """Fit sigma^2 and relative^2 to the cells; return these two and their standard errors.

    Parameters
    ----------
    cells : (4, CELLS) array
        What `gather` gathered.
    least, mean : float
        Of the scans: the least variance [m^2], the mean range [m].
    alike : float
        Variance of a count of a cell, in counts: less than 1 where old scans count less.
    """
    used = np.flatnonzero(cells[COUNT] > 0.0)
    count = cells[COUNT][used]
    variance = cells[VARIANCE][used] / count
    square = cells[SQUARE][used] / count
    steps = cells[STEPS][used] / count
    if count.sum() < FEWEST:
        unknown = max((UNKNOWN * mean) ** 2, least)
        return np.array([unknown, 0.0, unknown, math.inf, 0.0])
    begin = low_quantile(variance, count)
    constant, growing = fit_noise(variance, square, count, begin, least)
    errors = fit_errors(variance, square, count, constant, growing)
    error = math.sqrt(errors[0] * alike) / PURE
    error_growing = math.sqrt(errors[1] * alike) / PURE
    alike = likeness(variance, square, steps, count, constant, growing)
    constant = max(constant / PURE, least)
    return np.array([constant, growing / PURE, error, error_growing, alike])


@helper
def low_quantile(variance: FloatArray, count: FloatArray) -> float:
    """Return the variance that the share `LOW` of the stretches stays below."""
    order = np.arange(variance.size)
    for k in range(1, order.size):  # nearly sorted; and numba's sort takes 1.4 s to compile
        at = k
        while at > 0 and variance[order[at - 1]] > variance[k]:
            order[at] = order[at - 1]
            at -= 1
        order[at] = k
    below = LOW * count.sum()
    at = 0
    while at < order.size - 1 and count[order[at]] <= below:
        below -= count[order[at]]
        at += 1
    return float(variance[order[at]])


@helper
def fit_errors(
    variance: FloatArray, square: FloatArray, count: FloatArray, constant: float, growing: float
) -> tuple[float, float]:
    """Return the variances of what `fit_noise` fits (sandwich: slopes, scatter, slopes)."""
    slope = np.zeros((2, 2))
    scatter = np.zeros((2, 2))
    for k in range(variance.size):
        s = square[k]
        expected = constant + growing * s
        off = math.log(variance[k] / expected) / WIDTH
        if abs(off) >= 1.0:
            continue
        flat = 1.0 - off * off
        weight = (flat / expected) ** 2
        error = variance[k] - expected
        falls = (4.0 * flat * off / WIDTH - 2.0 * flat * flat) / expected**3
        one = count[k] * (weight - error * falls)
        two = count[k] * (weight * error) ** 2
        slope += np.array([[one, one * s], [one * s, one * s * s]])
        scatter += np.array([[two, two * s], [two * s, two * s * s]])
    det = slope[0, 0] * slope[1, 1] - slope[0, 1] ** 2
    alone = scatter[0, 0] / slope[0, 0] ** 2
    if det <= 1e-9 * slope[0, 0] * slope[1, 1]:
        return alone, math.inf
    a, b, d = slope[1, 1] / det, -slope[0, 1] / det, slope[0, 0] / det
    both = a * a * scatter[0, 0] + 2.0 * a * b * scatter[0, 1] + b * b * scatter[1, 1]
    return (
        both if growing > 0.0 else alone,
        b * b * scatter[0, 0] + 2.0 * b * d * scatter[0, 1] + d * d * scatter[1, 1],
    )
