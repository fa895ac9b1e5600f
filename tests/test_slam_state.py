"""The state against plain full matrices, and over a hundred thousand steps."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import needs_compiler
from slam_reference import corrected, moved

from laserfeatures import Pose2D
from laserfeatures.slam import Motion
from laserfeatures.slam.invariance import carried_over
from laserfeatures.slam.kinds import CORNER
from laserfeatures.slam.state import ROOM, State

STEPS = 100_000
CORNERS = np.array([(4.0, 0.0), (-1.0, 3.0), (-2.0, -3.0)])
NO_WALLS = np.zeros(len(CORNERS), dtype=bool)
seeds = st.integers(0, 2**31)


def nothing(before, _):
    return np.zeros((len(before), 3))


def random_covariance(rng, size):
    root = rng.normal(size=(size, size))
    return root @ root.T / size + 1e-3 * np.eye(size)


def random_state(rng, landmarks):
    """Return a state whose numbers are all correlated."""
    state = State(Pose2D(*rng.normal(size=3)))
    for _ in range(landmarks):
        state.add(rng.normal(size=2), rng.normal(size=(2, 3)), np.eye(2))
    state.covariance[:] = random_covariance(rng, state.size)
    return state


@given(seeds, st.integers(0, 40))
def test_a_move_is_that_of_full_matrices(seed, landmarks):
    rng = np.random.default_rng(seed)
    state = random_state(rng, landmarks)
    step, noise = Pose2D(*rng.normal(size=3)), random_covariance(rng, 3)
    mean, covariance = moved(state.mean.copy(), state.covariance.copy(), step, noise)
    state.move(step, noise)
    np.testing.assert_allclose(state.covariance, covariance, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(state.covariance, state.covariance.T)
    mean[2] = math.remainder(mean[2], math.tau)
    np.testing.assert_allclose(state.mean, mean, rtol=1e-12, atol=1e-12)


@given(seeds, st.integers(1, 40), st.integers(1, 6), st.booleans())
def test_a_correction_is_that_of_full_matrices(seed, landmarks, rows, carried):
    rng = np.random.default_rng(seed)
    state = random_state(rng, landmarks)
    places = np.sort(rng.permutation(state.size)[: rng.integers(1, 8)])
    part, innovation = rng.normal(size=(rows, len(places))), rng.normal(size=rows)
    noise = random_covariance(rng, rows)
    whole = np.zeros((rows, state.size))
    whole[:, places] = part
    change = rng.normal(size=(state.size, 3)) * carried
    change[2] = 0.0
    before = state.mean.copy()
    mean, covariance, squared = corrected(before, state.covariance.copy(), whole, innovation, noise)
    over = np.eye(state.size)
    over[:, :3] += change
    seen = []
    found = state.correct(places, part, innovation, noise, lambda *m: seen.append(m) or change)
    assert found == pytest.approx(squared, rel=1e-7)
    mean[2] = math.remainder(mean[2], math.tau)
    np.testing.assert_allclose(state.mean, mean, atol=1e-9)
    np.testing.assert_allclose(state.covariance, over @ covariance @ over.T, atol=1e-8)
    np.testing.assert_array_equal(state.covariance, state.covariance.T)
    np.testing.assert_array_equal(seen[0][0], before)
    np.testing.assert_allclose(seen[0][1], mean, atol=1e-9)


@given(seeds, st.integers(0, 5))
def test_a_new_landmark_is_correlated_as_its_place_depends_on_the_pose(seed, landmarks):
    rng = np.random.default_rng(seed)
    state = random_state(rng, landmarks)
    mean, covariance, n = state.mean.copy(), state.covariance.copy(), state.size
    value, by_pose, noise = rng.normal(size=2), rng.normal(size=(2, 3)), random_covariance(rng, 2)
    state.add(value, by_pose, noise)
    by_state = np.vstack([np.eye(n), np.hstack([by_pose, np.zeros((2, n - 3))])])
    wanted = by_state @ covariance @ by_state.T
    wanted[n:, n:] += noise
    np.testing.assert_allclose(state.covariance, wanted, atol=1e-12)
    np.testing.assert_array_equal(state.covariance, state.covariance.T)
    np.testing.assert_array_equal(state.mean, [*mean, *value])
    assert (state.landmarks, state.size) == (landmarks + 1, n + 2)


def test_room_grows_and_nothing_is_lost():
    """The state is larger than there was room for at first, more than once."""
    rng = np.random.default_rng(1)
    state = State(Pose2D(1.0, 2.0, 3.0))
    state.move(Pose2D(0.0, 0.0, 0.0), random_covariance(rng, 3))
    whole, mean = state.covariance.copy(), state.mean.copy()
    for i in range(ROOM + 3):
        by_pose = rng.normal(size=(2, 3))
        across = by_pose @ whole[:3]
        own = across[:, :3] @ by_pose.T + np.eye(2)
        whole, mean = np.block([[whole, across.T], [across, own]]), np.append(mean, [i, -i])
        state.add(np.array([i, -i]), by_pose, np.eye(2))
    assert state.size > 2 * ROOM
    np.testing.assert_allclose(state.covariance, whole, atol=1e-12)
    np.testing.assert_array_equal(state.mean, mean)
    np.testing.assert_array_equal(state.positions, mean[3:].reshape(-1, 2))
    blocks = [whole[3 + 2 * i : 5 + 2 * i, 3 + 2 * i : 5 + 2 * i] for i in range(ROOM + 3)]
    np.testing.assert_allclose(state.blocks(), blocks, atol=1e-12)


def test_what_is_kept_keeps_its_numbers_and_what_is_dropped_leaves_no_trace():
    rng = np.random.default_rng(2)
    state = random_state(rng, 5)
    which = np.array([True, False, True, False, True])
    places = [0, 1, 2, 3, 4, 7, 8, 11, 12]
    mean, covariance = state.mean[places].copy(), state.covariance[np.ix_(places, places)].copy()
    state.keep(which)
    np.testing.assert_array_equal(state.mean, mean)
    np.testing.assert_array_equal(state.covariance, covariance)
    assert state.landmarks == 3
    state.add(np.zeros(2), np.zeros((2, 3)), np.eye(2))  # into the room that was left
    np.testing.assert_array_equal(state.covariance[9:, :9], 0.0)
    np.testing.assert_array_equal(state.covariance[:9, 9:], 0.0)
    np.testing.assert_array_equal(state.covariance[9:, 9:], np.eye(2))


def test_headings_are_wrapped():
    state = State(Pose2D(0.0, 0.0, 3.0))
    state.move(Pose2D(0.0, 0.0, 1.0), np.eye(3))
    assert state.pose.theta == pytest.approx(4.0 - math.tau)
    state.correct(np.array([2]), np.eye(1), np.array([-6.0]), np.eye(1) * 1e-9, nothing)
    assert state.pose.theta == pytest.approx(-2.0, abs=1e-6)


class SmallWorld:
    """A robot that goes round for ever, and sees one of three corners at each step."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.truth = (0.0, 0.0, 0.0)
        self.state = State(Pose2D(*self.truth))
        self.noise = 0.02**2 * np.eye(2)
        motion = Motion(way=0.02, side=0.01, turn_by_way=0.01, turn=0.02)
        self.taken = Pose2D(0.1, 0.0, 0.35)
        self.covariance = motion.covariance(self.taken)
        self.places = [np.array([0, 1, 2, 3 + 2 * i, 4 + 2 * i]) for i in range(len(CORNERS))]
        for corner in CORNERS:
            seen = corner + self.rng.normal(0, 0.02, 2)
            placed = CORNER.place(self.state.pose, seen, self.noise)
            self.state.add(placed.value, placed.by_pose, placed.noise)

    def drive(self, steps):
        """Step on and on; yield the state after each."""
        normal = self.rng.normal(size=(steps, 5))
        normal[:, :3] *= np.sqrt(np.diag(self.covariance))
        normal[:, 3:] *= 0.02
        for number, (x, y, turn, *error) in enumerate(normal.tolist()):
            self._move(x + self.taken.x, y + self.taken.y, turn + self.taken.theta)
            self.state.move(self.taken, self.covariance)
            i = number % len(CORNERS)
            jacobian, innovation = self._seen(i, error)
            self.state.correct(self.places[i], jacobian, innovation, self.noise, self._carried)
            yield self.state

    def _move(self, x, y, turn):
        px, py, theta = self.truth
        c, s = math.cos(theta), math.sin(theta)
        self.truth = px + c * x - s * y, py + s * x + c * y, theta + turn

    def _seen(self, i, error):
        true, _ = self._local(self.truth, CORNERS[i])
        (x, y), (c, s) = self._local(self.state.mean[:3], self.state.positions[i])
        jacobian = np.array([[-c, -s, y, c, s], [s, -c, -x, -s, c]])
        return jacobian, np.array([true[0] + error[0] - x, true[1] + error[1] - y])

    @staticmethod
    def _local(pose, corner):
        px, py, theta = pose
        c, s = math.cos(theta), math.sin(theta)
        x, y = corner[0] - px, corner[1] - py
        return (c * x + s * y, c * y - s * x), (c, s)

    @staticmethod
    def _carried(before, after):
        return carried_over(before, after, NO_WALLS, CORNERS)


@needs_compiler
def test_a_hundred_thousand_steps_leave_the_covariance_symmetric_and_positive_definite():
    world = SmallWorld(3)
    smallest = math.inf
    for number, state in enumerate(world.drive(STEPS)):
        if number % 500 == 0 or number == STEPS - 1:
            np.testing.assert_array_equal(state.covariance, state.covariance.T)
            values = np.linalg.eigvalsh(state.covariance)
            smallest = min(smallest, values[0] / values[-1])
    assert smallest > 1e-9
    assert math.dist(world.truth[:2], state.mean[:2]) < 0.1
    assert abs(math.remainder(world.truth[2] - state.mean[2], math.tau)) < 0.02
