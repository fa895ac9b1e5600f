"""Scans of rooms with false beams, their truth, and the corners that a person sees in them."""

import math
from itertools import pairwise

import numpy as np

from laserfeatures import LaserScan, Pose2D
from laserfeatures.evaluation import Truth, truth_of
from laserfeatures.evaluation.truth import MIN_BEAMS, in_sensor_frame
from laserfeatures.simulation import Observation, Scanner, World


def sense(world: World, scanner: Scanner, pose: Pose2D, rng, *, outliers=0.0, isolated=False):
    """Return a noisy scan and its truth; `outliers` is the share of beams that show nothing true.

    They fall anywhere, or if `isolated`, exactly that share is spread so that no two are
    neighbours.
    """
    seen = scanner.observe(world, pose, rng)
    ranges = seen.scan.ranges.copy()
    if isolated:
        false = _apart(rng, scanner.beams, round(outliers * scanner.beams))
    else:
        false = rng.random(scanner.beams) < outliers
    ranges[false] = rng.uniform(0.3, scanner.range_max, false.sum())
    ranges.flags.writeable = False
    scan = LaserScan(angles=scanner.angles, ranges=ranges, range_max=scanner.range_max)
    surface = np.where(false | ~scan.valid, -1, seen.surface)
    return scan, truth_of(Observation(scan=scan, world=world, pose=pose, surface=surface))


def junctions(world: World, scanner: Scanner, pose: Pose2D):
    """Return the ends of walls where the scan goes from one wall over to the next, (J, 2).

    Both walls must have four beams; these are the corners that a person sees in the scan.
    """
    _, wall = scanner.cast(world, pose)
    ends = in_sensor_frame(world.sides, pose)
    seen = []
    for a, b in {(int(a), int(b)) for a, b in pairwise(wall) if a != b}:
        if min(a, b) < 0 or min((wall == a).sum(), (wall == b).sum()) < MIN_BEAMS:
            continue
        shared = [p for p in ends[a] for q in ends[b] if np.allclose(p, q)]
        seen += shared
    return np.array(seen).reshape(-1, 2)


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
        x, y = points[truth.line == k].T
        weight = (x**2 + y**2) / (x * c + y * s) ** 2 / noise**2
        along = y * c - x * s
        jacobian = np.stack([along, -np.ones_like(along)], axis=1)
        found.append(np.sqrt(np.diag(np.linalg.inv((jacobian.T * weight) @ jacobian))))
    return np.array(found).reshape(-1, 2)


def _apart(rng, beams, count):
    """Return which beams are chosen: `count` of them, no two neighbours, all choices as likely."""
    gaps_left = np.sort(rng.choice(beams - count + 1, count, replace=False))
    chosen = np.zeros(beams, bool)
    chosen[gaps_left + np.arange(count)] = True
    return chosen
