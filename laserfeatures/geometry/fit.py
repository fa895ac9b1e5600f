"""The fit of a line to points.

A fit is a tuple (theta, d, var_theta, cov_theta_d, var_d), the last three for a unit noise.
"""

import math

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper, kernel

Fit = tuple[float, float, float, float, float]

# A range error moves a point along its beam, so its distance from a line errs by cos(incidence).
# Other errors (beam width and angle, roughness) do not vanish at grazing incidence: this adds them
# as a share of the range variance.
INCIDENCE_FLOOR = 0.02


@kernel
def fit_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float) -> Fit:
    """Fit a line to the points `members` by weighted total least squares.

    The weights are the inverse variances of the points' distances from the line for a range noise
    of 1 m at the incidence angles that `theta`, a first guess, implies; the line is the minor axis
    of the weighted scatter. The covariance follows to first order; it is for that noise too, so
    that a noise sigma multiplies it by sigma squared.
    """
    c = math.cos(theta)
    s = math.sin(theta)
    w = wx = wy = wxx = wxy = wyy = 0.0
    for i in members:
        along = x[i] * c + y[i] * s
        weight = 1.0 / (along * along / (x[i] * x[i] + y[i] * y[i]) + INCIDENCE_FLOOR)
        w += weight
        wx += weight * x[i]
        wy += weight * y[i]
        wxx += weight * x[i] * x[i]
        wxy += weight * x[i] * y[i]
        wyy += weight * y[i] * y[i]
    mx = wx / w
    my = wy / w
    sxx = wxx - wx * mx
    sxy = wxy - wx * my
    syy = wyy - wy * my
    theta = 0.5 * math.atan2(-2.0 * sxy, syy - sxx)
    if theta < 0.0:
        theta += math.pi
    if theta >= math.pi:
        theta = 0.0
    c = math.cos(theta)
    s = math.sin(theta)
    centre = my * c - mx * s
    spread = max(sxx * s * s - 2.0 * sxy * s * c + syy * c * c, 1e-12)
    var_theta = 1.0 / spread
    return theta, mx * c + my * s, var_theta, centre * var_theta, 1.0 / w + centre**2 * var_theta


@helper
def direction(sxx: float, sxy: float, syy: float) -> tuple[float, float, float]:
    """Return the unit vector of the major axis of a scatter matrix, and the scatter along it."""
    half = 0.5 * (sxx - syy)
    length = math.sqrt(half * half + sxy * sxy)
    spread = max(0.5 * (sxx + syy) + length, 1e-12)
    if length == 0.0:
        return 1.0, 0.0, spread
    cosine = half / length  # of twice the axis's angle
    if cosine > 0.0:
        ux = math.sqrt(0.5 * (1.0 + cosine))
        return ux, 0.5 * sxy / (length * ux), spread
    uy = math.sqrt(0.5 * (1.0 - cosine))
    return 0.5 * sxy / (length * uy), uy, spread


@helper
def line_of_sums(
    x: float, y: float, n: int, sx: float, sy: float, sxx: float, sxy: float, syy: float
) -> Fit:
    """Return the unweighted fit to n points whose sums were taken relative to (x, y)."""
    mx = sx / n
    my = sy / n
    ux, uy, spread = direction(sxx - sx * mx, sxy - sx * my, syy - sy * my)
    theta = math.atan2(-ux, uy)
    if theta < 0.0:
        theta += math.pi
        ux, uy = -ux, -uy
    if theta >= math.pi:
        theta = 0.0
        ux, uy = 0.0, 1.0
    x += mx
    y += my
    centre = x * ux + y * uy
    variance = 1.0 / spread
    return theta, x * uy - y * ux, variance, centre * variance, 1.0 / n + centre**2 * variance


@helper
def fit_unweighted(x: FloatArray, y: FloatArray, members: IntArray) -> Fit:
    """Fit a line to the points `members` by total least squares, without weights: in a hurry."""
    first = members[0]
    sx = sy = sxx = sxy = syy = 0.0
    for i in members:
        dx = x[i] - x[first]
        dy = y[i] - y[first]
        sx += dx
        sy += dy
        sxx += dx * dx
        sxy += dx * dy
        syy += dy * dy
    return line_of_sums(x[first], y[first], members.size, sx, sy, sxx, sxy, syy)


@helper
def off_line(x: FloatArray, y: FloatArray, members: IntArray, theta: float, d: float) -> float:
    """Return the root mean square distance of `members` from a line [m]."""
    c = math.cos(theta)
    s = math.sin(theta)
    total = 0.0
    for i in members:
        total += (x[i] * c + y[i] * s - d) ** 2
    return math.sqrt(total / members.size)
