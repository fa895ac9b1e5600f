"""Simulated scans whose true lines and corners are as many as those of the paper's testbench.

Half of the scans are taken in L-shaped hallways in the manner of the paper's Fig. 5, half in rooms.
All walls have a right angle to each other but those that cut off a corner; doors, pillars and
cupboards are niches and bays of a wall. Each scan has a world of its own.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.errors import LaserFeaturesError
from laserfeatures.evaluation import truth_of
from laserfeatures.simulation import Observation, Scanner, World
from laserfeatures.testbench.paper import REAL_FEATURES, REAL_LINES, SCANS

TOLERANCE = 0.05  # of the paper's totals
ATTEMPTS = 2000
SLOT = 1.8  # [m] of a wall may have a niche or bay
RECESS = 0.65  # probability that they do
WIDE = (0.6, 1.4)  # [m]
DEEP = (0.2, 0.5)  # [m]
CUT = 0.05  # probability that a corner is cut off
CLEARANCE = 0.4  # [m], of the sensor from any wall


def paper_scans(seed: int, count: int = SCANS) -> list[Observation]:
    """Return scans of the `lms200` with about as many true lines and corners as the paper's.

    Whole sets are drawn until both totals lie within 5 % of the paper's, scan for scan. So the
    choice depends on what is true of the scans alone, and on nothing that an extractor finds.

    Parameters
    ----------
    seed : int
        Seed of all randomness.
    count : int
        Number of scans.

    Raises
    ------
    LaserFeaturesError
        If no set of 2000 fits.
    """
    scanner = Scanner.model("lms200")
    for attempt in range(ATTEMPTS):
        scans = _draw((seed, attempt), count, scanner)
        truths = [truth_of(scan) for scan in scans]
        lines = sum(truth.theta.size for truth in truths)
        corners = sum(len(truth.corners) for truth in truths)
        if _near(lines, REAL_LINES, count) and _near(corners, REAL_FEATURES, count):
            return scans
    raise LaserFeaturesError(
        f"none of {ATTEMPTS} sets of {count} scans has as many lines and corners as the paper's "
        f"within {TOLERANCE:.0%}; take another number of scans"
    )


def any_scans(seed: int, count: int, scanner: Scanner) -> list[Observation]:
    """Return scans of worlds such as those of `paper_scans`, as they come.

    Another scanner sees the same worlds from the same poses.
    """
    return _draw((seed,), count, scanner)


def on_grid(observations: Sequence[Observation], seed: int, step: float) -> list[Observation]:
    """Return scans by the `lms200` in the same places, with headings at multiples of `step` [rad].

    Walls at right angles to the world's axes then lie on the grid of an accumulator whose theta
    goes in a divisor of `step`.
    """
    scanner = Scanner.model("lms200")
    turned = []
    for i, seen in enumerate(observations):
        pose = replace(seen.pose, theta=round(seen.pose.theta / step) * step)
        turned.append(scanner.observe(seen.world, pose, np.random.default_rng((seed, i))))
    return turned


def _draw(seed: tuple[int, ...], count: int, scanner: Scanner) -> list[Observation]:
    return [_observe(np.random.default_rng((*seed, i)), scanner) for i in range(count)]


def _near(total: int, paper: int, count: int) -> bool:
    wanted = paper * count / SCANS
    return abs(total - wanted) <= TOLERANCE * wanted


def _observe(rng: Generator, scanner: Scanner) -> Observation:
    """Return a scan of a new hallway or room from a random pose in it."""
    corners, low, high = _hallway(rng) if rng.random() < 0.5 else _room(rng)
    world = World.outline(_outline(rng, corners))
    while True:
        x, y = rng.uniform(low, high)
        if _clearance(world, x, y) > CLEARANCE:
            return scanner.observe(world, Pose2D(x, y, rng.uniform(-math.pi, math.pi)), rng)


def _hallway(rng: Generator) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the corners of an L, and the lowest and highest x and y of one of its legs."""
    (far, high), (low, wide) = rng.uniform(5, 10, 2), rng.uniform(1.6, 2.6, 2)
    near = far - wide
    corners = np.array([(0, 0), (far, 0), (far, high), (near, high), (near, low), (0, low)])
    if rng.random() < 0.5:
        return corners, np.zeros(2), np.array((far, low))
    return corners, np.array((near, 0.0)), np.array((far, high))


def _room(rng: Generator) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the corners of a rectangle, and its lowest and highest x and y."""
    far, high = rng.uniform((3, 3), (9, 7))
    corners = np.array([(0, 0), (far, 0), (far, high), (0, high)])
    return corners, corners[0], corners[2]


def _outline(rng: Generator, corners: FloatArray) -> FloatArray:
    """Return a polygon with some of its corners cut off, and niches and bays in some sides."""
    points: list[FloatArray] = []
    for k, corner in enumerate(corners):
        before, after = corner - corners[k - 1], corners[(k + 1) % len(corners)] - corner
        length = math.hypot(*after)
        along = after / length
        if rng.random() < CUT:
            off = rng.uniform(0.4, 0.8)
            points += [corner - before / math.hypot(*before) * off, corner + along * off]
        else:
            points.append(corner)
        inward = np.array([-along[1], along[0]])
        for slot in range(int((length - 0.8) / SLOT)):
            if rng.random() < RECESS:
                wide, deep = rng.uniform(*WIDE), rng.uniform(*DEEP) * rng.choice((-1, 1))
                start = corner + along * (0.8 + slot * SLOT + rng.uniform(0, SLOT - 0.3 - wide))
                end = start + along * wide
                points += [start, start + inward * deep, end + inward * deep, end]
    return np.array(points)


def _clearance(world: World, x: float, y: float) -> float:
    """Return the distance [m] of a point from the nearest wall, or -1 outside of a polygon."""
    start, along = world.walls[:, 0], world.walls[:, 1] - world.walls[:, 0]
    crossed = (start[:, 1] > y) != (world.walls[:, 1, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = x < start[:, 0] + (y - start[:, 1]) * along[:, 0] / along[:, 1]
    if (crossed & right).sum() % 2 == 0:
        return -1.0
    return float(world.distances((x, y)).min())
