"""Compiled geometry and statistics that the stages and the plugins share.

All functions are numba kernels: arrays and scalars in, arrays and scalars out, no checks. Points
are given as x (P,), y (P,) [m] in beam order with `beam` (P,), the index of each point's beam.

What a detector of walls needs besides its own search is here too: `settle.free_points` before it,
the table of `walls` that it fills, `settle.settle` and `settle.line_segments` after it.
"""

from laserfeatures.geometry.compiled import helper, inlined, kernel
from laserfeatures.geometry.fit import INCIDENCE_FLOOR, Fit, fit_line
from laserfeatures.geometry.points import returns
from laserfeatures.geometry.segments import Segments, cut_segments, is_gap

__all__ = [
    "INCIDENCE_FLOOR",
    "Fit",
    "Segments",
    "cut_segments",
    "fit_line",
    "helper",
    "inlined",
    "is_gap",
    "kernel",
    "returns",
]
