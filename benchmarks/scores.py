"""Scores of what was found in simulated scans: lines and corners paired with the true ones."""

import math
from dataclasses import dataclass, field

import numpy as np
import truth as truths
from scipy.optimize import linear_sum_assignment

GATE = 0.2  # [m], of a corner from the true one
ELLIPSE = -2 * math.log(0.05)  # squared Mahalanobis distance within which 95 % lie


@dataclass
class Pairs:
    """Corners found, and true ones, paired."""

    hits: int = 0
    found: int = 0
    true: int = 0
    errors: list = field(default_factory=list)  # [m]

    def add(self, positions, true):
        """Pair the corners of a scan; return the numbers of those found and their true ones."""
        gaps = np.hypot(*(positions[:, None] - true[None]).transpose(2, 0, 1))
        rows, columns = linear_sum_assignment(np.where(gaps < GATE, gaps, 1e3))
        near = gaps[rows, columns] < GATE
        self.hits += int(near.sum())
        self.found += len(positions)
        self.true += len(true)
        self.errors += gaps[rows, columns][near].tolist()
        return rows[near], columns[near]

    @property
    def precision(self):
        """Share of those found that are true."""
        return self.hits / max(self.found, 1)

    @property
    def recall(self):
        """Share of the true ones that were found."""
        return self.hits / self.true

    @property
    def f1(self):
        """Harmonic mean of both."""
        return 2 * self.hits / (self.found + self.true)

    @property
    def median(self):
        """Median error [mm]."""
        return 1e3 * np.median(self.errors)

    @property
    def rms(self):
        """Root mean square error [mm]."""
        return 1e3 * math.sqrt(np.mean(np.square(self.errors)))


@dataclass
class Score:
    """What was found in all scans of a scene."""

    corners: Pairs = field(default_factory=Pairs)
    in_sight: Pairs = field(default_factory=Pairs)
    line_hits: int = 0
    line_found: int = 0
    line_true: int = 0
    repeats: int = 0
    turns: list = field(default_factory=list)
    shifts: list = field(default_factory=list)
    corner_inside: list = field(default_factory=list)
    line_inside: list = field(default_factory=list)

    def add_lines(self, theta, d, wall, truth):
        """Compare lines with their walls; `wall` is the number of each line's, or -1."""
        mine = wall >= 0
        turn, shift = truths.difference(
            theta[mine], d[mine], truth.theta[wall[mine]], truth.d[wall[mine]]
        )
        self.line_hits += int(mine.sum())
        self.line_found += len(wall)
        self.line_true += truth.theta.size
        self.turns += abs(turn).tolist()
        self.shifts += abs(shift).tolist()

    @property
    def precision(self):
        """Share of the lines that are walls."""
        return self.line_hits / max(self.line_found, 1)

    @property
    def recall(self):
        """Share of the walls that have a line."""
        return self.line_hits / self.line_true

    def add(self, features, truth, true, sights):
        """Score the features of a scan; `true` are its corners, `sights` those of them in sight."""
        wall, repeats = walls_of(features, truth)
        self.add_lines(features.lines.theta, features.lines.d, wall, truth)
        self.repeats += repeats
        corners = features.corners
        self.corners.add(corners.positions, true)
        seen = self.in_sight.add(corners.positions[corners.real], sights)
        _check_lines(self, features.lines, wall, truth)
        if len(features.lines):
            _check_corners(self, corners, wall, truth)
        else:
            _check_points(self, corners, seen, sights)


def walls_of(features, truth):
    """Return the number of each line's wall, (L,) int, -1 where it is none's, and the repeats.

    A repeat is a line on a wall that another line has.
    """
    lines, segments = features.lines, features.segments
    members = np.zeros((len(lines), len(features.scan)), dtype=int)
    np.logical_or.at(members, segments.line, segments.points)
    on_wall = truth.beams[None, :] == np.arange(truth.theta.size)[:, None]
    shared = members @ on_wall.T
    mostly = 2 * shared >= members.sum(axis=1)[:, None]
    wall = np.full(len(lines), -1)
    for line, number in zip(*linear_sum_assignment(shared, maximize=True), strict=True):
        if mostly[line, number]:
            wall[line] = number
    return wall, int((mostly.any(axis=1) & (wall < 0)).sum())


def _check_lines(score, lines, wall, truth):
    for k in np.flatnonzero(wall >= 0):
        turn, shift = truths.difference(
            lines.theta[k], lines.d[k], truth.theta[wall[k]], truth.d[wall[k]]
        )
        turned = abs(lines.theta[k] - truth.theta[wall[k]]) > math.pi / 2
        error = np.array([turn, -shift if turned else shift])  # as the line itself counts d
        score.line_inside.append(_mahalanobis(error, lines.covariance[k]) <= ELLIPSE)


def _check_corners(score, corners, wall, truth):
    for position, covariance, (a, b) in zip(
        corners.positions, corners.covariance, wall[corners.lines], strict=True
    ):
        if min(a, b) >= 0 and np.isfinite(truth.crossings[a, b]).all():
            error = position - truth.crossings[a, b]
            score.corner_inside.append(_mahalanobis(error, covariance) <= ELLIPSE)


def _check_points(score, corners, seen, sights):
    for own, other in zip(*seen, strict=True):  # all are real, so that the numbers are theirs
        error = corners.positions[own] - sights[other]
        score.corner_inside.append(_mahalanobis(error, corners.covariance[own]) <= ELLIPSE)


def _mahalanobis(error, covariance):
    if not (np.isfinite(covariance).all() and np.linalg.det(covariance) > 0):
        return math.inf
    return float(error @ np.linalg.solve(covariance, error))
