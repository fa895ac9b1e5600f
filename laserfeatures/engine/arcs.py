"""Round objects: poles, legs of tables and people, columns, tanks."""

import math

from laserfeatures.compiled import leaf
from laserfeatures.engine.prices import ARC_PRICE, PRICE, STRAY_PRICE
from laserfeatures.engine.sequence import Sequence
from laserfeatures.engine.sums import line_of

SHORTEST_ARC = 4  # returns
CONVEX = 0.5  # [rad] of a circle that must be seen of it from outside,
CONCAVE = 2.0  # and from inside: a corner of two walls bends less
MANY = 16  # returns: of fewer, noise may hide the circle
EDGE = 8  # a part so small is left out at either end: the ends of a round room meet
OUT_OF_ROUND = 0.2  # of the radius, that two of five returns may be off the circle of the others,
NOISES = 6.0  # and standard deviations besides
HOPELESS = 36.0  # chi squared of a return on the first fit: no better one makes it an arc
CIRCLE_FITS = 8
SETTLED = 1e-3  # of the radius: a step that changes no decision


@leaf
def arc_misfit(points: Sequence, i: int, j: int, max_radius: float, least: float) -> float:
    """Return chi squared of the circle through returns i..j-1, inf where that is no round object.

    The circle is the nearest one, begun at the algebraic fit of Kasa (1976), which is too small
    where little is seen of it. Objects that bulge towards the sensor are round up to `max_radius`
    [m], where `least` [rad] are seen of them; rooms may be round at any.
    """
    if j - i >= MANY and not goes_round(points, i, j):
        return math.inf
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
    cx = cu + mx
    cy = cv + my
    misfit = circle_misfit(points, i, j, cx, cy, radius, max_radius, least)
    if misfit > HOPELESS * (j - i):
        return misfit
    cx, cy, radius = nearest_circle(points, i, j, cx, cy, radius)
    return min(misfit, circle_misfit(points, i, j, cx, cy, radius, max_radius, least))


@leaf
def goes_round(points: Sequence, i: int, j: int) -> bool:
    """Tell whether five returns lie near one circle, those in between by the other three."""
    m = (i + j - 1) // 2
    first = i + (j - i) // EDGE
    last = j - 1 - (j - i) // EDGE
    ax = points.x[first] - points.x[m]
    ay = points.y[first] - points.y[m]
    bx = points.x[last] - points.x[m]
    by = points.y[last] - points.y[m]
    twice = 2.0 * (ax * by - ay * bx)
    if twice == 0.0:
        return False
    cx = (by * (ax * ax + ay * ay) - ay * (bx * bx + by * by)) / twice
    cy = (ax * (bx * bx + by * by) - bx * (ax * ax + ay * ay)) / twice
    radius = math.sqrt(cx * cx + cy * cy)
    slack = OUT_OF_ROUND * radius + NOISES * math.sqrt(points.variance[m])
    for q in ((first + m) // 2, (m + last) // 2):
        off = math.hypot(points.x[q] - points.x[m] - cx, points.y[q] - points.y[m] - cy)
        if abs(off - radius) > slack:
            return False
    return True


@leaf
def circle_misfit(
    points: Sequence,
    i: int,
    j: int,
    cx: float,
    cy: float,
    radius: float,
    max_radius: float,
    least: float,
) -> float:
    """Return chi squared of a circle through returns i..j-1, inf where they are no arc of it."""
    if not bends(points, i, j, cx, cy, radius, max_radius, least):
        return math.inf
    # Beside the edges noise moves returns along the arc: the incidence taken is that of all.
    chi2 = incidence = 0.0
    for m in range(i, j):
        dx = points.x[m] - cx
        dy = points.y[m] - cy
        cosine = (points.ux[m] * dx + points.uy[m] * dy) / radius
        incidence += cosine * cosine + points.floor[m]
        chi2 += (math.sqrt(dx * dx + dy * dy) - radius) ** 2 / points.variance[m]
    return chi2 * (j - i) / incidence


@leaf
def nearest_circle(
    points: Sequence, i: int, j: int, cx: float, cy: float, radius: float
) -> tuple[float, float, float]:
    """Return the centre and radius of the circle nearest to returns i..j-1, begun at another.

    Gauss-Newton on the distances; the radius that belongs to a centre is their mean.
    """
    for _ in range(CIRCLE_FITS):
        w = mx = my = 0.0
        xx = xy = yy = ex = ey = mean = 0.0
        for m in range(i, j):
            dx = cx - points.x[m]
            dy = cy - points.y[m]
            distance = max(math.sqrt(dx * dx + dy * dy), 1e-9 * radius)
            dx /= distance
            dy /= distance
            weight = 1.0 / points.variance[m]
            w += weight
            mx += weight * dx
            my += weight * dy
            mean += weight * distance
            xx += weight * dx * dx
            xy += weight * dx * dy
            yy += weight * dy * dy
            ex += weight * distance * dx
            ey += weight * distance * dy
        xx -= mx * mx / w
        xy -= mx * my / w
        yy -= my * my / w
        ex -= mean * mx / w
        ey -= mean * my / w
        det = xx * yy - xy * xy
        radius = mean / w
        if det <= 1e-12 * xx * yy:
            break
        step_x = (ex * yy - ey * xy) / det
        step_y = (ey * xx - ex * xy) / det
        cx -= step_x
        cy -= step_y
        radius -= (mx * step_x + my * step_y) / w
        if step_x * step_x + step_y * step_y < (SETTLED * radius) ** 2:
            break
    return cx, cy, radius


@leaf
def bends(
    points: Sequence,
    i: int,
    j: int,
    cx: float,
    cy: float,
    radius: float,
    max_radius: float,
    least: float,
) -> bool:
    """Tell whether returns i..j-1 go round enough of a circle to be an arc of it."""
    m = (i + j - 1) // 2
    turn = angle(points, i, m, cx, cy) + angle(points, m, j - 1, cx, cy)
    if cx * cx + cy * cy > points.x[m] ** 2 + points.y[m] ** 2:
        return bool(turn > least and radius <= max_radius)
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
    return bool(
        arc_misfit(points, i, j, max_radius, CONVEX) + ARC_PRICE < min(flat, (j - i) * STRAY_PRICE)
    )


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
