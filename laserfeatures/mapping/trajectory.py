"""Poses over time."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from laserfeatures.arrays import FloatArray, Record, read_only
from laserfeatures.data import Pose2D


@dataclass(frozen=True, eq=False, kw_only=True)
class Trajectory(Record):
    """Poses over time, of the sensor or of whatever is tracked.

    Parameters
    ----------
    stamps : (N,) array
        When [s], as the log says: not always ascending, and not always known.
    poses : (N, 3) array
        x, y [m] and heading [rad]; a heading that is not known is nan.
    """

    stamps: FloatArray
    poses: FloatArray

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        stamps = read_only(self.stamps, "stamps", (None,))
        self._set(stamps=stamps, poses=read_only(self.poses, "poses", (*stamps.shape, 3)))

    @classmethod
    def of(cls, stamps: Sequence[float], poses: Sequence[Pose2D]) -> Self:
        """Return the trajectory of some poses."""
        return cls(
            stamps=np.array(stamps, dtype=float),
            poses=np.array([(p.x, p.y, p.theta) for p in poses], dtype=float).reshape(-1, 3),
        )

    def __len__(self) -> int:
        """Return the number of poses."""
        return self.stamps.size
