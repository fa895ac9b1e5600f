"""The stage that all extractors of lines share: it explains a scan as a whole.

`explain` is its main path; `WallDetector` is what a detector builds on. What is compiled is a numba
kernel: arrays and scalars in, arrays and scalars out, no checks.
"""

from laserfeatures.compiled import ZERO, helper, kernel, leaf
from laserfeatures.engine.detector import WallDetector

__all__ = ["ZERO", "WallDetector", "helper", "kernel", "leaf"]
