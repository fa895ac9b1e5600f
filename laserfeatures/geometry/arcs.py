"""Kernel that sets round objects (poles, table legs, people's legs) aside."""

import math

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper

POST = 0.1  # [m]; things that are seen no wider have no walls, whatever noise trails off them
FLAT = 0.01  # [m]; what departs more from a line is not flat
MAX_MISSED = 2  # beams without a return inside one object


@helper
def set_arcs_aside(
    x: FloatArray,
    y: FloatArray,
    beam: IntArray,
    sigma: float,
    jump: float,
    max_radius: float,
    label: int,
    owner: IntArray,
) -> None:
    """Label the points of isolated objects whose visible side is an arc convex to the sensor.

    An object is a stretch of the scan between two jumps of more than `jump` metres. It is an arc
    where a circle explains its points and a line does not.
    """
    first = 0
    for i in range(1, x.size + 1):
        if i < x.size:
            step = (x[i] - x[i - 1]) ** 2 + (y[i] - y[i - 1]) ** 2
            if step <= jump * jump and beam[i] - beam[i - 1] <= MAX_MISSED + 1:
                continue
        if i - first >= 4:
            size = extent(x[first:i], y[first:i])
            across = math.hypot(x[i - 1] - x[first], y[i - 1] - y[first])
            if (across < POST and size < 4.0 * POST) or (
                size < 2.5 * max_radius and is_arc(x[first:i], y[first:i], sigma, max_radius)
            ):
                for j in range(first, i):
                    owner[j] = label
        first = i


@helper
def extent(x: FloatArray, y: FloatArray) -> float:
    """Return the diagonal of the points' bounding box [m]."""
    left = right = x[0]
    low = high = y[0]
    for i in range(1, x.size):
        left = min(left, x[i])
        right = max(right, x[i])
        low = min(low, y[i])
        high = max(high, y[i])
    return math.sqrt((right - left) ** 2 + (high - low) ** 2)


@helper
def is_arc(x: FloatArray, y: FloatArray, sigma: float, max_radius: float) -> bool:
    """Tell whether points lie on a circle that bulges towards the sensor, and on no line.

    The circle is the algebraic least-squares fit (Kasa 1976).
    """
    n = x.size
    mx = my = 0.0
    for i in range(n):
        mx += x[i]
        my += y[i]
    mx /= n
    my /= n
    uu = uv = vv = uuu = uuv = uvv = vvv = 0.0
    for i in range(n):
        u = x[i] - mx
        v = y[i] - my
        uu += u * u
        uv += u * v
        vv += v * v
        uuu += u * u * u
        uuv += u * u * v
        uvv += u * v * v
        vvv += v * v * v
    off_line = 0.5 * (uu + vv - math.hypot(uu - vv, 2.0 * uv))
    det = uu * vv - uv * uv
    if off_line < (n - 2) * FLAT**2 or det <= 0.0:
        return False
    p = 0.5 * (uuu + uvv)
    q = 0.5 * (vvv + uuv)
    cu = (p * vv - q * uv) / det
    cv = (q * uu - p * uv) / det
    radius = math.sqrt(cu * cu + cv * cv + (uu + vv) / n)
    cx = cu + mx
    cy = cv + my
    if radius > max_radius or cx * cx + cy * cy < mx * mx + my * my:
        return False
    off_circle = 0.0
    for i in range(n):
        off_circle += (math.hypot(x[i] - cx, y[i] - cy) - radius) ** 2
    # At the scale of the flatness of things, and at that of the noise where it is larger.
    return off_circle < max(n - 3, 1) * FLAT**2 or (
        off_line > (n - 2) * (1.5 * sigma) ** 2 and off_circle < max(n - 3, 1) * (1.7 * sigma) ** 2
    )
