"""What the gradients around a corner tell of it: how well its place is known, and its angle."""

import numpy as np

from laserfeatures.arrays import FloatArray

# What a corner's place errs by besides the noise: in pixels, and as a share of the way from return
# to return. Set so that the ellipses hold what they say in simulated rooms (tests).
PIXEL_ERROR = 0.2
SAMPLING_ERROR = 0.08


def covariances(
    tensor: FloatArray, points: FloatArray, window: float, resolution: float, noise: float
) -> FloatArray:
    """Return the covariance of each corner's place [m^2], (F, 2, 2).

    Parameters
    ----------
    tensor : (F, 2, 2) array
        Structure tensor around each corner, in any unit.
    points : (F,) array
        Number of returns in its window.
    window, resolution, noise : float
        Radius of the window, side of a pixel and standard deviation of a range [m].

    Notes
    -----
    The least-squares crossing of the edges in a window has the inverse of the structure tensor as
    its covariance, up to the variance of an edge's place (Foerstner and Guelch 1987). Here that is
    of the mean of the returns in the window, of the pixels, and of the corner that the lines from
    return to return cut off. The tensor is taken with trace 1: as if all were on one edge.
    """
    a, b, c = tensor[:, 0, 0], tensor[:, 0, 1], tensor[:, 1, 1]
    adjugate = np.stack([c, -b, -b, a], axis=1).reshape(-1, 2, 2)
    returns = np.maximum(points, 1.0)
    variance = (
        noise**2 / returns
        + (PIXEL_ERROR * resolution) ** 2
        + (SAMPLING_ERROR * 2.0 * window / returns) ** 2
    )
    scale = variance * (a + c) / (a * c - b * b)
    covariance: FloatArray = adjugate * scale[:, None, None]
    return covariance


def edge_angles(tensor: FloatArray) -> FloatArray:
    """Return the angle between two equally strong edges that have each tensor [rad], (F,).

    Their gradients' squares add up to eigenvalues whose ratio is tan(angle / 2)^2.
    """
    least, most = np.linalg.eigvalsh(tensor).T
    angle: FloatArray = 2.0 * np.arctan(np.sqrt(np.maximum(least, 0.0) / most))
    return angle
