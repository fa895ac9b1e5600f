"""What ``laserfeatures live`` counts and shows."""

import shutil
from collections import deque
from dataclasses import dataclass, field
from typing import IO

import click
import numpy as np

from laserfeatures.data import Features
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.losses import Losses

RECENT = 5.0  # [s]; the rate is of these
REMEMBERED = 100_000  # latencies
REDRAW = 0.2  # [s]
LINE_EVERY = 1.0  # [s]
NEAREST = 5  # corners shown


@dataclass
class Tally:
    """What is counted over the scans.

    Parameters
    ----------
    losses : Losses
        The source's own counters.
    """

    losses: Losses
    began: float = field(default_factory=now)
    scans: int = 0
    _arrivals: deque[float] = field(default_factory=deque)
    _latencies: deque[float] = field(default_factory=lambda: deque(maxlen=REMEMBERED))

    def add(self, arrival: float, done: float) -> None:
        """Count a scan whose first byte came at `arrival` and whose features were there `done`."""
        self.scans += 1
        self._latencies.append(done - arrival)
        self._arrivals.append(arrival)
        while arrival - self._arrivals[0] > RECENT:
            self._arrivals.popleft()

    @property
    def rate(self) -> float:
        """Scans a second, of late."""
        if len(self._arrivals) < 2:
            return 0.0
        span = self._arrivals[-1] - self._arrivals[0]
        return (len(self._arrivals) - 1) / span if span > 0 else 0.0

    def latency(self) -> str:
        """Return the median and the 99th percentile of the latency, in words."""
        if not self._latencies:
            return "-"
        median, late = np.percentile(self._latencies, (50, 99)) * 1000
        return f"{median:.1f} ms median, {late:.1f} ms p99"

    def head(self) -> list[str]:
        """Return what is known of all scans, in pieces of a line."""
        return [
            f"{now() - self.began:.1f} s",
            f"{self.scans} scans",
            f"{self.rate:.1f} /s",
            f"latency {self.latency()}",
            f"lost {self.losses.scans}",
            f"losses {self.losses}",
        ]

    def summary(self) -> str:
        """Return the last line."""
        took = now() - self.began
        return (
            f"{self.scans} scans in {took:.1f} s ({self.scans / max(took, 1e-9):.1f} /s), latency "
            f"{self.latency()}; lost scans: {self.losses.scans}; losses: {self.losses}"
        )


class Lines:
    """A line each second, for a pipe."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._due = 0.0

    def __call__(self, tally: Tally, features: Features) -> None:
        """Show a scan's features, if it is time."""
        if now() < self._due:
            return
        self._due = now() + LINE_EVERY
        corners = ", ".join(_corner(*corner) for corner in nearest(features, 1)) or "none"
        pieces = [*tally.head(), *counts(features), f"nearest {corners}"]
        click.echo("  ".join(pieces), file=self._stream)


class Block:
    """A few lines redrawn in place, for a terminal."""

    def __init__(self, stream: IO[str]) -> None:
        self._stream = stream
        self._due = 0.0
        self._height = 0

    def __call__(self, tally: Tally, features: Features) -> None:
        """Show a scan's features, if it is time."""
        if now() < self._due:
            return
        self._due = now() + REDRAW
        time, scans, rate, latency, lost, losses = tally.head()
        corners = [f"  {_corner(*corner)}" for corner in nearest(features, NEAREST)]
        lines = [
            f"{time}  {scans}  {rate}  {latency}",
            f"{lost}  {losses}",
            "  ".join(counts(features)),
            *(corners + [""] * NEAREST)[:NEAREST],
        ]
        up = f"\x1b[{self._height}F" if self._height else ""
        text = "".join(f"\x1b[2K{line[: _width()]}\n" for line in lines)
        click.echo(up + text, nl=False, file=self._stream)
        self._height = len(lines)


def nearest(features: Features, count: int) -> list[tuple[float, float, str]]:
    """Return x and y [m] and kind of the corners nearest to the sensor."""
    positions, real = features.corners.positions, features.corners.real
    order = np.argsort(np.linalg.norm(positions, axis=1), kind="stable")[:count]
    return [(*positions[i].tolist(), "real" if real[i] else "virtual") for i in order]


def counts(features: Features) -> list[str]:
    """Return how many lines and corners there are."""
    return [f"{len(features.lines)} lines", f"{len(features.corners)} corners"]


def _corner(x: float, y: float, kind: str) -> str:
    return f"({x:.2f}, {y:.2f}) m {kind}"


def _width() -> int:
    return shutil.get_terminal_size().columns - 1
