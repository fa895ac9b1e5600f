"""From a sensor's clock, 24 bits of milliseconds, to the host's."""

import math
import statistics
from collections import deque

WRAP = 1 << 24  # [ms]
HALF_TICK = 0.5e-3  # [s]; a clock that shows whole milliseconds is late by this in the mean
WINDOW = 10.0  # [s]; of so many seconds' scans the one that came earliest counts
LARGEST_DRIFT = 1e-3  # beyond this it is the host that is slow
SAMPLES = 64


class Clock:
    """A sensor's clock.

    The offset between both clocks is the median of what several TM1 tell. Then scans show how
    both drift apart: the earliest arrival among those of some seconds comes a fixed while after
    its stamp, so what changes in it is drift, and the offset slowly follows.
    """

    def __init__(self) -> None:
        self._asked = math.nan
        self._offsets: deque[float] = deque(maxlen=SAMPLES)
        self._offset = math.nan  # [s]
        self._since = math.nan  # when the window began [s]
        self._earliest = math.inf  # delay in the window [s]
        self._delay = math.nan  # that of the first window [s]

    def forget(self) -> None:
        """Begin anew: the offset is to be measured."""
        self._offsets.clear()
        self._offset = math.nan
        self._begin_windows()

    def ask(self, time: float) -> None:
        """Take note that the clock was asked at `time` [s]."""
        self._asked = time

    def answer(self, milliseconds: int, time: float) -> None:
        """Take the answer, which came at `time` [s]."""
        if math.isnan(self._asked):
            return
        middle = (self._asked + time) / 2
        sensor = milliseconds / 1000 + HALF_TICK
        if self._offsets:  # bring a clock that has just wrapped to the samples before
            turns = round((middle - sensor - self._offsets[0]) * 1000 / WRAP)
            sensor += turns * WRAP / 1000
        self._offsets.append(middle - sensor)
        self._offset = statistics.median(self._offsets)
        self._asked = math.nan
        self._begin_windows()

    def guess(self, milliseconds: int, time: float) -> None:
        """Set the offset from a moment that is known by no better means, if it is unknown."""
        if math.isnan(self._offset):
            self._offset = time - milliseconds / 1000

    def host_time(self, milliseconds: int, near: float) -> float:
        """Return the host's time [s] of a reading, the one nearest to `near` [s]."""
        time = self._offset + milliseconds / 1000
        return time + round((near - time) * 1000 / WRAP) * WRAP / 1000

    def follow(self, stamp: float, arrival: float) -> None:
        """Learn the drift from a scan's stamp and arrival [s]."""
        delay = arrival - stamp
        if math.isnan(self._since):
            self._since = arrival
        self._earliest = min(self._earliest, delay)
        if arrival - self._since < WINDOW:
            return
        if math.isnan(self._delay):
            self._delay = self._earliest
        limit = LARGEST_DRIFT * WINDOW
        self._offset += max(-limit, min((self._earliest - self._delay) / 2, limit))
        self._since, self._earliest = arrival, math.inf

    def _begin_windows(self) -> None:
        self._since = self._delay = math.nan
        self._earliest = math.inf
