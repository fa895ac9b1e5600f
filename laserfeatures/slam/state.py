"""The state of the filter: a pose and landmarks, with their joint covariance."""

import math
from collections.abc import Callable

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.compiled import kernel
from laserfeatures.scan import Pose2D

POSE = 3  # numbers of a pose
EACH = 2  # numbers of a landmark
TILE = 32  # rows and columns that a processor's cache holds
ROOM = 64  # numbers that there is room for at first


class State:
    """Mean and covariance of the sensor's pose and of the landmarks, in the frame of the map.

    Parameters
    ----------
    pose : Pose2D
        Where the sensor is; certain, as it makes the frame of the map.

    Attributes
    ----------
    landmarks : int
        How many landmarks there are.
    """

    def __init__(self, pose: Pose2D) -> None:
        self.landmarks = 0
        self._mean = np.zeros(ROOM)
        self._covariance = np.zeros((ROOM, ROOM))
        self._mean[:POSE] = pose.x, pose.y, pose.theta

    @property
    def size(self) -> int:
        """How many numbers the state has."""
        return POSE + EACH * self.landmarks

    @property
    def mean(self) -> FloatArray:
        """The mean (n,): x, y, theta, then two numbers a landmark; a view."""
        return self._mean[: self.size]

    @property
    def covariance(self) -> FloatArray:
        """The covariance (n, n); a view."""
        return self._covariance[: self.size, : self.size]

    @property
    def pose(self) -> Pose2D:
        """The pose."""
        x, y, theta = self._mean[:POSE].tolist()
        return Pose2D(x, y, theta)

    @property
    def positions(self) -> FloatArray:
        """The two numbers of each landmark (L, 2); a view."""
        return self.mean[POSE:].reshape(-1, EACH)

    def blocks(self) -> FloatArray:
        """Return each landmark's own covariance, (L, 2, 2)."""
        first = POSE + EACH * np.arange(self.landmarks)
        index = first[:, None] + np.arange(EACH)
        return self._covariance[index[:, :, None], index[:, None, :]]

    def move(self, step: Pose2D, covariance: FloatArray) -> None:
        """Move the pose by a step in its own frame; covariance (3, 3) of the step.

        Costs time in proportion to the number of landmarks.
        """
        n = self.size
        theta = self._mean[2]
        c, s = math.cos(theta), math.sin(theta)
        way = np.array([c * step.x - s * step.y, s * step.x + c * step.y])
        by_pose = np.array([[1, 0, -way[1]], [0, 1, way[0]], [0, 0, 1]])
        by_step = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        self._mean[:2] += way
        self._mean[2] = math.remainder(theta + step.theta, math.tau)
        p = self._covariance
        own = by_pose @ p[:POSE, :POSE] @ by_pose.T + by_step @ covariance @ by_step.T
        p[:POSE, :POSE] = (own + own.T) / 2
        p[:POSE, POSE:n] = by_pose @ p[:POSE, POSE:n]
        p[POSE:n, :POSE] = p[:POSE, POSE:n].T

    def correct(
        self,
        places: IntArray,
        jacobian: FloatArray,
        innovation: FloatArray,
        noise: FloatArray,
        carried_over: Callable[[FloatArray, FloatArray], FloatArray],
    ) -> float:
        """Take in a measurement of some of the numbers, in Joseph's form.

        Costs time in proportion to the square of the number of landmarks.

        Parameters
        ----------
        places : (k,) int array
            Which numbers of the state are measured.
        jacobian : (m, k) array
            Of the measurement by them.
        innovation : (m,) array
            What was measured, less what was expected.
        noise : (m, m) array
            Covariance of the measurement.
        carried_over : callable
            From the mean (n,) before and after to (n, 3); see `laserfeatures.slam.invariance`.

        Returns
        -------
        float
            The normalised innovation squared.

        Notes
        -----
        (I - K H) P (I - K H)' + K R K' is P - K A' + (K S - A) K' with A = P H' and S = H A + R.
        """
        p = self.covariance
        across = p[:, places] @ jacobian.T
        expected = jacobian @ across[places] + noise
        gain = np.linalg.solve(expected, across.T).T
        before = self.mean.copy()
        self.mean[:] += gain @ innovation
        self._mean[2] = math.remainder(self._mean[2], math.tau)
        change = carried_over(before, self.mean)
        left = np.hstack([-gain, gain @ expected - across])
        right = np.hstack([across, gain])
        pose = p[:POSE] + left[:POSE] @ right.T  # the pose's rows, when corrected
        both = pose.T + change @ pose[:, :POSE]
        right = np.ascontiguousarray(np.hstack([right, pose.T, change]).T)
        _add_product(self._covariance, self.size, np.hstack([left, change, both]), right)
        return float(innovation @ np.linalg.solve(expected, innovation))

    def add(self, value: FloatArray, by_pose: FloatArray, noise: FloatArray) -> None:
        """Add a landmark.

        Parameters
        ----------
        value : (2,) array
            Its numbers.
        by_pose : (2, 3) array
            How they depend on the pose.
        noise : (2, 2) array
            Their covariance, were the pose certain.
        """
        n = self.size
        if n + EACH > self._mean.size:
            self._grow()
        p = self._covariance
        across = by_pose @ p[:POSE, :n]
        p[n : n + EACH, :n] = across
        p[:n, n : n + EACH] = across.T
        own = by_pose @ p[:POSE, :POSE] @ by_pose.T + noise
        p[n : n + EACH, n : n + EACH] = (own + own.T) / 2
        self._mean[n : n + EACH] = value
        self.landmarks += 1

    def keep(self, which: BoolArray) -> None:
        """Keep those landmarks (L,) bool, and forget the others."""
        places = np.flatnonzero(np.concatenate([np.ones(POSE, bool), np.repeat(which, EACH)]))
        mean, covariance = self.mean[places], self.covariance[np.ix_(places, places)]
        self.landmarks = int(which.sum())
        self.mean[:] = mean
        self.covariance[:] = covariance

    def _grow(self) -> None:
        mean, covariance = self.mean.copy(), self.covariance.copy()
        room = 2 * self._mean.size
        self._mean, self._covariance = np.zeros(room), np.zeros((room, room))
        self.mean[:] = mean
        self.covariance[:] = covariance


@kernel
def _add_product(matrix: FloatArray, n: int, left: FloatArray, right: FloatArray) -> None:
    """Add a product that is symmetric to the first n rows and columns of a symmetric matrix.

    One half, then its mirror. The library's product of matrices would do it all, in threads that
    wait for each other where the machine has other work.
    """
    count = left.shape[1]
    for i in range(n):
        row = matrix[i, : i + 1]
        for k in range(0, count - 3, 4):  # a row is read and written once for four
            a, b, c, d = left[i, k], left[i, k + 1], left[i, k + 2], left[i, k + 3]
            for j in range(i + 1):
                row[j] += (a * right[k, j] + b * right[k + 1, j]) + (
                    c * right[k + 2, j] + d * right[k + 3, j]
                )
        for k in range(count - count % 4, count):
            for j in range(i + 1):
                row[j] += left[i, k] * right[k, j]
    for top in range(0, n, TILE):  # tile by tile: memory is what takes the time
        for first in range(0, top + 1, TILE):
            for i in range(top, min(top + TILE, n)):
                for j in range(first, min(first + TILE, i)):
                    matrix[j, i] = matrix[i, j]
