"""The extractor `ransac`."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan, LineSegments
from laserfeatures.engine import WallDetector
from laserfeatures_plugins.ransac.sampling import propose

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise


@dataclass(frozen=True, kw_only=True)
class Ransac(WallDetector):
    """Draw two points, keep the line that explains the others best, refit, repeat.

    Sequential RANSAC: a line is scored by the points that no wall owns yet, of many by every k-th;
    the best is refitted to its inliers along the scan. Points of walls are not drawn again. The
    scan is then explained by these lines and what they leave (see `WallDetector`).

    Parameters
    ----------
    window : int
        The second point of a sample is at most so many beams from the first; 0: anywhere.
    confidence : float
        Probability with which a sample free of outliers is drawn before a search for a wall ends.
    max_trials : int
        Samples drawn for one wall at the most.
    seed : int
        Of the random numbers; each scan starts from it anew.

    Raises
    ------
    ValueError
        If a parameter is out of its range; at a scan, if `window` is wider than the scan or
        `max_gap` less than the way from beam to beam.

    References
    ----------
    Fischler and Bolles (1981), "Random sample consensus"; the score is the MSAC of Torr and
    Zisserman (2000), "MLESAC"; samples of near points follow Myatt et al. (2002), "NAPSAC".
    """

    window: int = 12
    confidence: float = 0.99
    max_trials: int = 200
    seed: int = field(default=0, metadata={"bits": 63})

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        if not 0 < self.confidence < 1:
            raise ValueError(f"confidence must be in (0, 1), got {self.confidence!r}")
        for name, least in (("window", 0), ("max_trials", 1), ("seed", 0)):
            if not getattr(self, name) >= least:
                raise ValueError(f"{name} must be >= {least}, got {getattr(self, name)!r}")

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> LineSegments:
        """Return the walls of `scan` and the segments seen of each."""
        if self.window > len(scan) and self.window != Ransac.window:
            raise ValueError(f"window is {self.window} beams, the scan has only {len(scan)}")
        return super().__call__(scan, noise=noise)

    def propose(self, table: FloatArray) -> FloatArray:
        """Return the lines found one after another."""
        sampling = (self.window, math.log(1 - self.confidence), self.max_trials, self.seed)
        return propose(table, sampling, self.max_missed)
