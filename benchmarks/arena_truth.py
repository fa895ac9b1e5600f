"""Where the scanner stood in the 2 m arena, from the raw points alone, and which corners it saw.

No extractor takes part. A scan's pose is the one whose points lie best on the square: the least sum
of distances to the nearest side, cut at 0.1 m, over positions within 8 cm of the reference and all
headings (after the first scan, those within 39 degrees of the scan before: the square looks the
same from four sides), then refined by least squares with a Cauchy loss of 5 cm, then of 1 cm. The
side of the square, and a scale of the beam angles, are what fits best where a scan sees all sides.
"""

import gzip
import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from laserfeatures import LaserScan, Pose2D

NOMINAL = 2.0  # [m], side of the square as the data's author gives it
MOUNTED = 0.03  # [m], scanner ahead of the axle, whose position the reference gives
TRUNCATION = 0.1  # [m]
LOSS_SCALES = (0.05, 0.01)  # [m], of the Cauchy loss, one after the other
LEASH = 0.2  # [m], from the reference; a square turned by a quarter is farther off
HEADINGS = np.arange(0, 2 * math.pi, math.radians(3))  # of the first scan
NEXT = np.radians(np.arange(-39, 40, 3))  # from one scan to the next, 0.2 s later
OFFSETS = [(x, y) for x in (-0.08, 0.0, 0.08) for y in (-0.08, 0.0, 0.08)]
NEAR_CORNER = 0.3  # [m] along each wall
ON_WALL = 0.06  # [m]
NEAR_POLE = 0.15  # [m], from a pole's centre


@dataclass(frozen=True)
class Sight:
    """A scan of the arena, the square, the pose in it, and its corners in the scanner's frame."""

    scan: LaserScan
    side: float  # of the square [m]
    pose: Pose2D
    residual: float  # median distance of the points on walls from their wall [m]
    corners: np.ndarray  # (4, 2) [m]
    visible: np.ndarray  # (4,) bool


def first_poses(scans, reference_file):
    """Return the pose of each scan in a square of 2 m."""
    reference = numbers(reference_file, b"P")
    headings = HEADINGS
    poses = []
    for number, scan in enumerate(scans):
        pose, reached = _search(scan, reference, headings)
        off = math.dist((pose.x, pose.y), reached)
        if off > LEASH:
            raise ValueError(f"scan {number} fits the square {off:.2f} m off the reference")
        poses.append(pose)
        headings = pose.theta + NEXT
    return poses


def calibrate(scans, poses):
    """Return side [m] of the square as recorded, side with beam angles scaled, and that scale.

    Medians over the scans that see all four sides, and how many these are.
    """
    fits = []
    for scan, pose in zip(scans, poses, strict=True):
        if _sees_all_sides(scan, pose):
            start = [pose.x, pose.y, pose.theta, NOMINAL]
            fits.append([_refine(scan, start)[3], *_refine(scan, [*start, 1.0])[3:]])
    return np.median(fits, axis=0), np.percentile(fits, (10, 90), axis=0), len(fits)


def scaled(scan, scale):
    """Return a scan with its angles multiplied by `scale`."""
    return LaserScan(
        angles=scan.angles * scale,
        ranges=scan.ranges,
        range_min=scan.range_min,
        range_max=scan.range_max,
        stamp=scan.stamp,
    )


def sights(scans, poses, side):
    """Return the sight of each scan in a square of that side [m]; `poses` are first guesses."""
    return [_sight(scan, pose, side) for scan, pose in zip(scans, poses, strict=True)]


def share_on_poles(seen, side, landmarks_file):
    """Return the share of the points inside the square that lie at a known pole.

    The poles had no part in the fit: wrong poses, or a square turned by a quarter, would miss them.
    """
    poles = numbers(landmarks_file, b"L")[:, :2] / 1000 + (side - NOMINAL) / 2
    hits = total = 0
    for sight in seen:
        points = sight.pose.transform(sight.scan.points)
        inside = points[to_nearest_side(points, side) > 0.05]
        away = np.hypot(*(inside[:, None] - poles).transpose(2, 0, 1)).min(axis=1)
        hits += int((away < NEAR_POLE).sum())
        total += len(inside)
    return hits / total


def to_nearest_side(points, side):
    """Return the distance of points in the square's frame from its nearest side [m]."""
    return abs(np.concatenate([points, points - side], axis=1)).min(axis=1)


def numbers(path, word):
    """Return the numbers of the lines of a gzip file that start with `word`."""
    with gzip.open(path) as lines:
        rows = [line.split()[1:] for line in lines if line.startswith(word)]
    return np.array([[float(cell) for cell in row if cell != b"C"] for row in rows])


def _search(scan, reference, headings):
    """Return the best pose over `headings` near the reference, and the reference position."""
    time = scan.stamp * 1000
    axle = np.array([np.interp(time, reference[:, 0], reference[:, k]) for k in (1, 2)]) / 1000
    points = scan.points[::4]
    best, least = Pose2D(*axle, 0.0), math.inf
    for heading in headings:
        at = axle + MOUNTED * np.array([math.cos(heading), math.sin(heading)])
        for offset in OFFSETS:
            pose = Pose2D(*(at + offset), heading)
            gaps = to_nearest_side(pose.transform(points), NOMINAL)
            cost = np.minimum(gaps, TRUNCATION).sum()
            if cost < least:
                best, least, reached = pose, cost, at
    return Pose2D(*_refine(scan, [best.x, best.y, best.theta])), reached


def _refine(scan, start, side=NOMINAL):
    """Return x, y, heading and, if `start` has them, side and scale of angles that fit best."""
    ranges, angles = scan.ranges[scan.valid], scan.angles[scan.valid]

    def residuals(p):
        turned = p[2] + angles * (p[4] if len(p) > 4 else 1.0)
        points = np.stack([p[0] + ranges * np.cos(turned), p[1] + ranges * np.sin(turned)], axis=1)
        return to_nearest_side(points, p[3] if len(p) > 3 else side)

    for scale in LOSS_SCALES:
        start = least_squares(residuals, start, loss="cauchy", f_scale=scale).x
    return start


def _sees_all_sides(scan, pose):
    points = pose.transform(scan.points)
    gaps = abs(np.concatenate([points, points - NOMINAL], axis=1))
    return (gaps < 0.05).sum(axis=0).min() >= 20


def _sight(scan, pose, side):
    pose = Pose2D(*_refine(scan, [pose.x, pose.y, pose.theta], side))
    square = side * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    points = pose.transform(scan.points)
    gaps = to_nearest_side(points, side)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    corners = (square - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    visible = np.array([_visible(points, corner) for corner in square])
    return Sight(scan, side, pose, float(np.median(gaps[gaps < 0.05])), corners, visible)


def _visible(points, corner):
    """Tell whether beams return from both walls of a corner, right up to it.

    On each wall, at least four points lie within 6 cm of it and 0.3 m of the corner, the nearest
    of them within 0.1 m: no pole stands before it, and the field of view does not end there.
    """
    away = abs(points - corner)
    for along, off in ((0, 1), (1, 0)):
        near = away[(away[:, off] < ON_WALL) & (away[:, along] < NEAR_CORNER), along]
        if near.size < 4 or near.min() > 0.1:
            return False
    return True
