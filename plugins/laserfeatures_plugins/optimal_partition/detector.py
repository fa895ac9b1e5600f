"""The extractor `optimal_partition`."""

from dataclasses import dataclass
from typing import ClassVar

from laserfeatures.engine import WallDetector


@dataclass(frozen=True, kw_only=True)
class OptimalPartition(WallDetector):
    """Find the sequence of walls, round objects and stray returns that explains a scan best.

    No line is proposed: every stretch of the scan may be a wall. The cheapest sequence is found by
    dynamic programming over the returns: exactly, but that starts far back in one piece are thinned
    out, so that time grows about linearly with the returns.

    References
    ----------
    Jackson et al. (2005), "An algorithm for optimal partitioning of data on an interval"; Killick,
    Fearnhead and Eckley (2012), "Optimal detection of changepoints with a linear computational
    cost", for the starts that can be dropped. Schaefer et al. (2018), "A maximum likelihood
    approach to extract polylines from 2-D laser range scans", for the likelihood of ranges.
    """

    longest: ClassVar[int] = 1 << 40
