"""Kernels that look at an image around a point: which lines leave it, and its gradients."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.engine import helper, kernel
from laserfeatures_plugins.raster.drawing import Image

RING = 6.0  # radius [pixels] of the ring on which the lines that leave a point are counted
SAMPLES = 64  # on the ring
LINE = 0.4  # what is at least so bright, as a share of the middle of a line, is a line
WINDOW = 9  # pixels around a corner that tell its place


@kernel
def turns(image: Image, u: FloatArray, v: FloatArray, ridge: float) -> FloatArray:
    """Return by how much a line turns at each point [rad], or -1 where fewer than two leave it.

    That is pi less the angle between the two lines that leave the point, or of more, the angle that
    is nearest to a right one. `ridge` is the brightness of the middle of a line.
    """
    turn = np.empty(u.size)
    ring = np.empty(SAMPLES)
    for k in range(u.size):
        for a in range(SAMPLES):
            phi = a * 2.0 * math.pi / SAMPLES
            ring[a] = brightness(image, u[k] + RING * math.cos(phi), v[k] + RING * math.sin(phi))
        turn[k] = turn_of(ring, LINE * ridge)
    return turn


@helper
def brightness(image: Image, u: float, v: float) -> float:
    """Return the brightness at a point between pixels; 0 outside the image."""
    column = math.floor(u)
    row = math.floor(v)
    if not (0 <= column < image.shape[1] - 1 and 0 <= row < image.shape[0] - 1):
        return 0.0
    a = u - column
    b = v - row
    upper = (1.0 - a) * image[row, column] + a * image[row, column + 1]
    lower = (1.0 - a) * image[row + 1, column] + a * image[row + 1, column + 1]
    return float((1.0 - b) * upper + b * lower)


@helper
def turn_of(ring: FloatArray, least: float) -> float:
    """Return pi less the angle nearest to a right one between maxima of a ring, -1 if below two.

    A maximum is at least `least`, and lies between samples where a parabola has its top.
    """
    n = ring.size
    tops = np.empty(n)
    count = 0
    best = -1.0
    for k in range(n):
        before = ring[k - 1]
        after = ring[(k + 1) % n]
        if ring[k] < least or ring[k] < before or ring[k] <= after:
            continue
        bend = before - 2.0 * ring[k] + after
        tops[count] = (k + 0.5 * (before - after) / bend) * 2.0 * math.pi / n
        for other in range(count):
            between = abs(tops[count] - tops[other])
            turn = math.pi - min(between, 2.0 * math.pi - between)
            if abs(turn - 0.5 * math.pi) < abs(best - 0.5 * math.pi):
                best = turn
        count += 1
    return best


@kernel
def structure(image: Image, u: FloatArray, v: FloatArray) -> FloatArray:
    """Return the structure tensor at each point, (K, 2, 2): the sum of g g^T around it.

    The gradients g are weighted by the Gaussian by which `cv2.cornerSubPix` weighs them.
    """
    tensor = np.zeros((u.size, 2, 2))
    for k in range(u.size):
        column = round(u[k])
        row = round(v[k])
        for y in range(max(row - WINDOW, 1), min(row + WINDOW + 1, image.shape[0] - 1)):
            for x in range(max(column - WINDOW, 1), min(column + WINDOW + 1, image.shape[1] - 1)):
                away = (x - u[k]) ** 2 + (y - v[k]) ** 2
                weight = math.exp(-away / WINDOW**2)
                gx = 0.5 * (float(image[y, x + 1]) - float(image[y, x - 1]))
                gy = 0.5 * (float(image[y + 1, x]) - float(image[y - 1, x]))
                tensor[k, 0, 0] += weight * gx * gx
                tensor[k, 0, 1] += weight * gx * gy
                tensor[k, 1, 1] += weight * gy * gy
        tensor[k, 1, 0] = tensor[k, 0, 1]
    return tensor


@kernel
def distinct(x: FloatArray, y: FloatArray, reach: FloatArray) -> BoolArray:
    """Return which points to keep, those that no kept one before is nearer to than their reach."""
    keep = np.ones(x.size, np.bool_)
    for k in range(x.size):
        for other in range(k):
            if keep[other] and (x[k] - x[other]) ** 2 + (y[k] - y[other]) ** 2 < reach[k] ** 2:
                keep[k] = False
    return keep
