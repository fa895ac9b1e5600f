"""Scores of what was found in scans against what is true of them."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, fields
from typing import Any, Self

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Features
from laserfeatures.evaluation.matching import GATE, match_corners, match_lines
from laserfeatures.evaluation.true_lines import difference
from laserfeatures.evaluation.truth import Truth

ELLIPSE = -2 * math.log(0.05)  # squared Mahalanobis distance within which 95 % of errors lie


def _none() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Score:
    """Counts and errors of one scan, or of many: scores add up.

    Parameters
    ----------
    scans, blind_scans : int
        Scans, and those in which no corner was found (the paper, section IV.B).
    features_true, features_extracted, features_matched : int
        True corners, corners found, and pairs of both within the gate.
    errors : (M,) array
        Distance of each matched corner from its true one [m].
    confusion : (2, 2) int array
        Matched corners by what is true (rows: virtual, real) and what was found (columns).
    lines_true, lines_extracted, lines_matched, duplicates : int
        True lines, lines found, pairs of both, and lines found again (see `match_lines`).
    angle_errors, distance_errors : (P,) arrays
        Errors of the matched lines' theta [rad] and d [m], signed.
    corner_nees, line_nees : arrays
        Squared Mahalanobis distance of each corner and line from what is true; inf where there is
        no valid covariance. A corner's truth is the crossing of the true lines of its two lines,
        however far off; where it has no lines, the corner that it was matched with.
    """

    scans: int = 0
    blind_scans: int = 0
    features_true: int = 0
    features_extracted: int = 0
    features_matched: int = 0
    errors: FloatArray = field(default_factory=_none)
    confusion: IntArray = field(default_factory=lambda: np.zeros((2, 2), np.int64))
    lines_true: int = 0
    lines_extracted: int = 0
    lines_matched: int = 0
    duplicates: int = 0
    angle_errors: FloatArray = field(default_factory=_none)
    distance_errors: FloatArray = field(default_factory=_none)
    corner_nees: FloatArray = field(default_factory=_none)
    line_nees: FloatArray = field(default_factory=_none)

    @classmethod
    def total(cls, scores: Iterable["Score"]) -> Self:
        """Add scores up."""
        parts = [cls(), *scores]
        sums: dict[str, Any] = {}
        for item in fields(cls):
            values = [getattr(part, item.name) for part in parts]
            lists = isinstance(values[0], np.ndarray) and values[0].ndim == 1
            sums[item.name] = np.concatenate(values) if lists else sum(values)
        return cls(**sums)

    def __add__(self, other: "Score") -> Self:
        """Return the score of the scans of both."""
        return self.total([self, other])

    @property
    def tp_percent(self) -> float:
        """True positives [%]: matched of the true corners (the paper's Eq. 3); nan of none."""
        return 100 * _share(self.features_matched, self.features_true)

    @property
    def fp_percent(self) -> float:
        """False positives [%]: unmatched of the corners found (the paper's Eq. 4); nan of none."""
        return 100 * _share(
            self.features_extracted - self.features_matched, self.features_extracted
        )

    @property
    def f1(self) -> float:
        """Harmonic mean of recall and precision of the corners; nan where there are none at all."""
        return _share(2 * self.features_matched, self.features_true + self.features_extracted)

    @property
    def median_error(self) -> float:
        """Median distance of a matched corner from its true one [m]."""
        return float(np.median(self.errors)) if self.errors.size else math.nan

    @property
    def rms_error(self) -> float:
        """Root mean square distance of the matched corners from their true ones [m]."""
        return math.sqrt(np.mean(self.errors**2)) if self.errors.size else math.nan

    @property
    def line_recall(self) -> float:
        """Share of the true lines that were found."""
        return _share(self.lines_matched, self.lines_true)

    @property
    def line_precision(self) -> float:
        """Share of the lines found that are true."""
        return _share(self.lines_matched, self.lines_extracted)

    @property
    def corner_consistency(self) -> float:
        """Share of the corners within their own 95 % ellipse."""
        return _share(int((self.corner_nees <= ELLIPSE).sum()), self.corner_nees.size)

    @property
    def line_consistency(self) -> float:
        """Share of the lines within their own 95 % ellipse."""
        return _share(int((self.line_nees <= ELLIPSE).sum()), self.line_nees.size)


def score(features: Features, truth: Truth, gate: float = GATE) -> Score:
    """Return the score of what was found in one scan.

    Parameters
    ----------
    features : Features
        What was found.
    truth : Truth
        What is true; where only the corners are known, only they are scored.
    gate : float
        Largest distance of a corner from its true one [m].

    Raises
    ------
    ValueError
        If the gate is not a distance, or the scans of features and truth differ in size.
    MissingDependencyError
        If SciPy is missing.

    References
    ----------
    The paper, section IV, Eqs. 3 and 4.
    """
    corners = features.corners
    found, true = match_corners(corners.positions, truth.corners, gate)
    error = corners.positions[found] - truth.corners[true]
    confusion = np.zeros((2, 2), np.int64)
    np.add.at(confusion, (truth.real[true].astype(int), corners.real[found].astype(int)), 1)
    of_corners = Score(
        scans=1,
        blind_scans=int(len(corners) == 0),
        features_true=len(truth.corners),
        features_extracted=len(corners),
        features_matched=found.size,
        errors=np.hypot(*error.T),
        confusion=confusion,
    )
    if not truth.lines_known:
        return of_corners + Score(
            corner_nees=_squared_mahalanobis(error, corners.covariance[found])
        )
    matched = np.full(len(corners), -1)
    matched[found] = true
    return of_corners + _score_lines(features, truth, matched)


def _score_lines(features: Features, truth: Truth, matched: IntArray) -> Score:
    lines = features.lines
    wall, duplicates = match_lines(features.segments, truth)
    mine = np.flatnonzero(wall >= 0)
    turn, shift = difference(
        lines.theta[mine], lines.d[mine], truth.theta[wall[mine]], truth.d[wall[mine]]
    )
    return Score(
        lines_true=truth.theta.size,
        lines_extracted=len(lines),
        lines_matched=mine.size,
        duplicates=duplicates,
        angle_errors=turn,
        distance_errors=shift,
        corner_nees=_corner_nees(features, truth, wall, matched),
        line_nees=_squared_mahalanobis(np.stack([turn, shift], axis=1), lines.covariance[mine]),
    )


def _corner_nees(features: Features, truth: Truth, wall: IntArray, matched: IntArray) -> FloatArray:
    corners = features.corners
    wall = np.append(wall, -1)  # of a corner without lines, whose lines are -1
    number = np.full((truth.theta.size + 1,) * 2, -1)
    i, j = truth.pairs.T
    number[i, j] = number[j, i] = np.arange(len(truth.corners))
    crossing = number[wall[corners.lines[:, 0]], wall[corners.lines[:, 1]]]
    mine = np.where(corners.lines[:, 0] < 0, matched, crossing)
    known = mine >= 0
    error = corners.positions[known] - truth.corners[mine[known]]
    return _squared_mahalanobis(error, corners.covariance[known])


def _squared_mahalanobis(error: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return error' covariance^-1 error of each, (M,); inf where the covariance is not valid."""
    (a, b), (_, c) = covariance.transpose(1, 2, 0)
    x, y = error.T
    det = a * c - b * b
    with np.errstate(invalid="ignore", divide="ignore"):
        distance = (c * x * x - 2 * b * x * y + a * y * y) / det
        valid = np.isfinite(distance) & (det > 0) & (a > 0)
    return np.where(valid, distance, math.inf)


def _share(part: int, whole: int) -> float:
    return part / whole if whole else math.nan
