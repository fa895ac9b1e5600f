"""The accumulator of the paper's section II.A: one vote per point and theta, no raster."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan
from laserfeatures.engine import kernel

MAX_CELLS = 1 << 26


@dataclass(frozen=True, eq=False)
class Accumulator:
    """The d-theta plane of a scan.

    Parameters
    ----------
    votes : (T, D) int32 array
        Number of points whose line of direction theta has distance d.
    theta : (T,) array
        Direction of the lines' normal in each row [rad], in [0, pi).
    d : (D,) array
        Signed distance of the lines in each column [m], symmetric about 0.
    """

    votes: NDArray[np.int32]
    theta: FloatArray
    d: FloatArray


def check_steps(theta_step: float, distance_step: float) -> None:
    """Check the resolution of an accumulator.

    Raises
    ------
    ValueError
        If a step makes no sense.
    """
    if not 1e-4 <= theta_step <= math.pi / 8:
        raise ValueError(f"theta_step must be in [0.0001, pi/8] rad, got {theta_step!r}")
    if not 1e-4 <= distance_step <= 10:
        raise ValueError(f"distance_step must be in [0.0001, 10] m, got {distance_step!r}")


def theta_rows(theta_step: float) -> FloatArray:
    """Return the directions that divide half a turn into steps nearest to `theta_step` [rad]."""
    rows = round(math.pi / theta_step)
    return np.arange(rows, dtype=np.float64) * (math.pi / rows)


def accumulate(scan: LaserScan, theta_step: float, distance_step: float) -> Accumulator:
    """Return the Hough transform of a scan's points.

    Parameters
    ----------
    scan : LaserScan
    theta_step, distance_step : float
        Size of a cell [rad], [m].

    Raises
    ------
    ValueError
        If the accumulator would have more than 2**26 cells.
    """
    theta = theta_rows(theta_step)
    x, y = scan.points.T
    farthest = float(np.hypot(x, y).max(initial=0.0))
    columns = 2.0 * farthest / distance_step + 3.0  # as a float: it may be infinite
    if theta.size * columns > MAX_CELLS:
        raise ValueError(
            f"an accumulator of {theta.size} x {columns:.8g} cells is too large for returns at "
            f"{farthest:.6g} m: are the ranges metres? If so, take larger steps or limit range_max"
        )
    half = math.ceil(farthest / distance_step) + 1
    votes = np.zeros((theta.size, 2 * half + 1), np.int32)
    _cast_votes(x, y, np.cos(theta) / distance_step, np.sin(theta) / distance_step, votes)
    return Accumulator(votes, theta, distance_step * np.arange(-half, half + 1, dtype=np.float64))


@kernel
def _cast_votes(
    x: FloatArray, y: FloatArray, cos: FloatArray, sin: FloatArray, votes: NDArray[np.int32]
) -> None:
    """Add one vote per point and theta; cos and sin are in cells per metre."""
    middle = votes.shape[1] // 2 + 0.5  # the half rounds to the nearest cell
    for t in range(cos.size):
        for i in range(x.size):
            votes[t, int(x[i] * cos[t] + y[i] * sin[t] + middle)] += 1
