"""What a sensor sees in a turn, as the numbers that it sends."""

import numpy as np

from laserfeatures.arrays import IntArray
from laserfeatures.drivers.urg.commands import Measurement
from laserfeatures.drivers.urg.sensor import LARGEST_SHORT, Geometry
from laserfeatures.emulators.feed import Feed

NO_RETURNS = np.array([0, 6, 7])  # too far or too weak, other, at odds with the neighbours
SHARES = np.array([0.6, 0.3, 0.1])  # about as in scans of rooms
NOT_MEASURED = 19


class View:
    """Turns what a feed shows into a sensor's numbers.

    Parameters
    ----------
    geometry : Geometry
        Of the sensor.
    feed : callable
        What it sees.
    seed : int
        Seed of the error codes that no-returns get.
    """

    def __init__(self, geometry: Geometry, feed: Feed, seed: int) -> None:
        self._geometry = geometry
        self._feed = feed
        self._angles = geometry.angle(np.arange(geometry.first, geometry.last + 1))
        self._angles.flags.writeable = False
        self._rng = np.random.default_rng(seed)
        self.turns = 0

    def look(self) -> IntArray:
        """Return what every measured step sees in the next turn (N,) [mm], or an error code."""
        self.turns += 1
        millimetres = np.rint(1000 * self._feed(self._angles))
        seen = millimetres >= self._geometry.shortest
        seen &= millimetres <= self._geometry.longest
        codes = self._rng.choice(NO_RETURNS, self._angles.size, p=SHARES)
        return np.where(seen, np.where(seen, millimetres, 0).astype(np.int64), codes)

    def values(self, turn: IntArray, measurement: Measurement) -> IntArray:
        """Return the values (N,) that a command wants of a turn.

        Of steps in a cluster the shortest range counts; outside the measured steps nothing is.
        """
        geometry = self._geometry
        size = measurement.values * measurement.width
        steps = measurement.first + np.arange(size)
        inside = (steps >= geometry.first) & (steps <= min(geometry.last, measurement.last))
        values = np.full(size, NOT_MEASURED)
        values[inside] = turn[steps[inside] - geometry.first]
        if measurement.characters == 2:
            values = np.minimum(values, LARGEST_SHORT)
        clusters = values.reshape(-1, measurement.width)
        ranges = np.where(clusters < geometry.shortest, np.iinfo(np.int64).max, clusters)
        shortest = ranges.argmin(axis=1)  # the first one of none but errors
        chosen: IntArray = clusters[np.arange(len(clusters)), shortest]
        return chosen
