"""What the emulated sensor measures, turn after turn."""

import math
from typing import Any, NamedTuple

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.drivers.rplidar.capsules import THETA
from laserfeatures.drivers.rplidar.nodes import DEGREE, FINE, TURN
from laserfeatures.drivers.rplidar.packets import Answer
from laserfeatures.drivers.rplidar.ultra import offsets
from laserfeatures.emulators.feed import Feed

TO_RADIANS = math.tau / TURN
WOBBLE = 0.003  # of the motor's speed from turn to turn, relative
THETAS = (1, 13)  # angle corrections [1/8 degree]: below 32, where all readers take them alike
GRID = DEGREE // 10  # directions looked at for an ultra scan
STEPS_TO_RAY = 4  # of the iteration that finds the range which turns a ray to itself


class Samples(NamedTuple):
    """Measurements in order.

    Attributes
    ----------
    times : (N,) array
        When each is made [s].
    raw, theta : (N,) int arrays
        The sensor's own angles, and what is taken from them [1/2048 degree].
    distances : (N,) array
        Distances [mm]; 0: no return.
    turns : (N,) int array
        Numbers of the turns.
    starts : (N,) bool array
        Which are the first of a turn.
    """

    times: FloatArray
    raw: IntArray
    theta: IntArray
    distances: FloatArray
    turns: IntArray
    starts: BoolArray

    def part(self, which: slice) -> "Samples":
        """Return some of them."""
        columns: list[Any] = [column[which] for column in self]
        return Samples(*columns)

    def with_more(self, more: "Samples") -> "Samples":
        """Return these and those after them."""
        columns: list[Any] = [np.concatenate(both) for both in zip(self, more, strict=True)]
        return Samples(*columns)


class Sampler:
    """Turns and measures.

    Parameters
    ----------
    feed : callable
        What it sees.
    answer : Answer
        The form in which it is sent, which says how angles are corrected.
    period : float
        Time from measurement to measurement [s].
    turn_time : float
        Time of a turn [s].
    begin : float
        When the first measurement is made [s]: anywhere in a turn.
    first_turn : int
        Number of the first turn.
    seed : int
        Seed of the irregularities.
    """

    def __init__(
        self,
        feed: Feed,
        answer: Answer,
        *,
        period: float,
        turn_time: float,
        begin: float,
        first_turn: int,
        seed: int,
    ) -> None:
        self._feed, self._answer, self._period = feed, answer, period
        self._rng = np.random.default_rng((seed, first_turn))
        self._turn_time = turn_time
        self._next = begin
        self._turn = first_turn
        self._turn_begin = begin - self._rng.uniform(0.05, 0.95) * turn_time
        none, no_float = np.empty(0, np.int64), np.empty(0)
        self._samples = Samples(no_float, none, none, no_float, none, np.empty(0, np.bool_))

    def ahead(self, count: int) -> Samples:
        """Return the next measurements without taking them."""
        while len(self._samples.times) < count:
            self._samples = self._samples.with_more(self._one_turn())
        return self._samples.part(slice(count))

    def take(self, count: int) -> None:
        """Leave the next measurements behind."""
        self._samples = self._samples.part(slice(count, None))

    def _one_turn(self) -> Samples:
        duration = self._turn_time * (1 + self._rng.uniform(-WOBBLE, WOBBLE))
        begin, end = self._turn_begin, self._turn_begin + duration
        times = np.arange(self._next, end, self._period)
        raw = ((times - begin) / duration * TURN).astype(np.int64)
        theta, distances = self._look(raw)
        starts = np.zeros(times.size, np.bool_)
        if begin >= self._next - self._period and times.size:
            starts[0] = True
        turns = np.full(times.size, self._turn)
        self._next = float(times[-1]) + self._period if times.size else self._next
        self._turn_begin = end
        self._turn += 1
        return Samples(times, raw, theta, distances, turns, starts)

    def _look(self, raw: IntArray) -> tuple[IntArray, FloatArray]:
        """Return the angle corrections and the distances in a turn."""
        if self._answer is Answer.ULTRA_CAPSULES:
            grid = np.arange(0, TURN, GRID)
            seen = self._millimetres(grid)
            theta = offsets(np.full(raw.size, 1000))
            for _ in range(STEPS_TO_RAY):
                distances = seen[np.rint((raw - theta) / GRID).astype(np.int64) % grid.size]
                theta = offsets(np.rint(distances).astype(np.int64))
            return theta, distances
        theta = np.zeros(raw.size, np.int64)
        if self._answer is not Answer.DENSE_CAPSULES:
            theta = self._rng.integers(*THETAS, raw.size) * THETA
        angles = raw - theta
        if self._answer is Answer.NODES:
            angles = angles // FINE * FINE
        return theta, self._millimetres(angles)

    def _millimetres(self, angles: IntArray) -> FloatArray:
        ahead = (angles + TURN // 2) % TURN - TURN // 2
        ranges = self._feed(np.multiply(-ahead, TO_RADIANS))
        seen: FloatArray = np.where(np.isfinite(ranges) & (ranges > 0), ranges * 1000, 0.0)
        return seen
