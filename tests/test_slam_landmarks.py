"""When something new becomes a landmark, and when a landmark is dropped."""

import math

import numpy as np
import pytest
from scenes import chain, scan_of, wall

from laserfeatures import LaserScan, Pose2D
from laserfeatures.slam.candidates import DOUBLE, RECENT, Candidates
from laserfeatures.slam.closeness import APART, TILT, close
from laserfeatures.slam.kinds import CORNER, WALL
from laserfeatures.slam.landmarks import DEPTH, Landmarks
from laserfeatures.slam.observations import Observations
from laserfeatures.slam.state import State

HERE = Pose2D(0.0, 0.0, 0.0)
SIGHTINGS = 3


def points(*places):
    return np.repeat(np.array(places, dtype=float).reshape(-1, 1, 2), 2, axis=1)


def corners(*places):
    """Return corners as observations."""
    values = np.array(places, dtype=float).reshape(-1, 2)
    noise = np.tile(1e-4 * np.eye(2), (len(values), 1, 1))
    return Observations(CORNER, values, noise, points(*places))


def walls(*some):
    """Return walls, each as (theta, d, low, high), as observations."""
    values = np.array([each[:2] for each in some], dtype=float).reshape(-1, 2)
    noise = np.tile(1e-4 * np.eye(2), (len(values), 1, 1))
    ends = np.array([wall(*each) for each in some]).reshape(-1, 2, 2)
    return Observations(WALL, values, noise, ends)


def propose(state, landmarks, seen, sightings=SIGHTINGS):
    landmarks.propose(state, seen, np.arange(len(seen)), sightings)


def with_landmarks(*seen, pose=HERE):
    """Return a state and its landmarks, made of what is seen from a pose."""
    state, landmarks = State(pose), Landmarks()
    for each in seen:
        propose(state, landmarks, each, 1)
    return state, landmarks


def end(state, landmarks, scan, patience=10):
    """Return which landmarks are kept after a scan, and how odd it is what it missed."""
    return landmarks.worth_keeping(state, scan, patience)


def ripe(candidates, scan, *places):
    return candidates.count(points(*places), CORNER, scan, SIGHTINGS).tolist()


def test_the_third_sighting_in_a_row_is_enough():
    candidates = Candidates()
    told = [ripe(candidates, scan, (1.0, 2.0 + 0.4 * DOUBLE * scan)) for scan in range(4)]
    assert told == [[False], [False], [True], [False]]  # then it counts from the start


def test_what_is_not_seen_again_soon_is_forgotten():
    candidates = Candidates()
    told = [ripe(candidates, scan, (1.0, 2.0)) for scan in (0, RECENT - 1, 2 * RECENT - 1)]
    assert told == [[False], [False], [False]]
    candidates = Candidates()
    told = [ripe(candidates, scan, (1.0, 2.0)) for scan in (0, RECENT - 1, 2 * RECENT - 2)]
    assert told == [[False], [False], [True]]


def test_what_is_elsewhere_counts_for_itself():
    candidates = Candidates()
    for scan in range(2):
        assert ripe(candidates, scan, (0.0, 0.0), (0.0, 3 * DOUBLE)) == [False, False]
    assert ripe(candidates, 2, (0.0, 3 * DOUBLE), (5.0, 0.0)) == [True, False]


def test_two_so_near_in_one_scan_are_one():
    candidates = Candidates()
    for scan in range(2):
        ripe(candidates, scan, (0.0, 0.0), (0.0, 0.5 * DOUBLE))
    assert ripe(candidates, 2, (0.0, 0.0), (0.0, 0.5 * DOUBLE)) == [True, False]


def test_corners_are_near_by_their_distance():
    found = close(points((0, 0), (3, 4)), points((0, 0.5), (0, 0)), 0.5, CORNER)
    assert found.tolist() == [[True, True], [False, False]]


