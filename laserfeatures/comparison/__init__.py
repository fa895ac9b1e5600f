"""Extractors compared on the same scans: speed, corners found again, and agreement.

>>> import laserfeatures as lf
>>> import numpy as np
>>> from laserfeatures.comparison import compare
>>> from laserfeatures.simulation import Scanner, hallway
>>> world, path = hallway()
>>> rng = np.random.default_rng(1)
>>> scans = [Scanner().scan(world, pose, rng) for pose in path]
>>> presets = {"ours": None, "paper": "paper"}
>>> extractors = {k: lf.get_extractor("direct_hough", preset=p) for k, p in presets.items()}
>>> comparison = compare(extractors, scans)
>>> comparison.runs["ours"].lines.tolist() == [len(extractors["ours"](s).lines) for s in scans]
True
>>> comparison.agreement.shape  # share of the row's corners that the column has
(2, 2)
"""

from laserfeatures.comparison.comparing import Comparison, compare
from laserfeatures.comparison.evidence import Curve
from laserfeatures.comparison.growth import Growth, growth
from laserfeatures.comparison.matching import Repeatability, Share
from laserfeatures.comparison.turns import Extractor, Failure, Run

__all__ = [
    "Comparison",
    "Curve",
    "Extractor",
    "Failure",
    "Growth",
    "Repeatability",
    "Run",
    "Share",
    "compare",
    "growth",
]
