"""Small scenes whose truth is known, seen from a sensor at the origin."""

import math
import os
from itertools import pairwise

import numpy as np
import pytest

from laserfeatures import LaserScan, Lines, LineSegments, Pose2D
from laserfeatures.simulation import Scanner, World

ORIGIN = Pose2D(0.0, 0.0, 0.0)
TURN = 2 * math.pi
needs_compiler = pytest.mark.skipif(
    os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="takes minutes without the compiler"
)


def wall(theta: float, d: float, low: float, high: float) -> list[tuple[float, float]]:
    """Return the wall on the line (theta, d) from `low` to `high` along it."""
    c, s = math.cos(theta), math.sin(theta)
    return [(d * c - t * s, d * s + t * c) for t in (low, high)]


def chain(*points):
    """Return the walls that join successive points."""
    return [list(pair) for pair in pairwise(points)]


def look(walls, *, sigma=0.0, seed=0, beams=361, view=math.pi, range_max=30.0, pose=ORIGIN):
    """Return a scan of some walls and the number of the wall that each beam truly hits, or -1."""
    world = walls if isinstance(walls, World) else World(walls=walls)
    scanner = Scanner(beams=beams, field_of_view=view, range_max=range_max, range_sigma=sigma)
    scan = scanner.scan(world, pose, np.random.default_rng(seed))
    hit = scanner.cast(world, pose)[1]
    return scan, np.where(scan.valid, hit, -1)


def scan_of(*walls, **view) -> LaserScan:
    """Return a scan of some walls; the keywords are those of `look`."""
    return look(list(walls), **view)[0]


def niche_scan(rng):
    """Return a scan of a wall with a niche, a door and false returns, and its walls' lines."""
    lines = chain((2, -3), (2, -1), (2.3, -1), (2.3, 0), (2, 0), (2, 0.8))
    lines.append([(2, rng.uniform(0.9, 2)), (2, 3)])
    scan = scan_of(*lines, sigma=0.005, seed=int(rng.integers(10**6)), beams=181)
    ranges = scan.ranges.copy()
    false = rng.random(181) < 0.1
    ranges[false] = rng.uniform(0.5, 4, false.sum())
    return LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0), true_lines(lines)


def niche(rng):
    """Return points and beams of `niche_scan`, and the lines of its walls."""
    scan, lines = niche_scan(rng)
    return scan.points, scan.beams, lines


def poles(*centres, radius=0.1, beams=361, sigma=0.005, seed=0) -> LaserScan:
    """Return a scan of round objects in the open."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, beams)
    ranges = np.full(beams, np.inf)
    for x, y in centres:
        along = np.cos(angles) * x + np.sin(angles) * y
        across = np.cos(angles) * y - np.sin(angles) * x
        with np.errstate(invalid="ignore"):
            near = along - np.sqrt(radius**2 - across**2)
        ranges = np.fmin(ranges, np.where((along > 0) & (abs(across) < radius), near, np.inf))
    noise = np.random.default_rng(seed).normal(0.0, sigma, beams)
    return LaserScan(angles=angles, ranges=ranges + noise, range_max=30.0)


def true_lines(walls, pose=ORIGIN):
    """Return (theta, d) of the lines that carry some walls, in the sensor's frame, (L, 2)."""
    walls = np.asarray(walls.walls if isinstance(walls, World) else walls, dtype=float)
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    ends = (walls - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    step = ends[:, 1] - ends[:, 0]
    theta = np.arctan2(step[:, 0], -step[:, 1])
    d = ends[:, 0, 0] * np.cos(theta) + ends[:, 0, 1] * np.sin(theta)
    return normalised(theta, d)


def normalised(theta, d):
    """Return lines (L, 2) with theta in [0, pi)."""
    turns = np.floor(np.asarray(theta) / math.pi)
    return np.stack([theta - turns * math.pi, np.where(turns % 2, -1, 1) * d], axis=-1)


def line_errors(lines, truth):
    """Return signed errors (..., 2) of (theta, d); theta wraps, and d changes sign with it."""
    lines, truth = np.asarray(lines), np.asarray(truth)
    turn = lines[..., 0] - truth[..., 0]
    wraps = np.round(turn / math.pi)
    off = np.where(wraps % 2, -1, 1) * lines[..., 1] - truth[..., 1]
    return np.stack([turn - wraps * math.pi, off], axis=-1)


def found_lines(features):
    """Return (theta, d) of the lines found, (L, 2)."""
    return np.stack([features.lines.theta, features.lines.d], axis=1)


def nearest_line(lines, truth, theta_tolerance, d_tolerance):
    """Return the index of the one line within tolerance of `truth`, and that there is just one."""
    errors = abs(line_errors(lines, truth))
    return np.flatnonzero((errors[:, 0] < theta_tolerance) & (errors[:, 1] < d_tolerance))


def random_room(rng):
    """Return a room with one cut corner and a pillar, and a pose in it."""
    width, depth = rng.uniform(4.0, 8.0), rng.uniform(3.5, 6.0)
    cut = rng.uniform(0.7, 1.2)
    room = [(0, 0), (width, 0), (width, depth), (cut, depth), (0, depth - cut)]
    x, y = rng.uniform(1.0, width - 1.6), rng.uniform(1.0, depth - 1.6)
    side = rng.uniform(0.4, 0.6)
    pillar = [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    while True:
        at = rng.uniform((0.6, 0.6), (width - 0.6, depth - 0.6))
        off_pillar = np.hypot(*(at - np.clip(at, pillar[0], pillar[2])))
        if off_pillar > 0.5 and at[0] + depth - at[1] > cut + 0.8:
            return World.outline(room, pillar), Pose2D(*at, rng.uniform(-math.pi, math.pi))


def segments_of(theta, d, pieces, *, covariance=None, evidence=None):
    """Return LineSegments made by hand; a piece is (line, low, high, beams, rms) along its line."""
    beams = 1 + max((max(p[3], default=0) for p in pieces), default=0)
    points = np.zeros((len(pieces), beams), bool)
    for row, piece in zip(points, pieces, strict=True):
        row[list(piece[3])] = True
    ends = [wall(theta[k], d[k], low, high) for k, low, high, *_ in pieces]
    if covariance is None:
        covariance = np.tile(np.diag([1e-6, 1e-6]), (len(theta), 1, 1))
    support = [sum(len(p[3]) for p in pieces if p[0] == k) for k in range(len(theta))]
    return LineSegments(
        lines=Lines(theta=theta, d=d, support=support, covariance=covariance, evidence=evidence),
        line=[p[0] for p in pieces],
        endpoints=np.array(ends).reshape(-1, 2, 2),
        support=points.sum(axis=1),
        rms=[p[4] for p in pieces],
        points=points,
    )
