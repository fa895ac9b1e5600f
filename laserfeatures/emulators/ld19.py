"""The LD19, emulated."""

import math
from collections import deque
from typing import ClassVar

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.drivers.ld19.frames import CLOCK_MS, POINTS, TURN, Frame, encode
from laserfeatures.emulators.device import Device
from laserfeatures.emulators.faults import Faults
from laserfeatures.emulators.feed import Feed

RATE = 4500.0  # [Hz], measurements
LARGEST = 0xFFFF  # [mm]


class Ld19Device(Device):
    """An LD19: talks from power-on, hears nothing.

    Parameters
    ----------
    feed, faults
        As `Device`.
    turn_rate : float
        Turns a second [Hz].
    spin_up : float
        How long the motor takes to get there [s].
    clock_ms : int
        What its clock shows at power-on [ms], up to 29 999.
    intensity : int
        Of every return, 0 to 255.
    """

    name: ClassVar[str] = "LD19"

    def __init__(
        self,
        feed: Feed,
        faults: Faults | None = None,
        *,
        turn_rate: float = 10.0,
        spin_up: float = 0.2,
        clock_ms: int = 0,
        intensity: int = 200,
    ) -> None:
        super().__init__(feed, faults)
        self.baud = 230_400
        self._turn_rate, self._spin_up = turn_rate, spin_up
        self._clock_ms, self._intensity = clock_ms, intensity
        self._turn = -1

    def power_on(self, now: float) -> None:
        """Begin to turn."""
        self.hush()
        self._since = now
        self._mirror = -1  # turns since power-on
        self._sample = 0  # next to be measured
        self._angles: deque[float] = deque()  # of the samples measured, in turns since power-on
        self._ranges: deque[float] = deque()

    def hear(self, data: bytes, now: float) -> None:
        """Ignore the host."""

    def next_event(self) -> float:
        """Return when the next frame is measured."""
        return self._since + (self._sample + POINTS) / RATE

    def advance(self, now: float) -> None:
        """Send the frames that are measured by now."""
        while self.next_event() <= now:
            at = self.next_event()
            self._measure()
            self._sample += POINTS
            self.say(self._frame(at), at, self._turn)

    def _turned(self, time: float) -> float:
        """Return how far the mirror has turned [turns] at a time [s] since power-on."""
        if time < self._spin_up:
            return self._turn_rate * time**2 / (2 * self._spin_up)
        return self._turn_rate * (time - self._spin_up / 2)

    def _sample_at(self, turns: float) -> int:
        """Return the first sample at or after an angle [turns]."""
        slow = self._turn_rate * self._spin_up / 2  # turns while it spins up
        if turns < slow:
            time = math.sqrt(2 * turns * self._spin_up / self._turn_rate)
        else:
            time = turns / self._turn_rate + self._spin_up / 2
        return math.ceil(time * RATE - 1e-6)

    def _measure(self) -> None:
        """See to it that the samples of the next frame are there, turn by turn."""
        while len(self._angles) < POINTS:
            self._turn += 1
            self._mirror += 1
            samples = range(self._sample_at(self._mirror), self._sample_at(self._mirror + 1))
            turned = np.array([self._turned(i / RATE) for i in samples])
            self._angles.extend(turned)
            self._ranges.extend(self._see(turned))

    def _see(self, turned: FloatArray) -> FloatArray:
        clockwise = math.tau * (turned % 1.0)
        ranges = self.feed(math.pi - (clockwise + math.pi) % math.tau)
        return np.where(np.isfinite(ranges) & (ranges > 0), ranges * 1000, 0.0)

    def _frame(self, at: float) -> bytes:
        angles = [self._angles.popleft() for _ in range(POINTS)]
        ranges = np.array([self._ranges.popleft() for _ in range(POINTS)])
        start, end = (round(angle % 1.0 * TURN) % TURN for angle in (angles[0], angles[-1]))
        speed = (angles[-1] - angles[0]) * 360 * RATE / (POINTS - 1)
        millimetres = np.rint(ranges).clip(0, LARGEST).astype(np.uint16)
        return encode(
            Frame(
                speed=round(speed),
                start=start,
                end=end,
                ranges=millimetres,
                intensities=np.where(millimetres > 0, self._intensity, 0).astype(np.uint8),
                time=int(self._clock_ms + (at - self._since) * 1000) % CLOCK_MS,
            )
        )
