"""The noise of a sensor's ranges, settling from scan to scan."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from laserfeatures.data import LaserScan
from laserfeatures.engine.certainty import LARGEST
from laserfeatures.engine.detector import WallDetector
from laserfeatures.engine.explain import prepare
from laserfeatures.engine.history import CELLS, fit_cells, gather
from laserfeatures.engine.sequence import INCIDENCE_FLOOR
from laserfeatures.parameters import settle, whole

MEMORY = 300  # scans
START = 20  # scans after each of which all is estimated anew;
SELDOM = 10  # later so seldom
SURELY = 2.0  # standard errors: only a roughness beyond them is told


@dataclass(frozen=True, kw_only=True)
class RangeNoise:
    """The noise of ranges: that of a range r has the variance sigma^2 + (relative r)^2.

    Parameters
    ----------
    sigma : float
        Standard deviation of a short range [m].
    relative : float
        What it grows by with the range [m/m].
    roughness : float
        Standard deviation of walls from planes [m].
    correlation : float
        How alike the errors of neighbouring ranges are: 0 where they are independent, 1 where all
        are one.

    Raises
    ------
    ValueError
        If one is out of its range.
    """

    sigma: float
    relative: float = 0.0
    roughness: float = 0.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        settle(self)
        if not 0 < self.sigma <= 1:
            raise ValueError(f"sigma must be in (0, 1] m, got {self.sigma!r}")
        if not 0 <= self.relative < 1:
            raise ValueError(f"relative must be in [0, 1), got {self.relative!r}")
        if not 0 <= self.roughness <= 1:
            raise ValueError(f"roughness must be in [0, 1] m, got {self.roughness!r}")
        if not 0 <= self.correlation <= 1:
            raise ValueError(f"correlation must be in [0, 1], got {self.correlation!r}")

    def at(self, r: float) -> float:
        """Return the standard deviation of a range of `r` [m]."""
        return math.hypot(self.sigma, self.relative * r)


class Uncertainty(NamedTuple):
    """Standard errors of the numbers of a `RangeNoise`; inf where nothing is known."""

    sigma: float  # [m]
    relative: float
    roughness: float  # [m]


UNSEEN = RangeNoise(sigma=0.01)
UNKNOWN = Uncertainty(math.inf, math.inf, math.inf)


class NoiseModel:
    """The noise of a sensor's ranges, told from scan after scan of it.

    Each stretch of eight returns shows a variance about its line. Those on walls gather round
    sigma^2 + (relative r)^2, the others lie above; a fit whose weights fall to nothing settles on
    the former (`engine.noise`), here over the stretches of all scans so far. Old ones are forgotten
    slowly. The roughness is what the returns of walls are off their lines beyond that noise.

    The same scans in the same order give the same numbers.

    Parameters
    ----------
    memory : int
        Scans after which one counts 1/e of a new one.

    Raises
    ------
    ValueError
        If the memory is shorter than a scan.

    Examples
    --------
    >>> import numpy as np
    >>> from laserfeatures.simulation import Scanner, hallway
    >>> world, way = hallway()
    >>> rng, model = np.random.default_rng(1), NoiseModel()
    >>> for pose in way[:4]:
    ...     noise = model.feed(Scanner(range_sigma=0.01).scan(world, pose, rng))
    >>> round(noise.at(2.0), 3), model.scans
    (0.01, 4)
    """

    def __init__(self, *, memory: int = MEMORY) -> None:
        self.memory = whole("memory", memory)
        if self.memory < 1:
            raise ValueError(f"memory must be >= 1 scan, got {memory!r}")
        self._keep = math.exp(-1.0 / self.memory)
        self._cells = np.zeros((4, CELLS))
        self._walls = np.zeros(6)  # sums over the scans of what `_shown` returns, and products
        self._weight = self._squares = 0.0  # sums of what each scan counts
        self._least = self._mean = 0.0  # weighted sums over the scans
        self._scans = 0
        self._noise = UNSEEN
        self._uncertainty = UNKNOWN

    @property
    def noise(self) -> RangeNoise:
        """The noise by all scans so far; 1 cm where none has told any."""
        return self._noise

    @property
    def uncertainty(self) -> Uncertainty:
        """Standard errors of these numbers by the scatter of what they come from."""
        return self._uncertainty

    @property
    def scans(self) -> int:
        """How many scans have told something."""
        return self._scans

    def feed(self, scan: LaserScan) -> RangeNoise:
        """Take in a scan and return the noise to explain it with.

        A scan without as much as a stretch of returns changes nothing.
        """
        limits = (scan.range_min, scan.range_max)
        stretches, least, mean = gather(
            scan.directions, scan.ranges, limits, scan.ring, self._cells, self._keep
        )
        if not stretches:
            return self._noise
        self._scans += 1
        self._weight = self._weight * self._keep + 1.0
        self._squares = self._squares * self._keep**2 + 1.0
        self._least = self._least * self._keep + least
        self._mean = self._mean * self._keep + mean
        if self._scans <= START or self._scans % SELDOM == 0:
            self._settle(scan)
        return self._noise

    def _settle(self, scan: LaserScan) -> None:
        """Estimate all anew; the walls of `scan` tell the roughness."""
        weight = self._weight
        constant, growing, constant_error, growing_error, correlation = fit_cells(
            self._cells, self._least / weight, self._mean / weight, self._squares / weight
        ).tolist()
        sigma = min(math.sqrt(constant), 1.0)
        relative = min(math.sqrt(growing), 0.99)
        plain = RangeNoise(sigma=sigma, relative=relative, correlation=correlation)
        more, free, variance = _shown(scan, plain)
        self._walls *= self._keep
        self._walls += (more, free, variance, more * more, more * free, free * free)
        square, square_error = self._excess()
        roughness = min(math.sqrt(max(square - SURELY * square_error, 0.0)), 1.0)
        self._noise = RangeNoise(
            sigma=sigma, relative=relative, roughness=roughness, correlation=correlation
        )
        self._uncertainty = Uncertainty(
            _error(sigma, constant_error), _error(relative, growing_error),
            _error(roughness, square_error),
        )  # fmt: skip

    def _excess(self) -> tuple[float, float]:
        """Return what walls show beyond the noise [m^2], and its standard error by the scans."""
        more, free, variance, more2, more_free, free2 = self._walls.tolist()
        if free == 0.0:
            return 0.0, 0.0
        share = more / free
        scatter = more2 - 2.0 * share * more_free + share * share * free2
        return share * variance / free, math.sqrt(max(scatter, 0.0)) / free * variance / free


def noise_of(scan: LaserScan) -> RangeNoise:
    """Return the noise that a scan tells by itself, as a detector takes it without a model."""
    limits = (scan.range_min, scan.range_max)
    unknown = (-1.0, 0.0, 0.0, -1.0)
    _, told = prepare(scan.directions, scan.ranges, limits, scan.ring, *unknown)
    sigma, relative, roughness, correlation = told
    return RangeNoise(sigma=sigma, relative=relative, roughness=roughness, correlation=correlation)


def _shown(scan: LaserScan, noise: RangeNoise) -> tuple[float, float, float]:
    """Return what the walls of a scan show beyond the noise.

    That are chi squared less the degrees of freedom, these, and these times the noise's variance
    [m^2]. What one wall can show is bounded: it may be none.
    """
    found = WallDetector()(scan, noise=noise)
    segment, beam = np.nonzero(found.points)
    line = found.line[segment]
    normal = np.stack([np.cos(found.lines.theta), np.sin(found.lines.theta)], axis=1)[line]
    cosine = (scan.directions[beam] * normal).sum(axis=1)
    ranges = scan.ranges[beam]
    variance = noise.sigma**2 + (noise.relative * ranges) ** 2
    chi2 = (ranges * cosine - found.lines.d[line]) ** 2 / (variance * (cosine**2 + INCIDENCE_FLOOR))
    count = np.bincount(line, minlength=len(found.lines))
    free = np.maximum(count - 2.0, 0.0)
    sums = np.minimum(np.bincount(line, chi2, len(found.lines)), LARGEST * free)
    mean = np.bincount(line, variance, len(found.lines)) / np.maximum(count, 1)
    return float((sums - free).sum()), float(free.sum()), float((free * mean).sum())


def _error(value: float, square_error: float) -> float:
    """Return the standard error of a number by that of its square."""
    return min(square_error / (2.0 * value) if value > 0.0 else math.inf, math.sqrt(square_error))
