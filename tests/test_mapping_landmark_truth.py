"""The true map of a simulated world, and landmarks held against it."""

import math

import numpy as np
import pytest

from laserfeatures.data import Pose2D
from laserfeatures.mapping.landmark_score import SPURIOUS, score_landmarks
from laserfeatures.mapping.landmark_truth import TrueMap, true_map
from laserfeatures.simulation import Scanner, World
from laserfeatures.slam import Landmark

ROOM = [((0, 0), (5, 0)), ((5, 0), (5, 4)), ((5, 4), (0, 4)), ((0, 4), (0, 0))]
STUB = ((2, 0), (2, 1))  # a wall into the room
POSES = [Pose2D(3.5, 1.0, 0.3), Pose2D(3.5, 1.5, math.pi - 0.2), Pose2D(1.0, 3.0, -1.0)]


def shown(*walls, poses=POSES):
    world = World(walls=np.array(walls, dtype=float))
    rng = np.random.default_rng(0)
    return true_map([Scanner().observe(world, pose, rng) for pose in poses])


def corner(x, y):
    place = np.array([x, y], dtype=float)
    return Landmark(
        kind="corner", values=place, covariance=np.eye(2), ends=np.stack([place] * 2), sightings=3
    )


def wall(*ends):
    ends = np.array(ends, dtype=float)
    return Landmark(kind="wall", values=np.zeros(2), covariance=np.eye(2), ends=ends, sightings=3)


def test_the_corners_of_all_scans_come_together_each_once():
    found = shown(*ROOM, STUB)
    real = {tuple(corner) for corner in found.corners[found.real]}
    virtual = {tuple(corner) for corner in found.corners[~found.real]}
    assert real == {(0, 0), (5, 0), (5, 4), (0, 4), (2, 0)}
    assert virtual == {(2, 4)}  # the stub, made longer


def test_a_corner_that_one_scan_takes_for_virtual_and_another_for_real_is_real():
    walls = [*ROOM, STUB, ((2, 3), (2, 4))]
    both, other = Pose2D(3.5, 1.0, math.pi), Pose2D(3.5, 0.5, math.pi / 4)  # other: not the stub
    alone, together = shown(*walls, poses=[other]), shown(*walls, poses=[both, other])
    for found, real in ((alone, False), (together, True)):
        (i,) = np.flatnonzero((found.corners == (2, 0)).all(axis=1))
        assert found.real[i] == real


def test_walls_on_one_line_are_one_and_what_was_not_measured_is_none():
    found = shown(*ROOM, ((2, 0), (2, 1)), ((2, 3), (2, 4)), ((7, 0), (7, 4)))
    spans = {tuple(sorted(map(tuple, ends))) for ends in found.walls.tolist()}
    assert ((2, 0), (2, 4)) in spans
    assert len(spans) == 5


def test_without_a_scan_there_is_no_true_map():
    with pytest.raises(ValueError, match="at least one scan, got none"):
        true_map([])


TRUTH = TrueMap(
    corners=[(0, 0), (5, 0), (5, 4), (0, 4), (2, 4)],
    real=[True, True, True, True, False],
    walls=[[(0, 0), (5, 0)], [(5, 0), (5, 4)], [(0, 0.2), (5, 0.2)]],
)


def test_a_corner_counts_by_its_distance_from_the_nearest():
    found = score_landmarks([corner(0, 0), corner(5.03, 0.04), corner(2, 3.9)], TRUTH)
    assert (found.landmarks, found.virtual, found.spurious, found.doubled) == (3, 1, 0, 0)
    assert found.median_error == pytest.approx(0.05)


def test_what_is_far_from_all_that_is_true_is_spurious_and_not_doubled():
    far = [corner(1, 1 + SPURIOUS), corner(1, 1 + SPURIOUS), corner(5 + SPURIOUS + 0.01, 4)]
    found = score_landmarks([*far, corner(5 + SPURIOUS - 0.01, 4)], TRUTH)
    assert (found.spurious, found.doubled, found.virtual) == (3, 0, 0)
    assert found.median_error > SPURIOUS


def test_the_second_landmark_of_a_corner_is_doubled():
    found = score_landmarks([corner(0, 0), corner(0.1, 0), corner(0, 0.1), corner(5, 4)], TRUTH)
    assert (found.spurious, found.doubled) == (0, 2)


def test_a_wall_is_off_by_the_end_that_is_farther_from_the_nearest_line_along_it():
    found = score_landmarks([wall((1, 0.01), (4, -0.03)), wall((4.98, 0.5), (4.98, 3))], TRUTH)
    assert (found.landmarks, found.spurious, found.doubled) == (2, 0, 0)
    assert found.median_error == pytest.approx((0.03 + 0.02) / 2)
    nearer = score_landmarks([wall((1, 0.17), (4, 0.19))], TRUTH)
    assert nearer.median_error == pytest.approx(0.03)


@pytest.mark.parametrize(
    "ends",
    [
        ((1, 2), (4, 2)),  # far from all
        ((5.4, 0), (7, 0)),  # on the line of a wall, where no wall is
        ((1, -0.2), (1, 0.29)),  # across one
    ],
)
def test_a_wall_where_there_is_none_is_spurious(ends):
    assert score_landmarks([wall(*ends)], TRUTH).spurious == 1


def test_a_wall_told_twice_is_doubled_and_two_parts_of_it_are_not():
    parts = [wall((0, 0), (2, 0)), wall((4.5, 0), (2.5, 0))]
    assert score_landmarks(parts, TRUTH).doubled == 0
    assert score_landmarks([*parts, wall((1, 0.02), (1.8, 0.02))], TRUTH).doubled == 1
    assert score_landmarks([*parts, wall((1, 0.2), (1.8, 0.2))], TRUTH).doubled == 0


def test_no_landmarks_and_no_truth():
    nothing = score_landmarks([], TRUTH)
    assert (nothing.landmarks, nothing.spurious, nothing.doubled) == (0, 0, 0)
    assert math.isnan(nothing.median_error)
    unknown = TrueMap(corners=np.empty((0, 2)), real=[], walls=np.empty((0, 2, 2)))
    found = score_landmarks([corner(0, 0), wall((0, 0), (1, 0))], unknown)
    assert found.spurious == 2
    assert math.isnan(found.median_error)
