"""Where the scanner stood in Brenner's 2 m arena, from the raw points alone, and what it saw.

No extractor takes part. A scan's pose is the one whose points lie best on the square: the least sum
of distances to the nearest side, cut at 0.1 m, over positions within 8 cm of the reference and all
headings (after the first scan, those within 39 degrees of the scan before: the square looks the
same from four sides), then refined by least squares with a Cauchy loss of 5 cm, then of 1 cm. The
side of the square, and a scale of the beam angles, are what fits best where a scan sees all sides.
"""

import gzip
import math
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.evaluation import Truth
from laserfeatures.evaluation.true_lines import cross, lines_through
from laserfeatures.optional import optional
from laserfeatures.testbench.real.view import View

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
ENDS = ((0, 3), (0, 1), (1, 2), (3, 2))  # corners of each side: x = 0, y = 0, x = side, y = side
MIN_BEAMS = 4  # on a side that is a true line
REFERENCE, LANDMARKS = "robot4_reference.txt.gz", "robot_arena_landmarks.txt.gz"


@dataclass(frozen=True, eq=False)
class Sight:
    """A scan of the arena and what it shows.

    Parameters
    ----------
    scan : LaserScan
        The scan.
    side : float
        Side of the square [m].
    pose : Pose2D
        Where in the square it was taken.
    residual : float
        Median distance of the points on walls from their wall [m].
    corners : (4, 2) array
        The corners of the square in the scanner's frame [m].
    visible : (4,) bool array
        Which of them the scan shows.
    """

    scan: LaserScan
    side: float
    pose: Pose2D
    residual: float
    corners: FloatArray
    visible: BoolArray


def first_poses(scans: Iterable[LaserScan], reference_file: Path) -> list[Pose2D]:
    """Return the pose of each scan in a square of 2 m.

    Raises
    ------
    SourceError
        If the reference cannot be read, or a scan does not fit the square near it.
    MissingDependencyError
        If SciPy is missing.
    """
    reference = numbers(reference_file, b"P")
    headings = HEADINGS
    poses = []
    for number, scan in enumerate(scans):
        pose, reached = _search(scan, reference, headings)
        off = math.dist((pose.x, pose.y), reached)
        if off > LEASH:
            raise SourceError(
                f"{reference_file}: expected scan {number} to fit the square within {LEASH} m of "
                f"the reference, got {off:.2f} m; scans and reference must be of one drive"
            )
        poses.append(pose)
        headings = pose.theta + NEXT
    return poses


def calibrate(
    scans: Iterable[LaserScan], poses: Iterable[Pose2D]
) -> tuple[FloatArray, FloatArray, int]:
    """Return side [m] of the square as recorded, side with beam angles scaled, and that scale.

    Medians over the scans that see all four sides, their 10th and 90th percentiles, and how many
    such scans there are.
    """
    fits = []
    for scan, pose in zip(scans, poses, strict=True):
        if _sees_all_sides(scan, pose):
            start = [pose.x, pose.y, pose.theta, NOMINAL]
            fits.append([_refine(scan, start)[3], *_refine(scan, [*start, 1.0])[3:]])
    return np.median(fits, axis=0), np.percentile(fits, (10, 90), axis=0), len(fits)


def scaled(scan: LaserScan, scale: float) -> LaserScan:
    """Return a scan with its angles multiplied by `scale`."""
    return replace(scan, angles=scan.angles * scale)


def sights(scans: Iterable[LaserScan], poses: Iterable[Pose2D], side: float) -> list[Sight]:
    """Return the sight of each scan in a square of that side [m]; `poses` are first guesses."""
    return [_sight(scan, pose, side) for scan, pose in zip(scans, poses, strict=True)]


def views(folder: Path, scans: Sequence[LaserScan]) -> list[View]:
    """Return the scans of the arena with their true lines and corners.

    The lines are the sides of the square, as large as fits best, that at least four beams measure:
    points nearer than 6 cm. The corners are where two of them cross, real if visible. All else in
    the arena is poles, so that all that is found can be judged.

    Parameters
    ----------
    folder : Path
        Where the scans and their reference are.
    scans : sequence of LaserScan
        Its scans, in order.

    Raises
    ------
    SourceError
        If the reference cannot be read, or does not fit.
    MissingDependencyError
        If SciPy is missing.
    """
    poses = first_poses(scans, folder / REFERENCE)
    side = float(calibrate(scans, poses)[0][0])
    return [_view(sight) for sight in sights(scans, poses, side)]


def share_on_poles(seen: Iterable[Sight], side: float, landmarks_file: Path) -> float:
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


def to_nearest_side(points: FloatArray, side: float) -> FloatArray:
    """Return the distance of points in the square's frame from its nearest side [m]."""
    nearest: FloatArray = _to_sides(points, side).min(axis=1)
    return nearest


