"""Extractors run in turns on the same scans, and timed."""

import gc
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice, repeat
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Features, LaserScan, PointFeatures

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

TURN = 20  # scans
LONGEST_MESSAGE = 300  # characters: a plugin may say anything

Extractor = Callable[..., Features]  # of a scan, and of its noise where that is told
Numbered = tuple[int, LaserScan, "RangeNoise | None"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """What an extractor found in each of N scans, and how long it took.

    Parameters
    ----------
    seconds : (N,) array
        Time from ranges to corners [s].
    lines : (N,) int array
        Number of lines.
    corners : tuple of PointFeatures
        The corners of each scan, in the sensor's frame.
    """

    seconds: FloatArray
    lines: IntArray
    corners: tuple[PointFeatures, ...]

    @property
    def positions(self) -> list[FloatArray]:
        """Positions of the corners of each scan, N arrays (F, 2) [m]."""
        return [corners.positions for corners in self.corners]

    @property
    def corner_counts(self) -> IntArray:
        """Number of corners of each scan, (N,)."""
        return np.array([len(corners) for corners in self.corners], dtype=np.int64)

    @property
    def real_counts(self) -> IntArray:
        """Number of real corners of each scan, (N,)."""
        return np.array([corners.real.sum() for corners in self.corners], dtype=np.int64)


@dataclass(frozen=True, eq=False, kw_only=True)
class Failure:
    """Why an extractor has no results.

    Parameters
    ----------
    error : Exception
        What it raised.
    scan : int or None
        Number of the scan that it raised at; None if it could not even be made.
    """

    error: Exception
    scan: int | None = None

    def __str__(self) -> str:
        """Say in one line what happened, and where."""
        message = " ".join(str(self.error).split())[:LONGEST_MESSAGE]
        if self.scan is None:
            return message or type(self.error).__name__
        what = f"{type(self.error).__name__}: {message}".removesuffix(": ")
        return f"failed at scan {self.scan}: {what}"


def run_in_turns(
    extractors: Mapping[str, Extractor],
    scans: Iterable[LaserScan],
    *,
    noises: "Iterable[RangeNoise | None] | None" = None,
    start: int = 0,
) -> dict[str, Run | Failure]:
    """Run every extractor once on every scan, and time it.

    They take turns of 20 scans in this process, so that a slow minute of the machine hits all of
    them. Each call gets a scan of which nothing is computed yet. The first turn is run twice and
    counted once, and each later one begins with the scan before it, not counted: neither compiling
    nor what the others left in the processor's caches is an extractor's own.

    Parameters
    ----------
    extractors : mapping of str to callable
        From a name to an extractor.
    scans : iterable of LaserScan
        The scans, taken one turn at a time.
    noises : iterable of RangeNoise or None, optional
        The noise of each scan, which the extractors are told as ``noise=``; None: they are not.
    start : int
        Number of the first scan, for messages.

    Returns
    -------
    dict of str to Run or Failure
        By name. An extractor that raises is not called again, and what it found before is dropped.
    """
    turns = {name: _Turns(extractor) for name, extractor in extractors.items()}
    told = zip(scans, repeat(None) if noises is None else noises, strict=noises is not None)
    numbered = ((number, scan, noise) for number, (scan, noise) in enumerate(told, start))
    while turn := list(islice(numbered, TURN)):
        for own in turns.values():
            own.take(turn)
    return {name: own.outcome() for name, own in turns.items()}


@dataclass
class _Turns:
    """What one extractor did so far."""

    extractor: Extractor
    seconds: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    corners: list[PointFeatures] = field(default_factory=list)
    before: list[Numbered] = field(default_factory=list)
    failure: Failure | None = None

    def take(self, turn: list[Numbered]) -> None:
        """Run on the scans of one turn, each given with its number."""
        if self.failure:
            return
        with _no_collection():
            for each in self.before or turn:
                self._call(*each)
            for each in turn:
                self._call(*each, counted=True)
        self.before = turn[-1:]

    def _call(
        self, number: int, scan: LaserScan, noise: "RangeNoise | None", *, counted: bool = False
    ) -> None:
        if self.failure:
            return
        again = replace(scan)  # nothing cached
        told = {} if noise is None else {"noise": noise}
        try:
            before = time.perf_counter()
            features = self.extractor(again, **told)
            seconds = time.perf_counter() - before
        except Exception as error:  # noqa: BLE001 - a plugin may raise anything
            self.failure = Failure(error=error, scan=number)
            return
        if counted:
            self.seconds.append(seconds)
            self.lines.append(len(features.lines))
            self.corners.append(features.corners)

    def outcome(self) -> Run | Failure:
        """Return what was found, or why not."""
        return self.failure or Run(
            seconds=np.array(self.seconds),
            lines=np.array(self.lines, dtype=np.int64),
            corners=tuple(self.corners),
        )


@contextmanager
def _no_collection() -> Iterator[None]:
    """Keep the garbage collector from running between two readings of the clock."""
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.enable()
