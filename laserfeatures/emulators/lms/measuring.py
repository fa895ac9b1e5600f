"""What an emulated LMS2xx measures, as telegrams."""

from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.configuration import Configuration
from laserfeatures.drivers.lms.measurements import (
    MEAN_PART,
    MEAN_SCAN,
    MIRROR_TURN,
    PART,
    SCAN,
    Measurement,
    beam_angles,
    measurement_telegram,
    turns,
    values_of,
)
from laserfeatures.drivers.lms.ranges import Words, to_words
from laserfeatures.drivers.lms.telegrams import Telegram
from laserfeatures.emulators.feed import Feed
from laserfeatures.emulators.lms.memory import Memory

LOOKALIKE = np.frombuffer(bytes.fromhex("02800300a00010160a00"), dtype="<u2")
"""Values whose bytes are those of a whole reply A0."""


@dataclass(frozen=True)
class Order:
    """What is to be measured.

    Parameters
    ----------
    mean : int
        Mean of so many scans.
    first, last : int or None
        Part of a scan: its first and last value, from 1.
    partial : bool
        Single turns of the mirror.
    """

    mean: int = 1
    first: int | None = None
    last: int | None = None
    partial: bool = False


def order_of(mode: int, data: bytes) -> Order | None:
    """Return the order in a request for a streaming mode, None if the data do not fit it."""
    words = [int.from_bytes(data[i : i + 2], "little") for i in range(len(data) % 2, len(data), 2)]
    shape = {
        requests.STREAM: 0,
        requests.STREAM_PARTIAL: 0,
        requests.STREAM_MEAN: 1,
        requests.STREAM_SUB_RANGE: 4,
        requests.STREAM_MEAN_SUB_RANGE: 5,
    }
    if shape.get(mode) != len(data):
        return None
    mean = data[0] if len(data) % 2 else 1
    first, last = words or (None, None)
    return Order(mean, first, last, partial=mode == requests.STREAM_PARTIAL)


class Measuring:
    """Makes the telegrams of an order.

    Parameters
    ----------
    feed : Feed
        What is seen.
    memory : Memory
        Field of view, resolution, units and measuring mode.
    lookalike : bool
        Whether the bytes of a whole reply stand among the values.
    """

    def __init__(self, feed: Feed, memory: Memory, *, lookalike: bool) -> None:
        self.feed = feed
        self._memory, self._lookalike = memory, lookalike
        self._telegrams = 0
        self.begin(Order())

    def begin(self, order: Order) -> None:
        """Take an order."""
        self._order = order
        step = self._memory.resolution
        self._quarters = cycle(range(0, 4, max(step // 25, 1)))

    def fits(self, order: Order) -> bool:
        """Return whether the scanner can do it."""
        count = values_of(self._memory.angle, self._memory.resolution)
        if order.first is not None and order.last is not None:
            return 1 <= order.first <= order.last <= count
        return 1 <= order.mean <= 250

    @property
    def scan_time(self) -> float:
        """How long it measures for a telegram [s]."""
        step = None if self._order.partial else self._memory.resolution
        return MIRROR_TURN * turns(step, self._memory.angle) * self._order.mean

    def telegram(self, at: float, status: int) -> Telegram:
        """Return the next telegram, measured until the time `at` [s]."""
        measurement, order = self._measured(), self._order
        if Configuration(self._memory.configuration).indices:
            scan_index = round(at / MIRROR_TURN) % 256
            measurement = replace(measurement, indices=(scan_index, self._telegrams % 256))
        self._telegrams += 1
        part, mean = order.first is not None, order.mean > 1
        command = (MEAN_PART if mean else PART) if part else (MEAN_SCAN if mean else SCAN)
        return measurement_telegram(command, measurement, status)

    def _measured(self) -> Measurement:
        order, memory = self._order, self._memory
        variant = memory.angle, memory.resolution
        partial = next(self._quarters) if order.partial else None
        first = order.first
        if partial is not None:
            count = values_of(memory.angle, 100) - (partial > 0)
        elif first is not None and order.last is not None:
            count = order.last - first + 1
        else:
            count = values_of(*variant)
        angles = beam_angles(count, partial=partial, first=first, variant=variant)
        scans = [self.feed(angles) for _ in range(order.mean)]
        ranges = scans[0] if order.mean == 1 else np.mean(scans, axis=0)
        settings = Configuration(memory.configuration)
        words = self._falsified(to_words(ranges, settings.measuring_mode, settings.unit))
        return Measurement(
            words=words, unit=settings.unit, partial=partial, mean=order.mean, first=first
        )

    def _falsified(self, words: Words) -> Words:
        if self._lookalike and words.size > 2 * LOOKALIKE.size:
            words[LOOKALIKE.size : 2 * LOOKALIKE.size] = LOOKALIKE
        return words
