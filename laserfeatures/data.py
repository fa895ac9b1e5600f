"""The data that flow through the package: scans in, lines, segments and corners out.

All are frozen dataclasses of read-only C-contiguous arrays, checked when they are made: a read-only
array is taken as it is, any other is copied. Metres, radians, seconds; the sensor's frame has x
forward, y left, angles counter-clockwise.
"""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self, cast

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, Record, lock, read_only
from laserfeatures.scan import LaserScan, Pose2D

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Features", "LaserScan", "LineSegments", "Lines", "PointFeatures", "Pose2D"]


# Stands for evidence that is left out, which becomes zeros: the field itself is never None.
def _untold() -> FloatArray:
    return cast("FloatArray", None)


@dataclass(frozen=True, eq=False, kw_only=True)
class Lines(Record):
    """Infinite lines d = x cos(theta) + y sin(theta) (the paper's Eq. 1).

    Parameters
    ----------
    theta : (L,) array
        Direction of each line's normal [rad], in [0, pi).
    d : (L,) array
        Signed distance from the sensor [m].
    support : (L,) array
        Number of the scan's points that lie on the line.
    covariance : (L, 2, 2) array
        Covariance of (theta, d) [rad^2, rad m, m^2].
    evidence : (L,) array, optional
        Log-likelihood ratio [nats] of the scan with the line against the scan explained without
        it, >= 0; 0 where the detector tells none.
    """

    theta: FloatArray
    d: FloatArray
    support: FloatArray
    covariance: FloatArray
    evidence: FloatArray = field(default_factory=_untold)

    if TYPE_CHECKING:  # what it takes is wider than what it holds

        def __init__(
            self, *, theta: ArrayLike, d: ArrayLike, support: ArrayLike,
            covariance: ArrayLike, evidence: ArrayLike | None = None,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        theta = read_only(self.theta, "theta", (None,))
        n = theta.shape
        self._set(
            theta=theta,
            d=read_only(self.d, "d", n),
            support=read_only(self.support, "support", n),
            covariance=read_only(self.covariance, "covariance", (*n, 2, 2)),
            evidence=_evidence(self.evidence, theta.size),
        )
        if theta.size and not (theta.min() >= 0 and theta.max() < math.pi):
            raise ValueError(f"theta must lie in [0, pi) rad, got {theta.tolist()}")

    def __repr__(self) -> str:
        return f"Lines({_counted(len(self), 'line')})"

    def __len__(self) -> int:
        """Return the number of lines."""
        return self.theta.size


@dataclass(frozen=True, eq=False, kw_only=True)
class LineSegments(Record):
    """Bounded pieces of lines, each cut where the scan's points along the line end.

    Parameters
    ----------
    lines : Lines
        The lines that the segments lie on; a line may carry several.
    line : (S,) int array
        Index of each segment's line.
    endpoints : (S, 2, 2) array
        First and last point of each segment in beam order [m], on its line.
    support : (S,) array
        Number of points on each segment.
    rms : (S,) array
        Root mean square distance of those points from the line [m].
    points : (S, N) bool array
        Which of the scan's N beams each segment holds.
    """

    lines: Lines
    line: IntArray
    endpoints: FloatArray
    support: FloatArray
    rms: FloatArray
    points: BoolArray

    if TYPE_CHECKING:  # what it takes is wider than what it holds

        def __init__(
            self, *, lines: Lines, line: ArrayLike, endpoints: ArrayLike,
            support: ArrayLike, rms: ArrayLike, points: ArrayLike,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        line = read_only(self.line, "line", (None,), np.int64)
        n = line.shape
        self._set(
            line=line,
            endpoints=read_only(self.endpoints, "endpoints", (*n, 2, 2)),
            support=read_only(self.support, "support", n),
            rms=read_only(self.rms, "rms", n),
            points=read_only(self.points, "points", (*n, None), np.bool_),
        )
        if line.size and not (line.min() >= 0 and line.max() < len(self.lines)):
            raise ValueError(
                f"line must index one of the {len(self.lines)} lines, got {line.tolist()}"
            )

    @classmethod
    def none(cls, beams: int) -> Self:
        """Return no segment of no line, of a scan with that many beams."""
        no, no_matrix = np.empty(0), np.empty((0, 2, 2))
        return cls(
            lines=Lines(theta=no, d=no, support=no, covariance=no_matrix),
            line=np.empty(0, np.int64),
            endpoints=no_matrix,
            support=no,
            rms=no,
            points=np.empty((0, beams), np.bool_),
        )

    def _unpack(self, numbers: FloatArray) -> None:
        """Set the fields of which `pack` made one array."""
        count = self.line.size
        lines = (numbers.size - 6 * count) // 8
        rest = numbers[8 * lines :]
        self._set(
            support=rest[:count],
            rms=rest[count : 2 * count],
            endpoints=rest[2 * count :].reshape(count, 2, 2),
            lines=Lines.trusted(
                theta=numbers[:lines],
                d=numbers[lines : 2 * lines],
                support=numbers[2 * lines : 3 * lines],
                evidence=numbers[3 * lines : 4 * lines],
                covariance=numbers[4 * lines : 8 * lines].reshape(lines, 2, 2),
            ),
        )

    def pack(self) -> FloatArray:
        """Return the numbers of lines and segments in one array, one field after another."""
        numbers: FloatArray | None = self.__dict__.get("numbers")
        if numbers is None:
            mine, lines = self, self.lines
            numbers = np.concatenate(
                [lines.theta, lines.d, lines.support, lines.evidence, lines.covariance.ravel(),
                 mine.support, mine.rms, mine.endpoints.ravel()]
            )  # fmt: skip
            lock(numbers)
        return numbers

    def __repr__(self) -> str:
        lines = _counted(len(self.lines), "line")
        return f"LineSegments({_counted(len(self), 'segment')} on {lines})"

    def __len__(self) -> int:
        """Return the number of segments."""
        return self.line.size

    @property
    def lengths(self) -> FloatArray:
        """Length of each segment [m], (S,)."""
        step = self.endpoints[:, 1] - self.endpoints[:, 0]
        return cast("FloatArray", np.hypot(step[:, 0], step[:, 1]))


@dataclass(frozen=True, eq=False, kw_only=True)
class PointFeatures(Record):
    """Corners: the intersections of lines, or points that were found without any.

    Parameters
    ----------
    positions : (F, 2) array
        Where the corners are [m].
    covariance : (F, 2, 2) array
        Covariance of each position [m^2].
    lines : (F, 2) int array
        The two lines that cross there; -1, -1 for a corner that was found without lines.
    angles : (F,) array
        Angle between the two lines, or edges, [rad], in (0, pi/2].
    real : (F,) bool array
        True for a real corner (surfaces were seen to reach it), False for a virtual one.
    evidence : (F,) array, optional
        How sure it is [nats]: the log-likelihood ratio of a corner at this place against one
        anywhere in view, and the logarithms of its lines' evidence (see `Lines`), that of the
        surer one half; 0 where the detector tells none.
    """

    positions: FloatArray
    covariance: FloatArray
    lines: IntArray
    angles: FloatArray
    real: BoolArray
    evidence: FloatArray = field(default_factory=_untold)

    if TYPE_CHECKING:  # what it takes is wider than what it holds

        def __init__(
            self, *, positions: ArrayLike, covariance: ArrayLike, lines: ArrayLike,
            angles: ArrayLike, real: ArrayLike, evidence: ArrayLike | None = None,
        ) -> None: ...  # fmt: skip

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        positions = read_only(self.positions, "positions", (None, 2))
        n = positions.shape[0]
        self._set(
            positions=positions,
            covariance=read_only(self.covariance, "covariance", (n, 2, 2)),
            lines=read_only(self.lines, "lines", (n, 2), np.int64),
            angles=read_only(self.angles, "angles", (n,)),
            real=read_only(self.real, "real", (n,), np.bool_),
            evidence=_evidence(self.evidence, n),
        )

    def _unpack(self, numbers: FloatArray) -> None:
        """Set the fields out of an array of them with room for more corners."""
        count = self.real.size
        most = numbers.size // 8
        self._set(
            positions=numbers[: 2 * count].reshape(count, 2),
            covariance=numbers[2 * most : 2 * most + 4 * count].reshape(count, 2, 2),
            angles=numbers[6 * most : 6 * most + count],
            evidence=numbers[7 * most : 7 * most + count],
        )

    def select(self, kept: BoolArray | IntArray) -> Self:
        """Return those corners that a mask (F,), or numbers of corners, keep."""
        every = (self.positions, self.covariance, self.lines, self.angles, self.real, self.evidence)
        places, covariance, lines, angles, real, evidence = (each[kept] for each in every)
        return type(self)(
            positions=places, covariance=covariance, lines=lines, angles=angles, real=real,
            evidence=evidence,
        )  # fmt: skip

    def __repr__(self) -> str:
        return f"PointFeatures({_counted(len(self), 'corner')}, {int(self.real.sum())} real)"

    def __len__(self) -> int:
        """Return the number of corners."""
        return self.real.size


@dataclass(frozen=True, eq=False, kw_only=True)
class Features(Record):
    """What an extractor found in one scan."""

    scan: LaserScan
    segments: LineSegments
    corners: PointFeatures

    @property
    def lines(self) -> Lines:
        """The lines that carry the segments."""
        return self.segments.lines

    def __repr__(self) -> str:
        return (
            f"Features({_counted(len(self.lines), 'line')}, "
            f"{_counted(len(self.segments), 'segment')}, {_counted(len(self.corners), 'corner')} "
            f"({int(self.corners.real.sum())} real)\n  of {self.scan!r})"
        )


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'s' * (number != 1)}"


def _evidence(value: FloatArray | None, count: int) -> FloatArray:
    """Return checked evidence (count,), zeros where it was left out."""
    evidence = read_only(np.zeros(count) if value is None else value, "evidence", (count,))
    if not (evidence >= 0).all():
        raise ValueError(f"evidence must be >= 0 and not nan, got {evidence.tolist()}")
    return evidence
