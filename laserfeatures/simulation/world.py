"""Worlds: floor plans of straight walls."""

import math
from dataclasses import dataclass
from typing import Self

from numpy.typing import ArrayLike

from laserfeatures.arrays import FloatArray, Record, read_only
from laserfeatures.data import Pose2D


@dataclass(frozen=True, eq=False, kw_only=True)
class World(Record):
    """A floor plan.

    Parameters
    ----------
    walls : (W, 2, 2) array
        Both ends of each wall [m].
    """

    walls: FloatArray

    def __post_init__(self) -> None:
        """Check and lock the walls."""
        walls = read_only(self.walls, "walls", (None, 2, 2))
        self._set(walls=walls)
        for i, (start, end) in enumerate(walls):
            if not 0 < abs(end - start).max() < math.inf:
                raise ValueError(f"wall {i} must have a finite length > 0, got {walls[i].tolist()}")

    @classmethod
    def outline(cls, *polygons: ArrayLike) -> Self:
        """Make a world of closed polygons, each (n, 2) [m]."""
        walls = []
        for polygon in polygons:
            points = read_only(polygon, "polygon", (None, 2))
            walls += [(points[i - 1], points[i]) for i in range(len(points))]
        return cls(walls=walls)  # type: ignore[arg-type]


def hallway() -> tuple[World, list[Pose2D]]:
    """Return an L-shaped hallway with two door niches and a cupboard, and a path through it.

    The plan is in the manner of the paper's Fig. 5: a long part where parallel walls dominate and a
    part with oblique walls.
    """
    outline = [
        (0.0, 0.0), (5.0, 0.0), (5.0, -0.3), (6.0, -0.3), (6.0, 0.0), (10.0, 0.0),
        (10.0, 6.0), (9.0, 7.0), (8.2, 7.0), (7.6, 6.0), (7.6, 4.6), (7.9, 4.6), (7.9, 3.7),
        (7.6, 3.7), (7.6, 2.2), (0.0, 2.2),
    ]  # fmt: skip
    cupboard = [(2.6, 1.8), (3.6, 1.8), (3.6, 2.2), (2.6, 2.2)]
    path = [
        Pose2D(1.0, 1.0, 0.0), Pose2D(2.5, 0.9, 0.1), Pose2D(4.0, 1.0, 0.0), Pose2D(5.5, 1.1, 0.2),
        Pose2D(7.0, 1.2, 0.3), Pose2D(8.5, 1.6, 0.9), Pose2D(8.8, 2.8, 1.4), Pose2D(8.7, 4.2, 1.7),
    ]  # fmt: skip
    return World.outline(outline, cupboard), path
