"""Kernel that sets round objects (poles, table legs, people's legs) aside."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper

POST = 0.1  # [m]; things that are seen no wider have no walls, whatever noise trails off them
SMALL = 0.3  # [m]; what stands alone and is seen no wider is rather round than flat
EVIDENCE = 1.5  # standard deviations by which a circle explains it better than a line
FLAT = 0.01  # [m]; what departs more from a line is not flat
MAX_MISSED = 2  # beams without a return inside one object
MAX_STRAY = 1  # beams that jump out of a round object: more are among false beams, at a wall


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

    An object is a stretch of the scan between two jumps of more than `jump` metres; beams that jump
    out of it and back are not part of it. It is an arc where a circle explains its points and a
    line does not.
    """
    members = np.empty(x.size, np.int64)
    count = 0
    i = 0
    while i < x.size:
        members[count] = i
        count += 1
        after = next_of_object(x, y, beam, i, jump)
        if after == 0:
            if count >= 4 and i - members[0] - count < MAX_STRAY:
                first = members[0]
                if i - first < count:  # nothing left out: no copies
                    found = is_round(x[first : i + 1], y[first : i + 1], sigma, max_radius)
                else:
                    mine = members[:count]
                    found = is_round(x[mine], y[mine], sigma, max_radius)
                if found:
                    for j in members[:count]:
                        owner[j] = label
            count = 0
            after = i + 1
        i = after


@helper
def next_of_object(x: FloatArray, y: FloatArray, beam: IntArray, i: int, jump: float) -> int:
    """Return the next point of the object that point i is on, or 0 if there is none."""
    j = i + 1
    while j < x.size and beam[j] - beam[i] <= MAX_MISSED + 1:
        if (x[j] - x[i]) ** 2 + (y[j] - y[i]) ** 2 <= jump * jump:
            return j
        j += 1
    return 0


@helper
def is_round(x: FloatArray, y: FloatArray, sigma: float, max_radius: float) -> bool:
    """Tell whether an object's points are a post's, or lie on an arc."""
    size = extent(x, y)
    across = math.hypot(x[-1] - x[0], y[-1] - y[0])
    return (across < POST and size < 4.0 * POST) or (
        size < 2.5 * max_radius and is_arc(x, y, size, sigma, max_radius)
    )


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
def is_arc(x: FloatArray, y: FloatArray, size: float, sigma: float, max_radius: float) -> bool:
    """Tell whether points lie on a circle that bulges towards the sensor, and on no line.

    `size` is their extent [m]: for a small object, that the circle explains them better will do.
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
    flat = off_line < (n - 2) * FLAT**2
    det = uu * vv - uv * uv
    if det <= 0.0 or (flat and size > SMALL):
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
    if size < SMALL and off_line - off_circle > (EVIDENCE * sigma) ** 2:
        return off_circle < max(n - 3, 1) * max(FLAT, 1.7 * sigma) ** 2
    if flat:
        return False
    # At the scale of the flatness of things, and at that of the noise where it is larger.
    return off_circle < max(n - 3, 1) * FLAT**2 or (
        off_line > (n - 2) * (1.5 * sigma) ** 2 and off_circle < max(n - 3, 1) * (1.7 * sigma) ** 2
    )
