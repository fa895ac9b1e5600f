"""Where the scanner stood in the 2 m arena, from the raw points alone, and which corners it saw.

No extractor takes part. The pose of each scan is the one whose points lie best on a square: the
least sum of distances to the nearest side, cut at 0.1 m, over x, y and heading from the reference
position (10 cm) and all headings, then refined with a Cauchy loss (scale 1 cm). The side of the
square is the one that fits best over all scans.
"""

import gzip
import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from laserfeatures.data import LaserScan, Pose2D

NOMINAL = 2.0  # [m], side of the square as the data's author gives it
MOUNTED = 0.03  # [m], scanner ahead of the axle, which the reference gives
TRUNCATION = 0.1  # [m]
LOSS_SCALE = 0.01  # [m]
LEASH = 0.2  # [m], from the reference, beyond which a pose is another quarter turn of the square
HEADINGS = np.arange(0, 2 * math.pi, math.radians(3))
NEAR_CORNER = 0.3  # [m] along each wall
ON_WALL = 0.03  # [m]
POLE_RADIUS = 0.055 / 2  # [m]


@dataclass(frozen=True)
class Sight:
    """A scan of the arena: its pose in the square, and the four corners in the scanner's frame."""

    scan: LaserScan
    pose: Pose2D
    residual: float  # median distance of the points on walls from their wall [m]
    corners: np.ndarray  # (4, 2) [m]
    visible: np.ndarray  # (4,) bool


def arena_sights(scans, reference_file):
    """Return the side of the square [m] and the sight of each scan."""
    reference = _read_numbers(reference_file, b"P")
    guesses = [_guess(scan, reference) for scan in scans]
    side, _ = rectangle(scans, guesses)
    return side, [_sight(scan, guess, side) for scan, guess in zip(scans, guesses, strict=True)]


def rectangle(scans, guesses):
    """Return the side of the square, and width and height if they may differ [m], over all scans.

    The poses are fitted with each; the figures are medians over scans that see all four sides.
    """
    sides, pairs = [], []
    for scan, guess in zip(scans, guesses, strict=True):
        start = [guess.x, guess.y, guess.theta]
        if not _sees_all_sides(scan, guess):
            continue
        sides.append(_refine(scan, [*start, NOMINAL])[3])
        pairs.append(_refine(scan, [*start, NOMINAL, NOMINAL])[3:])
    return float(np.median(sides)), np.median(pairs, axis=0)


def on_poles(sights, landmarks_file):
    """Return the share of the points off the walls that lie on a known pole, within 3 cm.

    The poles had no part in the fit: a wrong pose, or a square turned by a quarter, would miss them.
    """
    poles = _read_numbers(landmarks_file, b"L")[:, 1:3] / 1000
    hits = total = 0
    for sight in sights:
        points = sight.pose.transform(sight.scan.points)
        side = np.ptp(sight.pose.transform(sight.corners)[:, 0])
        margin = (side - NOMINAL) / 2
        inside = _to_nearest_side(points, side, side) > 0.05
        away = np.hypot(*(points[inside, None] - poles - margin).transpose(2, 0, 1)).min(axis=1)
        hits += int((abs(away - POLE_RADIUS) < ON_WALL).sum())
        total += int(inside.sum())
    return hits / total


def _read_numbers(path, word):
    with gzip.open(path) as lines:
        rows = [line.split()[1:] for line in lines if line.startswith(word)]
    return np.array([[float(cell) for cell in row if cell != b"C"] for row in rows]).reshape(
        len(rows), -1
    )


def _guess(scan, reference):
    """Return the best pose over all headings, with the scanner near the reference position."""
    time = scan.stamp * 1000
    at = np.array([np.interp(time, reference[:, 0], reference[:, k]) for k in (1, 2)]) / 1000
    points = scan.points[::4]
    offsets = np.stack(np.meshgrid([-0.08, 0, 0.08], [-0.08, 0, 0.08]), axis=-1).reshape(-1, 2)
    best, least = None, math.inf
    for heading in HEADINGS:
        ahead = MOUNTED * np.array([math.cos(heading), math.sin(heading)])
        for offset in offsets:
            pose = Pose2D(*(at + ahead + offset), heading)
            gaps = np.minimum(_to_nearest_side(pose.transform(points), NOMINAL, NOMINAL), TRUNCATION)
            if gaps.sum() < least:
                best, least = pose, gaps.sum()
    fitted = _refine(scan, [best.x, best.y, best.theta])
    ahead = MOUNTED * np.array([math.cos(fitted[2]), math.sin(fitted[2])])
    if math.dist(fitted[:2], at + ahead) > LEASH:
        raise ValueError(f"the pose at {time:.0f} ms is {math.dist(fitted[:2], at):.2f} m off")
    return Pose2D(*fitted)


def _refine(scan, start):
    """Return x, y, heading, and width and height if `start` has them, that fit the points best."""

    def residuals(p):
        width, height = (p[3], p[-1]) if len(p) > 3 else (side, side)
        return _to_nearest_side(Pose2D(*p[:3]).transform(scan.points), width, height)

    side = NOMINAL
    return least_squares(residuals, start, loss="cauchy", f_scale=LOSS_SCALE).x


def _to_nearest_side(points, width, height):
    x, y = points.T
    return np.min([abs(x), abs(y), abs(width - x), abs(height - y)], axis=0)


def _sees_all_sides(scan, pose):
    x, y = pose.transform(scan.points).T
    counts = [(abs(x) < 0.05).sum(), (abs(x - NOMINAL) < 0.05).sum()]
    counts += [(abs(y) < 0.05).sum(), (abs(y - NOMINAL) < 0.05).sum()]
    return min(counts) >= 20


def _sight(scan, guess, side):
    def residuals(p):
        return _to_nearest_side(Pose2D(*p).transform(scan.points), side, side)

    start = [guess.x, guess.y, guess.theta]
    pose = Pose2D(*least_squares(residuals, start, loss="cauchy", f_scale=LOSS_SCALE).x)
    square = side * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    points = pose.transform(scan.points)
    gaps = _to_nearest_side(points, side, side)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    corners = (square - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    visible = np.array([_visible(points, corner) for corner in square])
    return Sight(scan, pose, float(np.median(gaps[gaps < 0.05])), corners, visible)


def _visible(points, corner):
    """Tell whether beams return from both walls of a corner, right up to it.

    On each wall, at least four points lie within 3 cm of it and 0.3 m of the corner, the nearest
    of them within 0.1 m: no pole stands before it, and the field of view does not end there.
    """
    away = abs(points - corner)
    for along, off in ((0, 1), (1, 0)):
        near = away[(away[:, off] < ON_WALL) & (away[:, along] < NEAR_CORNER), along]
        if near.size < 4 or near.min() > 0.1:
            return False
    return True
