"""What the speed benchmarks share: sensors, scans, both contenders, and checks of their results."""

import gc
import math
import time
from dataclasses import dataclass

import cv2
import numpy as np
import truth as truths
from rooms import plain_room

import laserfeatures as lf
from laserfeatures.evaluation import Truth
from laserfeatures.evaluation.true_lines import difference
from laserfeatures.simulation import Scanner

THETA_STEP = math.radians(1)
DISTANCE_STEP = 0.02
LIMITS = np.array([math.radians(0.3), 0.01])  # [rad, m], of a line from its wall, to be right
SIGMAS = 4.0  # what a short wall may be off instead, for the noise of its points
CORNER_LIMIT = 0.05  # [m]
LINES_MAX, THRESHOLD = 8, 4  # of the peer
RANGE_SIGMA = 0.005  # [m]

SENSORS = {
    181: Scanner(beams=181, field_of_view=math.pi),
    361: Scanner(beams=361, field_of_view=math.pi),
    682: Scanner(beams=682, field_of_view=math.radians(239.414), range_max=5.6),
    1081: Scanner(beams=1081, field_of_view=math.radians(270), range_max=30.0),
}


@dataclass(frozen=True)
class Case:
    """A scan, what is true of it, and the corners that a person sees in it."""

    scan: lf.LaserScan
    truth: Truth
    junctions: np.ndarray


def room_cases(scanner, *, noises=1, outliers=0.0):
    """Return scans of the known room from each pose, `noises` times each, with shared angles.

    `outliers` is the share of the beams that show nothing true; no two neighbours do.
    """
    world, poses = plain_room()
    angles = scanner.angles
    angles.flags.writeable = False
    cases = []
    for seed in range(noises):
        for number, pose in enumerate(poses):
            rng = np.random.default_rng((seed, number, scanner.beams))
            scan, truth = truths.sense(world, scanner, pose, rng, outliers=outliers, isolated=True)
            scan = lf.LaserScan(angles=angles, ranges=scan.ranges, range_max=scan.range_max)
            cases.append(Case(scan, truth, truths.junctions(world, scanner, pose)))
    return cases


def fresh(scan):
    """Return the scan as a reader would make it: nothing computed yet, angles shared."""
    return lf.LaserScan(
        angles=scan.angles,
        ranges=scan.ranges,
        range_min=scan.range_min,
        range_max=scan.range_max,
        stamp=scan.stamp,
    )


def farthest(scan):
    """Return the range of the farthest point [m]: no accumulator can do with less."""
    return math.ceil(scan.ranges[scan.valid].max() / DISTANCE_STEP) * DISTANCE_STEP


def peer_call(scan, reach, theta_step=THETA_STEP):
    """Return OpenCV's Hough transform of the points of `scan` as a call without arguments.

    The points are Cartesian and float32 already, in the peer's favour. Its accumulator holds
    distances up to `reach` [m].
    """
    points = scan.points.astype(np.float32).reshape(-1, 1, 2)
    limits = (-reach, reach, DISTANCE_STEP, 0.0, math.pi, theta_step)
    return lambda: cv2.HoughLinesPointSet(points, LINES_MAX, THRESHOLD, *limits)


def peer_lines(found):
    """Return theta [rad] and d [m] of what the peer's call returned; strongest first."""
    lines = np.empty((0, 3)) if found is None else np.asarray(found).reshape(-1, 3)
    return lines[:, 2], lines[:, 1]


def faults(features, case):
    """Return what is wrong with the features of a case, as texts; none, if all is right."""
    wrong = []
    found = features.lines
    truth = case.truth
    limits = np.maximum(LIMITS, SIGMAS * truths.sigmas(case.scan, truth, RANGE_SIGMA))
    for k, (most_turn, most_shift) in enumerate(limits):
        turn, shift = difference(found.theta, found.d, truth.theta[k], truth.d[k])
        right = (abs(turn) < most_turn) & (abs(shift) < most_shift)
        if right.sum() != 1:
            wrong.append(f"wall {k} of {(truth.line == k).sum()} beams found {right.sum()} times")
    if len(found) != truth.theta.size:
        wrong.append(f"{len(found)} lines for {truth.theta.size} walls")
    for corner, gap in zip(case.junctions, nearest(case.junctions, features.corners), strict=True):
        if gap >= CORNER_LIMIT:
            wrong.append(f"corner {corner.round(2).tolist()} off by {gap:.3f} m")
    return wrong


def nearest(places, corners):
    """Return the distance of each of `places` (P, 2) to the nearest corner [m], (P,)."""
    gaps = np.hypot(*(places[:, None] - corners.positions[None]).transpose(2, 0, 1))
    return gaps.min(axis=1, initial=np.inf)


def walls_met(theta, d, truth, theta_step=THETA_STEP):
    """Return how many of the walls some lines meet, and how many of the lines repeat one.

    A line belongs to the wall that it is within two bins of; the rest is neither.
    """
    hits = np.zeros(truth.theta.size, dtype=int)
    for line in zip(theta, d, strict=True):
        turn, shift = difference(truth.theta, truth.d, *line)
        off = np.maximum(abs(turn) / theta_step, abs(shift) / DISTANCE_STEP)
        if off.size and off.min() <= 2:
            hits[off.argmin()] += 1
    return int((hits > 0).sum()), int((hits - (hits > 0)).sum())


def interleaved(makers, repeats, *, block=10):
    """Time calls in turns; return seconds (calls, repeats).

    Each of `makers` takes the number of the repeat and returns the call to be timed; what it does
    itself is not timed. `block` repeats of one contender follow each other, then as many of the
    next: with 1, each finds the caches as the other left them.
    """
    seconds = np.empty((len(makers), repeats))
    collecting = gc.isenabled()
    gc.disable()
    try:
        for first in range(0, repeats, block):
            for m, maker in enumerate(makers):
                for k in range(first, min(first + block, repeats)):
                    call = maker(k)
                    start = time.perf_counter()
                    call()
                    seconds[m, k] = time.perf_counter() - start
    finally:
        if collecting:
            gc.enable()
    return seconds


def contenders(extractor, cases, reaches, theta_step=THETA_STEP):
    """Return makers for `interleaved`: ours, then the peer with each function of `reaches`."""

    def peer(reach):
        return in_turn([peer_call(case.scan, reach(case.scan), theta_step) for case in cases])

    return [whole_call(extractor, cases), *(peer(reach) for reach in reaches)]


def whole_call(extractor, cases):
    """Return a maker for `interleaved`: the extractor on each scan, of which nothing is known."""

    def ours(k):
        scan = fresh(cases[k % len(cases)].scan)
        return lambda: extractor(scan)

    return ours


def in_turn(calls):
    """Return a maker for `interleaved` of calls that are ready."""
    return lambda k: calls[k % len(calls)]


def sensor_range(scan):
    """Return the range of the sensor [m], which is what a user would know."""
    return scan.range_max
