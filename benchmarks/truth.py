"""What is true of a simulated scan: its lines, the beams on each, the corners, and the oracle."""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from laserfeatures import LaserScan, Pose2D
from laserfeatures.simulation import Scanner, World

MIN_BEAMS = 4
MIN_ANGLE = math.radians(15)  # lines that cross at less have no corner
MAX_DISTANCE = 20.0  # [m], of a corner from the sensor


@dataclass(frozen=True)
class Truth:
    """The lines (theta, d) of a scan's walls, and the number of each beam's line, or -1."""

    theta: np.ndarray
    d: np.ndarray
    beams: np.ndarray

    @property
    def crossings(self):
        """Where the lines cross, (L, L, 2); nan where they do not."""
        return cross_all(self.theta, self.d)


def sense(world: World, scanner: Scanner, pose: Pose2D, rng, *, outliers=0.0, isolated=False):
    """Return a noisy scan and its truth; `outliers` is the share of beams that show nothing true.

    They fall anywhere, or if `isolated`, exactly that share is spread so that no two are
    neighbours. A wall with fewer than four true beams does not count; collinear walls are one line.
    """
    _, wall = scanner.cast(world, pose)
    scan = scanner.scan(world, pose, rng)
    ranges = scan.ranges.copy()
    if isolated:
        false = _apart(rng, scanner.beams, round(outliers * scanner.beams))
    else:
        false = rng.random(scanner.beams) < outliers
    ranges[false] = rng.uniform(0.3, scanner.range_max, false.sum())
    ranges.flags.writeable = False
    scan = LaserScan(angles=scan.angles, ranges=ranges, range_max=scanner.range_max)
    wall = np.where(false | ~scan.valid, -1, wall)
    theta, d, number = _merge_collinear(_walls_as_lines(world, pose))
    beams = np.where(wall >= 0, number[wall], -1)
    kept = [k for k in range(theta.size) if (beams == k).sum() >= MIN_BEAMS]
    renumber = np.full(theta.size + 1, -1)
    renumber[kept] = np.arange(len(kept))
    return scan, Truth(theta[kept], d[kept], renumber[beams])


def junctions(world: World, scanner: Scanner, pose: Pose2D):
    """Return the ends of walls where the scan goes from one wall over to the next, (J, 2).

    Both walls must have four beams; these are the corners that a person sees in the scan.
    """
    _, wall = scanner.cast(world, pose)
    ends = in_sensor_frame(world, pose)
    seen = []
    for a, b in {(int(a), int(b)) for a, b in pairwise(wall) if a != b}:
        if min(a, b) < 0 or min((wall == a).sum(), (wall == b).sum()) < MIN_BEAMS:
            continue
        shared = [p for p in ends[a] for q in ends[b] if np.allclose(p, q)]
        seen += shared
    return np.array(seen).reshape(-1, 2)


def oracle(scan: LaserScan, truth: Truth):
    """Return (theta, d) of the total-least-squares lines through exactly each wall's beams."""
    points = np.full((len(scan), 2), np.nan)
    points[scan.beams] = scan.points
    theta = np.empty(truth.theta.size)
    d = np.empty(truth.theta.size)
    for k in range(theta.size):
        mine = points[truth.beams == k]
        centre = mine.mean(axis=0)
        normal = np.linalg.svd(mine - centre)[2][1]
        theta[k], d[k] = normalised(math.atan2(normal[1], normal[0]), centre @ normal)
    return theta, d


def sigmas(scan: LaserScan, truth: Truth, noise: float):
    """Return the standard deviations of angle [rad] and distance [m] that range noise leaves.

    They are those of the best fit to each wall's beams: a range error moves a point off its wall by
    the cosine of the incidence angle.
    """
    points = np.full((len(scan), 2), np.nan)
    points[scan.beams] = scan.points
    found = []
    for k in range(truth.theta.size):
        c, s = math.cos(truth.theta[k]), math.sin(truth.theta[k])
        x, y = points[truth.beams == k].T
        weight = (x**2 + y**2) / (x * c + y * s) ** 2 / noise**2
        along = y * c - x * s
        jacobian = np.stack([along, -np.ones_like(along)], axis=1)
        found.append(np.sqrt(np.diag(np.linalg.inv((jacobian.T * weight) @ jacobian))))
    return np.array(found).reshape(-1, 2)


def normalised(theta: float, d: float):
    """Return a line with theta in [0, pi)."""
    turns = math.floor(theta / math.pi)
    theta -= turns * math.pi
    return (theta, -d) if turns % 2 else (theta, d)


def difference(theta, d, true_theta, true_d):
    """Return signed errors of angle [rad] and distance [m]; theta wraps, and d turns with it."""
    turn = np.asarray(theta) - true_theta
    wraps = np.round(turn / math.pi).astype(int)
    return turn - wraps * math.pi, np.where(wraps % 2, -1, 1) * np.asarray(d) - true_d


def cross_all(theta, d):
    """Return where each pair of lines crosses, (L, L, 2); nan where no corner counts."""
    c, s = np.cos(theta), np.sin(theta)
    det = np.outer(c, s) - np.outer(s, c)
    with np.errstate(divide="ignore", invalid="ignore"):
        x = (np.outer(d, s) - np.outer(s, d)) / det
        y = (np.outer(c, d) - np.outer(d, c)) / det
    points = np.stack([x, y], axis=2)
    with np.errstate(invalid="ignore"):
        none = (abs(det) < math.sin(MIN_ANGLE)) | ~(np.hypot(x, y) <= MAX_DISTANCE)
    points[none] = np.nan
    return points


def corners(crossings):
    """Return the crossings of different lines, each once, (K, 2)."""
    points = crossings[np.triu_indices(crossings.shape[0], 1)]
    return points[np.isfinite(points[:, 0])]


def _apart(rng, beams, count):
    """Return which beams are chosen: `count` of them, no two neighbours, all choices as likely."""
    gaps_left = np.sort(rng.choice(beams - count + 1, count, replace=False))
    chosen = np.zeros(beams, bool)
    chosen[gaps_left + np.arange(count)] = True
    return chosen


def in_sensor_frame(world: World, pose: Pose2D):
    """Return the ends of all walls as the sensor sees them, (W, 2, 2)."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    return (world.walls - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])


def _walls_as_lines(world: World, pose: Pose2D):
    for start, end in in_sensor_frame(world, pose):
        normal = math.atan2(end[0] - start[0], start[1] - end[1])
        yield normalised(normal, start[0] * math.cos(normal) + start[1] * math.sin(normal))


def _merge_collinear(lines):
    theta, d, number = [], [], []
    for line in lines:
        turn, shift = difference(np.array(theta), np.array(d), *line)
        same = np.flatnonzero((abs(turn) < 1e-6) & (abs(shift) < 1e-6))
        if not same.size:
            same = [len(theta)]
            theta.append(line[0])
            d.append(line[1])
        number.append(int(same[0]))
    return np.array(theta), np.array(d), np.array(number)
