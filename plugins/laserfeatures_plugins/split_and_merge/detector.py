"""The extractor `split_and_merge`."""

from dataclasses import dataclass

from laserfeatures.arrays import FloatArray
from laserfeatures.engine import WallDetector
from laserfeatures_plugins.split_and_merge.splitting import propose


@dataclass(frozen=True, kw_only=True)
class SplitAndMerge(WallDetector):
    """Break the scan where it jumps, split the pieces at their corners.

    The pieces are split at the point farthest from the chord through their ends (iterative
    end-point fit) until a least-squares line explains each. The scan is then explained by these
    lines and what they leave, and collinear ones are merged (see `WallDetector`).

    References
    ----------
    Nguyen et al. (2007), "A comparison of line extraction algorithms using 2D range data for indoor
    mobile robotics", for the method.
    """

    def propose(self, table: FloatArray) -> FloatArray:
        """Return the pieces' lines."""
        return propose(table)