def numbers(path: Path, word: bytes) -> FloatArray:
    """Return the numbers of the lines of a gzip file that start with `word`.

    Raises
    ------
    SourceError
        If the file cannot be read, or has no such lines.
    """
    try:
        with gzip.open(path) as lines:
            rows = [line.split()[1:] for line in lines if line.startswith(word)]
        table = np.array([[float(cell) for cell in row if cell != b"C"] for row in rows])
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise SourceError(
            f"{path}: expected gzipped lines of numbers after {word.decode()!r}, got: {error}"
        ) from error
    if not table.size:
        raise SourceError(f"{path}: expected lines that start with {word.decode()!r}, got none")
    return table


def _search(
    scan: LaserScan, reference: FloatArray, headings: FloatArray
) -> tuple[Pose2D, FloatArray]:
    """Return the best pose over `headings` near the reference, and the reference position."""
    time = scan.stamp * 1000
    axle = np.array([np.interp(time, reference[:, 0], reference[:, k]) for k in (1, 2)]) / 1000
    points = scan.points[::4]
    best, least, reached = Pose2D(float(axle[0]), float(axle[1]), 0.0), math.inf, axle
    for heading in headings:
        at = axle + MOUNTED * np.array([math.cos(heading), math.sin(heading)])
        for offset in OFFSETS:
            x, y = (at + offset).tolist()
            pose = Pose2D(x, y, float(heading))
            gaps = to_nearest_side(pose.transform(points), NOMINAL)
            cost = np.minimum(gaps, TRUNCATION).sum()
            if cost < least:
                best, least, reached = pose, cost, at
    return Pose2D(*_refine(scan, [best.x, best.y, best.theta])), reached


def _refine(scan: LaserScan, start: Sequence[float], side: float = NOMINAL) -> list[float]:
    """Return x, y, heading and, if `start` has them, side and scale of angles that fit best."""
    ranges, angles = scan.ranges[scan.valid], scan.angles[scan.valid]

    def residuals(p: FloatArray) -> FloatArray:
        turned = p[2] + angles * (p[4] if len(p) > 4 else 1.0)
        points = np.stack([p[0] + ranges * np.cos(turned), p[1] + ranges * np.sin(turned)], axis=1)
        return to_nearest_side(points, p[3] if len(p) > 3 else side)

    optimize = optional("scipy.optimize", "the truth of real scans needs SciPy", "evaluation")
    for scale in LOSS_SCALES:
        start = optimize.least_squares(residuals, start, loss="cauchy", f_scale=scale).x.tolist()
    return list(start)


def _sees_all_sides(scan: LaserScan, pose: Pose2D) -> bool:
    gaps = _to_sides(pose.transform(scan.points), NOMINAL)
    return bool((gaps < 0.05).sum(axis=0).min() >= 20)


def _to_sides(points: FloatArray, side: float) -> FloatArray:
    """Return the distances of points from the sides x = 0, y = 0, x = side, y = side, (P, 4)."""
    distances: FloatArray = abs(np.concatenate([points, points - side], axis=1))
    return distances


def _sight(scan: LaserScan, pose: Pose2D, side: float) -> Sight:
    pose = Pose2D(*_refine(scan, [pose.x, pose.y, pose.theta], side))
    square = side * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    points = pose.transform(scan.points)
    gaps = to_nearest_side(points, side)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    corners = (square - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    visible = np.array([_visible(points, corner) for corner in square])
    return Sight(scan, side, pose, float(np.median(gaps[gaps < 0.05])), corners, visible)


def _view(sight: Sight) -> View:
    """Return what is true of a sight; side k lies between the corners `ENDS[k]`."""
    gaps = _to_sides(sight.pose.transform(sight.scan.points), sight.side)
    nearest = np.where(gaps.min(axis=1) < ON_WALL, gaps.argmin(axis=1), -1)
    kept = np.flatnonzero(np.bincount(nearest[nearest >= 0], minlength=4) >= MIN_BEAMS)
    number = np.full(5, -1)
    number[kept] = np.arange(kept.size)
    line = np.full(len(sight.scan), -1)
    line[sight.scan.beams] = number[nearest]
    theta, d = lines_through(sight.corners[np.array(ENDS)[kept]])
    corners, pairs = cross(theta, d)
    which = [np.hypot(*(sight.corners - corner).T).argmin() for corner in corners]
    return View(
        scan=sight.scan,
        truth=Truth(
            theta=theta, d=d, line=line, corners=corners, pairs=pairs, real=sight.visible[which]
        ),
        known=sight.scan.valid,
        unsure=np.empty((0, 2), np.int64),
    )


def _visible(points: FloatArray, corner: FloatArray) -> bool:
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
