"""Which extractors the contract's tests run, and how well each must find what is there."""

import math
from typing import NamedTuple

import numpy as np
import pytest
from scenes import found_lines, nearest_line

import laserfeatures as lf


class Case(NamedTuple):
    """An extractor, and how well it must find what is there."""

    name: str
    preset: str | None = None
    angle: float = math.radians(1.0)  # [rad]
    distance: float = 0.02  # [m]
    literal: bool = False  # finds what stands out in its bins: not just walls, and those in pieces
    lines: bool = True  # finds lines; False: corners without any

    def __str__(self) -> str:
        return f"{self.name}-{self.preset}" if self.preset else self.name

    def make(self, **parameters):
        return lf.get_extractor(self.name, preset=self.preset, **parameters)


# The paper's preset reports bins, whose noise its votes do not smooth. A corner of an image is off
# by the pixels, and its angle by what the ring around it tells.
CASES = [
    *(Case(name) for name in lf.list_extractors() if name != "kanade_tomasi"),
    Case("direct_hough", "paper", angle=math.radians(2.5), distance=0.05, literal=True),
    Case("kanade_tomasi", angle=math.radians(5.0), lines=False),
]
every_extractor = pytest.mark.parametrize("case", CASES, ids=str)
finds_lines = pytest.mark.parametrize("case", [case for case in CASES if case.lines], ids=str)
finds_walls_only = pytest.mark.parametrize(
    "case", [case for case in CASES if case.lines and not case.literal], ids=str
)
finds_corners_only = pytest.mark.parametrize(
    "case", [case for case in CASES if not case.lines], ids=str
)


def the_line(case, features, truth):
    """Return the index of the line that is `truth`, which must be there once."""
    near = nearest_line(found_lines(features), truth, case.angle, case.distance)
    assert len(near) == 1, f"{truth} is not once in {found_lines(features).tolist()}"
    return near[0]


def the_corner(case, features, truth):
    """Return the index of the corner at `truth`, which must be there once."""
    off = np.hypot(*(features.corners.positions - truth).T)
    near = np.flatnonzero(off < 3 * case.distance)
    assert len(near) == 1, f"{truth} is not once in {features.corners.positions.tolist()}"
    return near[0]
