"""Joint compatibility against all pairings tried one by one; gates; nearest neighbours."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2
from slam_reference import best_pairing, joint, pairings

from laserfeatures.slam.association import (
    Pairs,
    distances,
    gate,
    joint_compatibility,
    nearest_neighbours,
    worth,
)

SURE = 0.99
GATES = [gate(2 * (i + 1), SURE) for i in range(10)]
NOISE = 0.1**2 * np.eye(2)


def random_pairs(rng):
    """Return up to four measurements with up to three landmarks each, all correlated."""
    measurement, landmark = [], []
    for i in range(rng.integers(1, 5)):
        some = np.sort(rng.permutation(4)[: rng.integers(1, 4)])
        measurement += [i] * len(some)
        landmark += some.tolist()
    count = len(measurement)
    root = rng.normal(size=(2 * count, 5)) * rng.uniform(0.05, 0.5)
    noise = rng.normal(size=(4, 2, 2))[measurement] * 0.1  # of the measurement, whatever it is of
    return Pairs(
        np.array(measurement),
        np.array(landmark),
        rng.normal(size=(count, 2)) * rng.uniform(0.1, 1.0),
        root @ root.T,
        noise @ noise.transpose(0, 2, 1) + 0.01 * np.eye(2),
    )


def simple_pairs(measurement, landmark, innovation, *, shared):
    """Return pairs whose expected measurements are all off by the same unknown shift."""
    count = len(measurement)
    return Pairs(
        np.array(measurement),
        np.array(landmark),
        np.array(innovation, dtype=float),
        np.tile(shared**2 * np.eye(2), (count, count)),
        np.tile(NOISE, (count, 1, 1)),
    )


@pytest.mark.parametrize("degrees", [2, 3, 4, 6, 10, 20, 60, 200])
@pytest.mark.parametrize(
    ("probability", "within"), [(0.95, 0.01), (0.975, 0.01), (0.99, 0.01), (1 - 1e-6, 0.1)]
)
def test_the_gate_is_the_quantile_of_chi_square(degrees, probability, within):
    assert gate(degrees, probability) == pytest.approx(chi2.ppf(probability, degrees), rel=within)


@given(st.integers(0, 2**31))
def test_distances_are_those_of_each_pair_alone(seed):
    pairs = random_pairs(np.random.default_rng(seed))
    alone = [joint(pairs, [i])[0] for i in range(len(pairs.measurement))]
    np.testing.assert_allclose(distances(pairs), alone, rtol=1e-7)


@settings(max_examples=40)
@given(st.integers(0, 2**31), st.sampled_from([1e-5, 0.05, 0.5, 5.0]))
def test_joint_compatibility_finds_the_best_of_all_pairings(seed, density):
    pairs = random_pairs(np.random.default_rng(seed))
    wanted, _ = best_pairing(pairs, GATES, density)
    assert joint_compatibility(pairs, SURE, density).tolist() == wanted


def test_the_random_problems_are_not_all_trivial():
    """So that the test above is of something: sizes of the best pairings, and of the problems."""
    problems = [random_pairs(np.random.default_rng(seed)) for seed in range(60)]
    sizes = [len(best_pairing(pairs, GATES, 0.5)[0]) for pairs in problems]
    assert {0, 1, 2, 3} <= set(sizes)
    assert max(sum(1 for _ in pairings(pairs)) for pairs in problems) > 50


def test_pairs_that_fit_alone_but_not_together_are_refused():
    """The pose may be off by 1 m; two walls say 0.8 m to the left, a third 0.8 m to the right."""
    pairs = simple_pairs([0, 1, 2], [0, 1, 2], [(0.8, 0.0), (0.82, 0.0), (-0.8, 0.0)], shared=1.0)
    assert (distances(pairs) < gate(2, SURE)).all()
    for density in (0.05, 1e-9):  # even where three together would be likelier than two
        assert joint_compatibility(pairs, SURE, density).tolist() == [0, 1]
    assert joint(pairs, [0, 1, 2])[0] > gate(6, SURE)
    assert nearest_neighbours(pairs, SURE).tolist() == [0, 1, 2]


def test_a_consistent_shift_beats_the_nearer_neighbours():
    """A row of posts 1 m apart, and a pose 0.7 m off: each measurement is nearest to the next."""
    posts = np.arange(3)
    measurement = [0, 0, 1, 1, 2]
    landmark = [0, 1, 1, 2, 2]
    innovation = np.zeros((5, 2))
    innovation[:, 0] = 0.7 + posts[measurement] - posts[landmark]
    pairs = simple_pairs(measurement, landmark, innovation, shared=0.7)
    right = [0, 2, 4]
    assert joint_compatibility(pairs, SURE, 0.05).tolist() == right
    assert nearest_neighbours(pairs, SURE).tolist() == [1, 3]


def test_where_landmarks_are_dense_a_vague_single_pairing_is_worth_nothing():
    pairs = simple_pairs([0], [0], [(0.1, 0.0)], shared=1.0)
    assert joint_compatibility(pairs, SURE, 5.0).size == 0
    assert joint_compatibility(pairs, SURE, 0.05).tolist() == [0]


def test_worth_is_what_a_perfect_pairing_would_score():
    noise = np.array([np.diag([0.01, 0.04]), np.eye(2)])
    pairs = simple_pairs([0, 1], [0, 1], [(0.0, 0.0), (0.0, 0.0)], shared=0.0)
    pairs = pairs._replace(noise=noise)
    perfect = [joint(pairs, [i])[1] - math.log(5.0) for i in range(2)]
    np.testing.assert_allclose(worth(noise, 5.0), perfect)
    assert worth(noise, 5.0)[0] > 0 > worth(noise, 5.0)[1]


def test_each_landmark_is_the_nearest_neighbour_of_one_measurement_only():
    innovation = [(0.1, 0.0), (0.05, 0.0), (0.15, 0.0), (3.0, 0.0)]
    pairs = simple_pairs([0, 1, 1, 2], [0, 0, 1, 2], innovation, shared=0.0)
    assert nearest_neighbours(pairs, SURE).tolist() == [1]  # landmark 1 is for measurement 1 only
    pairs = simple_pairs([0, 1, 1], [0, 0, 1], [(0.1, 0.0), (0.12, 0.0), (0.15, 0.0)], shared=0.0)
    assert nearest_neighbours(pairs, SURE).tolist() == [0, 2]


def test_the_search_gives_up_in_time_and_still_finds_what_is_plain():
    """Twelve posts so close that all pairings would take for ever."""
    count = 12
    grid = [(m, lm) for m in range(count) for lm in range(count)]
    measurement, landmark = zip(*grid, strict=True)
    innovation = [(0.03 * (m - lm), 0.0) for m, lm in grid]
    pairs = simple_pairs(measurement, landmark, innovation, shared=0.05)
    found = joint_compatibility(pairs, SURE, 0.05)
    assert len(found) == count
    assert len(set(pairs.landmark[found])) == count
