"""Round objects: poles, legs of tables and people, columns, tanks."""

import math

from laserfeatures.compiled import leaf
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.sums import line_of

SHORTEST_ARC = 4  # returns
CONVEX = 0.5  # [rad] of a circle that must be seen of it from outside,
CONCAVE = 2.0  # and from inside: a corner of two walls bends less


@leaf
def arc_misfit(points: Sequence, i: int, j: int, max_radius: float) -> float:
    """Return chi squared of the circle through returns i..j-1, inf where that is no round object.

    The circle is the algebraic least-squares fit (Kasa 1976). Objects that bulge towards the sensor
    are round up to `max_radius` [m]; rooms may be round at any.
    """
    w = mx = my = 0.0
    for m in range(i, j):
        weight = 1.0 / points.variance[m]
        w += weight
        mx += weight * points.x[m]
        my += weight * points.y[m]
    mx /= w
    my /= w
    uu = uv = vv = uuu = uuv = uvv = vvv = 0.0
    for m in range(i, j):
        weight = 1.0 / points.variance[m]
        u = points.x[m] - mx
        v = points.y[m] - my
        uu += weight * u * u
        uv += weight * u * v
        vv += weight * v * v
        uuu += weight * u * u * u
        uuv += weight * u * u * v
        uvv += weight * u * v * v
        vvv += weight * v * v * v
    det = uu * vv - uv * uv
    if det <= 1e-12 * uu * vv:
        return math.inf
    p = 0.5 * (uuu + uvv)
    q = 0.5 * (vvv + uuv)
    cu = (p * vv - q * uv) / det
    cv = (q * uu - p * uv) / det
    radius = math.sqrt(cu * cu + cv * cv + (uu + vv) / w)
    if not bends(points, i, j, cu + mx, cv + my, radius, max_radius):
        return math.inf
    # Beside the edges noise moves returns along the arc: the incidence taken is that of all.
    chi2 = incidence = 0.0
    for m in range(i, j):
        dx = points.x[m] - mx - cu
        dy = points.y[m] - my - cv
        cosine = (points.ux[m] * dx + points.uy[m] * dy) / radius
        incidence += cosine * cosine + points.floor[m]
        chi2 += (math.sqrt(dx * dx + dy * dy) - radius) ** 2 / points.variance[m]
    return chi2 * (j - i) / incidence


@leaf
def bends(
    points: Sequence, i: int, j: int, cx: float, cy: float, radius: float, max_radius: float
) -> bool:
    """Tell whether returns i..j-1 go round enough of a circle to be an arc of it."""
    m = (i + j - 1) // 2
    turn = angle(points, i, m, cx, cy) + angle(points, m, j - 1, cx, cy)
    if cx * cx + cy * cy > points.x[m] ** 2 + points.y[m] ** 2:
        return bool(turn > CONVEX and radius <= max_radius)
    return bool(turn > CONCAVE)


@leaf
def angle(points: Sequence, i: int, j: int, cx: float, cy: float) -> float:
    """Return the angle between two returns as a centre sees them."""
    ax = points.x[i] - cx
    ay = points.y[i] - cy
    bx = points.x[j] - cx
    by = points.y[j] - cy
    return abs(math.atan2(ax * by - ay * bx, ax * bx + ay * by))


@leaf
def is_round(points: Sequence, i: int, j: int, max_radius: float) -> bool:
    """Tell whether the object of returns i..j-1 is rather round than one wall, or two that meet."""
    if j - i < SHORTEST_ARC:
        return False
    corner = i
    farthest = 0.0
    ux = points.x[j - 1] - points.x[i]
    uy = points.y[j - 1] - points.y[i]
    for m in range(i, j):
        off = abs((points.x[m] - points.x[i]) * uy - (points.y[m] - points.y[i]) * ux)
        if off > farthest:
            farthest = off
            corner = m
    flat = min(
        PRICE + flat_misfit(points, i, j),
        2.0 * PRICE + flat_misfit(points, i, corner) + flat_misfit(points, corner, j),
    )
    return bool(arc_misfit(points, i, j, max_radius) + ARC_PRICE < min(flat, (j - i) * STRAY_PRICE))


@leaf
def flat_misfit(points: Sequence, i: int, j: int) -> float:
    """Return chi squared of the best line through returns i..j-1; 0 for less than three."""
    if j - i < 3:
        return 0.0
    w = sx = sy = sxx = sxy = syy = 0.0
    for m in range(i, j):
        weight = points.weight[m]
        w += weight
        sx += weight * points.x[m]
        sy += weight * points.y[m]
        sxx += weight * points.x[m] * points.x[m]
        sxy += weight * points.x[m] * points.y[m]
        syy += weight * points.y[m] * points.y[m]
    return line_of(w, sx, sy, sxx, sxy, syy)[3]