@pytest.mark.parametrize(
    ("other", "near"),
    [
        (wall(0.0, 2.0, -1.0, 1.0), True),
        (wall(0.0, 2.0, 1.0, -1.0), True),  # told from its other end
        (wall(0.0, 2.4, -1.0, 1.0), True),
        (wall(0.0, 2.6, -1.0, 1.0), False),
        (wall(0.0, 1.4, -1.0, 1.0), False),
        (wall(0.0, 2.0, 1.0 + 0.9 * APART, 5.0), True),
        (wall(0.0, 2.0, 1.0 + 1.1 * APART, 5.0), False),
        (wall(0.0, 2.0, -5.0, -1.0 - 1.1 * APART), False),
        (wall(0.0, 2.0, -0.1, 0.1), True),  # a piece of it
        (wall(0.9 * TILT, 2.0, -0.3, 0.3), True),
        (wall(1.1 * TILT, 2.0, -0.3, 0.3), False),
        (wall(math.pi / 2, 0.0, -2.0, -1.8), False),
    ],
)
def test_walls_are_near_by_their_angle_distance_and_gap(other, near):
    one = np.array([wall(0.0, 2.0, -1.0, 1.0)])
    assert close(np.array([other]), one, 0.5, WALL).tolist() == [[near]]


@pytest.mark.parametrize("pose", [HERE, Pose2D(2.0, -1.0, 2.2)])
def test_a_landmark_is_put_where_it_was_seen_the_third_time(pose):
    state, landmarks = State(pose), Landmarks()
    for scan in range(SIGHTINGS):
        assert state.landmarks == 0
        propose(state, landmarks, corners((3.0, 1.0 + 0.02 * scan)))
        end(state, landmarks, scan_of(wall(0.0, 5.0, -1, 1)))
    assert (state.landmarks, landmarks.is_wall.tolist()) == (1, [False])
    np.testing.assert_allclose(state.positions, pose.transform([(3.0, 1.04)]))
    np.testing.assert_allclose(landmarks.anchors, [(pose.x, pose.y)])
    assert (landmarks.hits.tolist(), landmarks.misses.tolist()) == ([1.0], [0.0])


def test_what_stands_where_a_landmark_is_makes_no_second_one():
    state, landmarks = with_landmarks(corners((3.0, 1.0)), walls((0.0, 2.0, -1.0, 1.0)))
    propose(state, landmarks, corners((3.0, 1.0 + 0.8 * DOUBLE)), 1)
    propose(state, landmarks, walls((0.0, 2.0 - 0.8 * DOUBLE, 0.0, 1.5)), 1)
    assert state.landmarks == 2
    propose(state, landmarks, corners((3.0, 1.0 + 1.2 * DOUBLE), (2.0, 0.0)), 1)  # one on the wall
    propose(state, landmarks, walls((0.0, 2.0 - 1.2 * DOUBLE, 0.0, 1.5)), 1)
    assert landmarks.is_wall.tolist() == [False, True, False, False, True]


def test_only_those_measurements_that_were_of_no_landmark_are_proposed():
    state, landmarks = State(HERE), Landmarks()
    landmarks.propose(state, corners((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)), np.array([1]), 1)
    np.testing.assert_allclose(state.positions, [(2.0, 0.0)])


def test_a_measurement_may_be_of_what_is_near_as_far_as_the_pose_is_certain():
    state, landmarks = with_landmarks(corners((4.0, 0.0), (4.0, 1.5)), walls((0.0, 4.0, -1, 1)))
    seen = corners((4.0, 0.3))
    assert landmarks.near(state, seen).tolist() == [[True, False, False]]
    assert landmarks.near(state, walls((0.0, 4.1, -1, 1))).tolist() == [[False, False, True]]
    state.move(HERE, np.diag([0.4**2, 0.4**2, 0.0]))
    assert landmarks.near(state, seen).tolist() == [[True, True, False]]
    turned, landmarks = with_landmarks(corners((4.0, 0.0), (4.0, 1.5)))
    turned.move(HERE, np.diag([0.0, 0.0, 0.1**2]))
    assert landmarks.near(turned, seen).tolist() == [[True, True]]


def test_a_wall_grows_as_more_of_it_is_seen():
    state, landmarks = with_landmarks(walls((0.0, 2.0, -1.0, 1.0)))
    more = walls((0.0, 2.0, 0.5, 3.0))
    landmarks.saw(HERE, more, np.array([0]), np.array([0]))
    assert sorted(landmarks.present_ends(state)[0, :, 1].tolist()) == pytest.approx([-1.0, 3.0])
    assert landmarks.hits.tolist() == [2.0]


