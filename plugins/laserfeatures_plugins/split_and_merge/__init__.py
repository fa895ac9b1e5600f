"""Split and merge: iterative end-point fit, least squares, merged neighbours."""

from laserfeatures_plugins.split_and_merge.detector import SplitAndMerge

__all__ = ["SplitAndMerge"]
