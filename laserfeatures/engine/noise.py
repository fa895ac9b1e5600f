"""The noise of a scan's ranges, told from short stretches of it (step 2)."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.compiled import helper, leaf
from laserfeatures.engine.sequence import MISSED, Noise, Sequence

STRETCH = 8  # returns
FREEDOM = STRETCH - 2.0
FEWEST = 4  # stretches that tell a noise
APART = 12  # of fewer stretches, each is half of the one before
LOW = 0.1  # quantile of the stretches' variances at which the search begins
FAR = 8.0  # times as far from its neighbours as they from each other is a stray
ROUNDS = 6  # of reweighting
WIDTH = 1.5  # log of the ratio by which a stretch's variance may be off and still count
FINEST = 1e-4  # of the mean range: no sensor is better
COARSE = 2.0  # times the variance of counting: less may be the steps in which the sensor counts
UNKNOWN = 3e-3  # of the mean range: taken where there is too little to tell
# Von Neumann's ratio (1941): the squared steps from error to error over the squared errors, about a
# line through eight; where errors are independent, its mean and deviation, without shared bends.
PARABOLA = 2.0 / 3.0  # of errors that are a parabola through eight
INDEPENDENT, SCATTER = 2.39, 0.58
MANY = 12  # stretches that tell how alike neighbours' errors are
SURE = 3.5  # standard errors: less may be chance


@helper
def estimate_noise(points: Sequence, known: Noise) -> Noise:
    """Estimate what is unknown (negative) of a scan's noise from what its flat stretches show.

    The variances of stretches on walls gather round sigma^2 + (relative r)^2; those of all others
    lie above, anywhere. A fit by weights that fall to nothing (Tukey's biweight of the logarithm),
    begun at a low quantile, settles on the former.
    """
    variance, square, steps, least, mean = stretches(points)
    sigma, relative, correlation = known.sigma, known.relative, known.correlation
    if variance.size < FEWEST:
        if sigma < 0.0:
            sigma, relative = max(UNKNOWN * mean, math.sqrt(least)), 0.0
        return Noise(sigma, relative, known.roughness, max(correlation, 0.0))
    one = np.ones(variance.size)
    if sigma < 0.0:
        begin = smallest(variance.copy(), int(LOW * variance.size))
        constant, growing = fit_noise(variance, square, one, begin, least)
        sigma, relative = math.sqrt(constant), math.sqrt(growing)
    if correlation < 0.0:
        correlation = 0.0
        if points.x.size >= APART * STRETCH:
            correlation = likeness(variance, square, steps, one, sigma**2, relative**2)
    return Noise(sigma, relative, known.roughness, correlation)


@leaf
def smallest(values: FloatArray, k: int) -> float:
    """Return the value that k others are no larger than; reorders them (Hoare's selection).

    numba's own partition takes 4 s to compile.
    """
    low, high = 0, values.size - 1
    while low < high:
        pivot = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if k <= j:
            high = j
        elif k >= i:
            low = i
        else:
            break
    return values[k]


@leaf
def likeness(
    variance: FloatArray,
    square: FloatArray,
    steps: FloatArray,
    count: FloatArray,
    constant: float,
    growing: float,
) -> float:
    """Return how alike the errors of neighbouring ranges are, 0 where that may be chance.

    The errors of independent ranges step from each to the next; those of neighbours that a sensor
    smooths or interpolates do so less, and stray the farther over a long wall.
    """
    n = ratio = 0.0
    for k in range(variance.size):
        expected = constant + growing * square[k]
        if abs(math.log(variance[k] / expected)) < WIDTH:
            n += count[k]
            ratio += count[k] * steps[k]
    alike = 1.0 - ratio / max(n, 1.0) / INDEPENDENT
    if n < MANY or alike < SURE * SCATTER / INDEPENDENT / math.sqrt(n):
        return 0.0
    return alike


@helper
def stretches(
    points: Sequence,
) -> tuple[FloatArray, FloatArray, FloatArray, float, float]:
    """Return what each stretch shows: variance, mean squared range and steps; the least; the mean.

    The variance is that of the ranges about the best line (see `sums`). It is at least that of the
    steps in which the sensor counts; the mean is that of the ranges.
    """
    n = points.x.size
    every = STRETCH if n >= APART * STRETCH else STRETCH // 2
    variance = np.empty(n // every + 1)
    square = np.empty(n // every + 1)
    steps = np.empty(n // every + 1)
    steady = np.arange(n)
    count = without_strays(points.x, points.y, steady)
    counting, mean = counting_and_mean(points)
    least = max((FINEST * mean) ** 2, counting)
    count = scatters(points, steady[:count], every, counting, variance, square, steps)
    for k in range(count):
        variance[k] = max(variance[k], least)
    return variance[:count], square[:count], steps[:count], least, mean


@leaf
def counting_and_mean(points: Sequence) -> tuple[float, float]:
    """Return the variance by the steps in which the sensor counts ranges, and their mean."""
    n = points.x.size
    total = before = 0.0
    resolution = math.inf
    for i in range(n):
        r = points.x[i] * points.ux[i] + points.y[i] * points.uy[i]
        total += r
        change = abs(r - before)
        if 1e-9 * r < change < resolution:
            resolution = change
        before = r
    counting = resolution * resolution / 12.0 if n > 1 and resolution < math.inf else 0.0
    return counting, total / max(n, 1)


@leaf
def scatters(
    points: Sequence,
    steady: IntArray,
    every: int,
    counting: float,
    variance: FloatArray,
    square: FloatArray,
    steps: FloatArray,
) -> int:
    """Fill in what the stretches of the `steady` returns show; return how many tell something."""
    count = 0
    before = 0.0
    for i in range(0, steady.size - STRETCH + 1, every):
        misfit, weight, stepping, bend = scatter(points, steady[i : i + STRETCH])
        long = points.beam[steady[i + STRETCH - 1]] - points.beam[steady[i]] >= STRETCH + MISSED
        if long or misfit < 0.0:
            before = 0.0
            continue
        variance[count] = misfit / FREEDOM
        square[count] = weight / STRETCH
        # What bends as the stretch before does is the shape of the wall.
        curved = min(max(bend * before, 0.0), bend * bend)
        before = bend
        told = variance[count] - curved / FREEDOM > COARSE * counting
        rest = stepping - PARABOLA * curved
        steps[count] = rest / (misfit - curved) if told else INDEPENDENT
        count += 1
    return count


@leaf
def without_strays(x: FloatArray, y: FloatArray, kept: IntArray) -> int:
    """Take returns far off neighbours which are near each other out of those `kept`.

    So far that it is no noise, whatever the noise is. Two rounds: strays may be neighbours. Returns
    how many are left.
    """
    count = kept.size
    for _ in range(2):
        if count < 3:
            break
        left = 1
        h, i = kept[0], kept[1]
        before = (x[i] - x[h]) ** 2 + (y[i] - y[h]) ** 2
        for m in range(2, count):
            j = kept[m]
            after = (x[i] - x[j]) ** 2 + (y[i] - y[j]) ** 2
            over = (x[j] - x[h]) ** 2 + (y[j] - y[h]) ** 2
            if min(before, after) > FAR * FAR * over:
                before = over
            else:
                kept[left] = i
                left += 1
                h = i
                before = after
            i = j
        kept[left] = i
        if left + 1 == count:
            break
        count = left + 1
    return count


@leaf
def scatter(points: Sequence, stretch: IntArray) -> tuple[float, float, float, float]:
    """Return the sums of squared range errors of a stretch about its line, ranges, steps; its bend.

    The bend is the errors' share in a parabola, as the root of a sum of squares with a sign.

    The first is -1 where the returns are in line with the sensor.
    """
    w = sx = sy = sxx = sxy = syy = 0.0
    for m in stretch:
        x = points.x[m]
        y = points.y[m]
        square = x * x + y * y
        w += square
        sx += square * x
        sy += square * y
        sxx += square * x * x
        sxy += square * x * y
        syy += square * y * y
    det = sxx * syy - sxy * sxy
    if det <= 1e-12 * sxx * syy:
        return -1.0, w, 0.0, 0.0
    a = (sx * syy - sy * sxy) / det
    b = (sy * sxx - sx * sxy) / det
    misfit = stepping = bend = before = 0.0
    for k in range(stretch.size):
        x = points.x[stretch[k]]
        y = points.y[stretch[k]]
        error = math.sqrt(x * x + y * y) * (1.0 - a * x - b * y)
        misfit += error * error
        bend += error * ((k - 3.5) ** 2 - 5.25)
        if k > 0:
            stepping += (error - before) ** 2
        before = error
    return misfit, w, stepping, bend / math.sqrt(168.0)


@leaf
def fit_noise(
    variance: FloatArray, square: FloatArray, count: FloatArray, begin: float, least: float
) -> tuple[float, float]:
    """Return sigma^2 and relative^2 of stretches' variances and mean squared ranges.

    `count` tells how many stretches each of these stands for; the search begins at `begin`, a low
    variance.
    """
    constant = max(begin / 0.6, least)
    growing = 0.0
    for _ in range(ROUNDS):
        n = r = rr = v = vr = 0.0
        for k in range(variance.size):
            expected = constant + growing * square[k]
            off = math.log(variance[k] / expected) / WIDTH
            if abs(off) < 1.0:
                weight = count[k] * ((1.0 - off * off) / expected) ** 2
                n += weight
                r += weight * square[k]
                rr += weight * square[k] * square[k]
                v += weight * variance[k]
                vr += weight * variance[k] * square[k]
        if n == 0.0:
            break
        constant = v / n
        growing = 0.0
        det = n * rr - r * r
        if det > 1e-9 * n * rr and vr * n > v * r:
            constant = max((v * rr - vr * r) / det, 0.0)
            growing = (vr * n - v * r) / det if constant > 0.0 else vr / rr
        constant = max(constant, least)
    return constant, growing