def test_ends_follow_the_landmark_as_it_is_corrected():
    state, landmarks = with_landmarks(corners((3.0, 1.0)), walls((0.0, 2.0, -1.0, 1.0)))
    state.mean[3:] += 0.1, 0.2, 0.0, 0.3
    ends = landmarks.present_ends(state)
    np.testing.assert_allclose(ends[0], [(3.1, 1.2)] * 2)
    np.testing.assert_allclose(ends[1, :, 0], 2.3)
    np.testing.assert_allclose(sorted(ends[1, :, 1]), [-1.0, 1.0])


def seen_of(place, screen):
    """Return how many misses a scan of some walls counts of a corner at a place."""
    state, landmarks = with_landmarks(corners(place))
    end(state, landmarks, LaserScan(angles=[], ranges=[]))  # the scan in which it was seen
    odd = end(state, landmarks, scan_of(*screen, range_max=10.0))[1]
    assert (odd > 0) == (landmarks.misses[0] > 0)
    return landmarks.misses[0]


FAR = chain((6.0, -6.0), (6.0, 6.0))
AWAY = chain((20.0, -6.0), (20.0, 6.0))  # out of range


@pytest.mark.parametrize(
    ("place", "screen", "missed"),
    [
        ((3.0, 0.0), FAR, 1),  # the beam goes through
        ((3.0, 0.0), AWAY, 1),  # and finds nothing at all
        ((6.0 + 0.8 * DEPTH, 0.0), FAR, 1),
        ((6.0 + 1.5 * DEPTH, 0.0), FAR, 0),  # hidden
        ((-3.0, 0.0), FAR, 0),  # behind
        ((10.5, 0.0), AWAY, 0),  # out of range
        ((3.0, 2.0), chain((2.0, 1.0), (1.0, 1.0)), 0),
    ],
)
def test_a_landmark_is_missed_only_where_a_beam_looks_there(place, screen, missed):
    assert seen_of(place, screen) == missed


def test_a_landmark_that_is_missed_too_often_is_dropped():
    patience = 4
    state, landmarks = with_landmarks(corners((3.0, 0.0), (-3.0, 0.0)))
    landmarks.saw(HERE, corners((3.0, 0.0)), np.array([0]), np.array([0]))
    scan = scan_of(*FAR)
    kept, odd = end(state, landmarks, scan, patience)
    assert (kept.tolist(), odd) == ([True, True], 0)  # seen in this scan
    for _ in range(2 + patience):  # two sightings, and the patience
        assert end(state, landmarks, scan, patience)[0].tolist() == [True, True]
    kept, _ = end(state, landmarks, scan, patience)
    assert kept.tolist() == [False, True]  # the other is behind the robot: no reason to drop it
    assert landmarks.misses.tolist() == [3.0 + patience, 0.0]
    landmarks.keep(kept)
    assert (landmarks.hits.tolist(), landmarks.misses.tolist()) == ([1.0], [0.0])
    np.testing.assert_allclose(landmarks.ends, points((-3.0, 0.0)))


def test_what_was_always_recognised_is_the_odder_to_be_missed():
    """Minus the logarithm of the chance, by how often each was recognised so far."""
    state, landmarks = with_landmarks(corners((3.0, 0.0), (3.0, 1.0)))
    for _ in range(8):
        landmarks.saw(HERE, corners((3.0, 0.0)), np.array([0]), np.array([0]))
    landmarks.misses[:] = 0.0, 3.0
    scan = scan_of(*FAR)
    end(state, landmarks, scan)  # they were seen in this one
    odd = end(state, landmarks, scan)[1]
    assert odd == pytest.approx(-math.log(1 - 9 / 10) - math.log(1 - 1 / 5))


def test_a_landmark_that_is_seen_now_and_then_stays():
    state, landmarks = with_landmarks(corners((3.0, 0.0)))
    scan = scan_of(*FAR)
    for number in range(100):
        if number % 2:
            landmarks.saw(HERE, corners((3.0, 0.0)), np.array([0]), np.array([0]))
        assert end(state, landmarks, scan, patience=4)[0].all()


def test_a_scan_without_a_beam_misses_nothing():
    state, landmarks = with_landmarks(corners((3.0, 0.0)))
    kept, odd = end(state, landmarks, LaserScan(angles=[], ranges=[]))
    assert (kept.tolist(), odd) == ([True], 0)
