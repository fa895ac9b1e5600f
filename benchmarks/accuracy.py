"""The report's section on accuracy: lines and corners of simulated rooms against the truth."""

import math
from dataclasses import dataclass, field

import numpy as np
import truth as truths
from page import percent, table
from rooms import random_room
from scipy.optimize import linear_sum_assignment

import laserfeatures as lf
from laserfeatures.simulation import Scanner

SEEDS = range(10_000, 10_400)
GATE = 0.2  # [m], of a corner from the true one
ELLIPSE = -2 * math.log(0.05)  # squared Mahalanobis distance within which 95 % lie


@dataclass(frozen=True)
class Scene:
    """A sensor, the size of the rooms and the share of false beams."""

    name: str
    scanner: Scanner
    scale: float = 1.0
    outliers: float = 0.0


SICK = Scanner(beams=181, field_of_view=math.pi, range_max=10.0, range_sigma=0.005)
FAR = Scanner(beams=361, field_of_view=math.pi, range_max=20.0, range_sigma=0.010)
SCENES = [
    Scene("181 beams, 10 m, 5 mm", SICK),
    Scene("361 beams, 20 m, 10 mm, rooms twice as large", FAR, scale=2.0),
    Scene("181 beams, 10 m, 5 mm, 20 % false beams", SICK, outliers=0.2),
]

METHOD = f"""{len(SEEDS)} random rooms (`benchmarks/rooms.py`, seeds {SEEDS[0]} to {SEEDS[-1]}; no
parameter was tuned on them): rectangles of 3 to 9 m with niches, pillars, corridors, a cut corner
and up to three boxes turned anyhow. True lines are the walls that at least four beams hit,
collinear ones merged; true corners are where two cross at 15° or more within 20 m of the sensor,
however far from the points. The oracle knows which beams hit which wall and fits each by least
squares (total, unweighted); its corners are all crossings of its lines. A false beam returns from
anywhere between 0.3 m and the sensor's range.

A line found is a wall's where at least half of its points are beams of that wall, one line a
wall; a corner found is a true one where both are paired within {GATE} m (least total distance).
F1 counts both found and missed. `preset="paper"` is raw bins: theta and d are centres of the
accumulator's cells."""

CONSISTENCY = """Covariances: share of the corners (of pairs of lines that are walls', however far
off) and of the lines that lie within their own 95 % ellipse, `range_sigma` given or estimated."""


@dataclass
class Score:
    """What was found in all scans of a scene."""

    hits: int = 0
    found: int = 0
    true: int = 0
    corner_errors: list = field(default_factory=list)
    line_hits: int = 0
    line_found: int = 0
    line_true: int = 0
    turns: list = field(default_factory=list)
    shifts: list = field(default_factory=list)
    corner_inside: list = field(default_factory=list)
    line_inside: list = field(default_factory=list)

    def add_corners(self, positions, true):
        """Pair corners with the true ones."""
        gaps = np.hypot(*(positions[:, None] - true[None]).transpose(2, 0, 1))
        rows, columns = linear_sum_assignment(np.where(gaps < GATE, gaps, 1e3))
        paired = gaps[rows, columns]
        paired = paired[paired < GATE]
        self.hits += paired.size
        self.found += len(positions)
        self.true += len(true)
        self.corner_errors += paired.tolist()

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


def section(options):
    """Return the section's paragraphs."""
    seeds = SEEDS[: options.repeats(len(SEEDS))]
    extractors = {
        "direct_hough": lf.get_extractor("direct_hough"),
        "preset paper": lf.get_extractor("direct_hough", preset="paper"),
    }
    paragraphs, consistency = [], []
    for scene in SCENES:
        given = lf.get_extractor("direct_hough", range_sigma=scene.scanner.range_sigma)
        scores = _scores(scene, seeds, {**extractors, "direct_hough, range_sigma given": given})
        paragraphs += [f"### {scene.name}", *_tables(scores)]
        consistency += [
            [f"{scene.name}: {name}", *_inside(scores[name])]
            for name in ("direct_hough, range_sigma given", "direct_hough")
        ]
    header = ["", "corners inside", "of", "lines inside", "of"]
    return ["## Accuracy in simulated rooms", METHOD, *paragraphs, CONSISTENCY,
            table(header, consistency)]  # fmt: skip


def _scores(scene, seeds, extractors):
    scores = {name: Score() for name in [*extractors, "oracle"]}
    for seed in seeds:
        world, pose = random_room(seed, scale=scene.scale)
        rng = np.random.default_rng((seed, 1))
        scan, truth = truths.sense(world, scene.scanner, pose, rng, outliers=scene.outliers)
        true = truths.corners(truth.crossings)
        theta, d = truths.oracle(scan, truth)
        scores["oracle"].add_lines(theta, d, np.arange(theta.size), truth)
        scores["oracle"].add_corners(truths.corners(truths.cross_all(theta, d)), true)
        for name, extractor in extractors.items():
            _add(scores[name], extractor(scan), truth, true)
    return scores


def _add(score, features, truth, true):
    wall = walls_of(features, truth)
    score.add_lines(features.lines.theta, features.lines.d, wall, truth)
    score.add_corners(features.corners.positions, true)
    _check_lines(score, features.lines, wall, truth)
    _check_corners(score, features.corners, wall, truth)


def walls_of(features, truth):
    """Return the number of each line's wall, (L,) int; -1 where it is none's."""
    lines, segments = features.lines, features.segments
    members = np.zeros((len(lines), len(features.scan)), dtype=int)
    np.logical_or.at(members, segments.line, segments.points)
    on_wall = truth.beams[None, :] == np.arange(truth.theta.size)[:, None]
    shared = members @ on_wall.T
    wall = np.full(len(lines), -1)
    for line, number in zip(*linear_sum_assignment(shared, maximize=True), strict=True):
        if 2 * shared[line, number] >= members[line].sum():
            wall[line] = number
    return wall


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


def _mahalanobis(error, covariance):
    if not (np.isfinite(covariance).all() and np.linalg.det(covariance) > 0):
        return math.inf
    return float(error @ np.linalg.solve(covariance, error))


def _tables(scores):
    corners, lines = [], []
    for name, score in scores.items():
        errors = 1e3 * np.array(score.corner_errors)
        corners.append([
            name, f"{2 * score.hits / (score.found + score.true):.3f}",
            f"{score.hits / max(score.found, 1):.3f}", f"{score.hits / score.true:.3f}",
            f"{np.median(errors):.1f}", f"{math.sqrt(np.mean(errors**2)):.1f}",
        ])  # fmt: skip
        lines.append([
            name, f"{score.line_hits / max(score.line_found, 1):.3f}",
            f"{score.line_hits / score.line_true:.3f}",
            f"{math.degrees(np.median(score.turns)):.3f}", f"{1e3 * np.median(score.shifts):.1f}",
            f"{math.degrees(np.percentile(score.turns, 90)):.2f}",
            f"{1e3 * np.percentile(score.shifts, 90):.1f}",
        ])  # fmt: skip
    return [
        table(["corners", "F1", "precision", "recall", "median error [mm]", "rms [mm]"], corners),
        table(["lines", "precision", "recall", "angle error, median [°]", "distance, median [mm]",
               "angle, 90 % [°]", "distance, 90 % [mm]"], lines),
    ]  # fmt: skip


def _inside(score):
    return [
        percent(np.mean(score.corner_inside)), len(score.corner_inside),
        percent(np.mean(score.line_inside)), len(score.line_inside),
    ]  # fmt: skip
