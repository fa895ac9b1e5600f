"""The extractor `region_growing`."""

from dataclasses import dataclass

from laserfeatures.arrays import FloatArray
from laserfeatures.engine import WallDetector
from laserfeatures_plugins.region_growing.growing import propose


@dataclass(frozen=True, kw_only=True)
class RegionGrowing(WallDetector):
    """Grow walls from neighbouring points along the scan, with running sums.

    Each point that is on no wall yet starts one with its followers; the points that come next join
    as long as they are near the line so far, whose parameters follow from running sums. Single
    beams that miss the line do not end it. The scan is then explained by these lines and what they
    leave (see `WallDetector`).

    References
    ----------
    Gao et al. (2018), "A line segment extraction algorithm using laser data based on seeded region
    growing", for seeds and growth in scan order; the skipped outliers are this project's.
    """

    def propose(self, table: FloatArray) -> FloatArray:
        """Return the regions' lines."""
        return propose(table, self.max_missed)
