"""The walls of a scan: fitted, merged, parted at corners, weighed."""

import math

import kernels
import numpy as np
import pytest
import reference_engine
from hypothesis import given
from hypothesis import strategies as st
from scenes import chain, look, needs_compiler, random_room

from laserfeatures import LaserScan
from laserfeatures.engine.partition import STRAY
from laserfeatures.engine.prices import PRICE, STRAY_PRICE

SIGMA = 0.005
COUNT = 600

seeds = st.integers(0, 2**32 - 1)
noises = st.tuples(st.floats(0.001, 0.05), st.floats(0, 0.02), st.floats(0, 0.02))


def labelled(walls, *, seed=0, beams=361, sigma=SIGMA, stray=0.0, **view):
    """Return the returns on some walls and the true label of each."""
    scan, hit = look(walls, sigma=sigma, seed=seed, beams=beams, **view)
    label = hit[scan.beams]
    label[np.random.default_rng(seed).random(label.size) < stray] = STRAY
    return kernels.weighed(scan, max(sigma, 1e-4)), label


def lines_of(found):
    """Return (c, s, d) of walls, (K, 3)."""
    return np.stack([found["c"], found["s"], found["d"]], axis=1)


def covariance_of(row):
    return np.array([[row["var_theta"], row["cov"]], [row["cov"], row["var_d"]]])


@given(seeds, noises, st.booleans())
def test_a_wall_is_the_line_of_least_squares(seed, noise, weighted):
    rng = np.random.default_rng(seed)
    theta, d = rng.uniform(-math.pi, math.pi), rng.uniform(0.3, 5)
    angles = theta + np.sort(rng.uniform(-1.3, 1.3, 40))
    ranges = d / np.cos(angles - theta) + rng.normal(0, 0.01, 40)
    points = kernels.weighed(LaserScan(angles=angles, ranges=ranges), *noise)
    label = rng.integers(-1, 2, points.x.size)
    label[:6] = [0, 1, 0, 1, 0, 1]
    lines, keep = None, np.ones(points.x.size)
    if weighted:
        lines = [(math.cos(turn), math.sin(turn), d) for turn in (theta, theta + 0.1)]
        cosine = reference_engine.directions(points) @ np.array(lines)[:, :2].T
        cosine = cosine[np.arange(label.size), np.maximum(label, 0)]
        keep = cosine**2 / (cosine**2 + points.floor)
    found = kernels.fit_walls(points, label, lines)
    assert len(found) == 2
    for k, row in enumerate(found):
        mine = np.flatnonzero(label == k)
        solution, spread, chi2 = reference_engine.fit(points, mine, keep[mine])
        expected = reference_engine.line(solution)
        assert math.atan2(row["s"], row["c"]) == pytest.approx(expected[0], abs=1e-8)
        assert row["d"] == pytest.approx(expected[1], rel=1e-8)
        assert row["chi2"] == pytest.approx(chi2, rel=1e-6, abs=1e-3)
        covariance = reference_engine.line_covariance(solution, spread)
        scale = np.sqrt(np.outer(*[np.diag(covariance)] * 2))
        np.testing.assert_allclose(covariance_of(row) / scale, covariance / scale, atol=1e-5)
        assert row["log_det"] == pytest.approx(-np.linalg.slogdet(covariance)[1], abs=1e-4)
        assert (row["points"], row["first"], row["last"]) == (len(mine), mine[0], mine[-1] + 1)


@needs_compiler
@pytest.mark.parametrize("theta", np.radians([-80, 0.5, 178]))
def test_errors_of_walls_are_as_large_as_they_are_said_to_be(theta):
    rng = np.random.default_rng(9)
    angles = theta + np.linspace(-0.9, 0.5, 60)
    errors, squares = [], []
    for _ in range(COUNT):
        ranges = 2.5 / np.cos(angles - theta) + rng.normal(0, SIGMA, 60)
        points = kernels.weighed(LaserScan(angles=angles, ranges=ranges), SIGMA)
        (row,) = kernels.settled(points, np.zeros(60, np.int64))
        side = 1 if 0 <= theta < math.pi else -1
        turn = math.atan2(row["s"], row["c"]) - theta
        error = np.array([turn - math.pi * round(turn / math.pi), row["d"] - side * 2.5])
        errors.append(error)
        squares.append(error @ np.linalg.solve(covariance_of(row), error))
    # Chi squared of two: the mean has the standard deviation 0.08. What does not vanish at grazing
    # incidence makes the covariance a little larger.
    assert 1.84 - 0.17 < np.mean(squares) < 2 + 0.17
    assert 0.93 < np.mean(np.array(squares) < 5.991) < 0.98
    bias = np.mean(errors, axis=0) / np.sqrt(np.diag(covariance_of(row)) / COUNT)
    assert (abs(bias) < 3.5).all()


def test_a_wall_of_returns_in_line_with_the_sensor_has_no_line():
    points = kernels.weighed(LaserScan(angles=[0.3, 0.3 + 1e-9], ranges=[1.0, 2.0]))
    (row,) = kernels.fit_walls(points, np.zeros(2, np.int64))
    assert row["chi2"] == math.inf
    assert kernels.prune(np.zeros(2, np.int64), np.array([row]), 2)[0].tolist() == [STRAY] * 2


@pytest.mark.parametrize("seed", range(5))
def test_halves_of_a_wall_are_joined(seed):
    points, label = labelled([[(2, -1.5), (2, -0.4)], [(2, 0.5), (2, 1.5)]], seed=seed)
    merged, found = kernels.merge_collinear(points, label)
    assert set(merged) == {0}
    assert found["points"].tolist() == [len(label), 0]
    once = kernels.settled(points, np.zeros(len(label), np.int64))[0]
    for name in ("c", "s", "d", "var_theta", "var_d"):
        assert found[name][0] == pytest.approx(once[name], rel=1e-2)
    assert (found["first"][0], found["last"][0]) == (0, len(label))


def test_three_pieces_of_a_wall_are_joined():
    pieces = [[(2, -2.0), (2, -1.0)], [(2, -0.5), (2, 0.5)], [(2, 1.0), (2, 2.0)]]
    points, label = labelled(pieces)
    assert set(kernels.merge_collinear(points, label)[0]) == {0}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("apart", [0.1, -0.1])
def test_parallel_walls_are_not_joined(seed, apart):
    walls = [[(2, -1.5), (2, -0.1)], [(2 + apart, 0.1), (2 + apart, 1.5)]]
    points, label = labelled(walls, seed=seed)
    merged, found = kernels.merge_collinear(points, label)
    np.testing.assert_array_equal(merged, label)
    assert found["points"].tolist() == [(label == k).sum() for k in range(2)]


def test_opposite_walls_that_no_line_explains_are_not_joined():
    angles = np.linspace(-0.4, 0.4, 20)
    ranges = np.tile(2 / np.cos(angles), 2)
    scan = LaserScan(angles=np.concatenate([angles, angles + math.pi]), ranges=ranges)
    points, label = kernels.weighed(scan, SIGMA), np.repeat([0, 1], 20)
    for name, sign in {"x": -1, "y": -1, "ux": -1, "uy": -1, "weight": 1}.items():
        values = getattr(points, name)
        values[20:] = sign * values[:20]  # to the last bit
    np.testing.assert_array_equal(kernels.merge_collinear(points, label)[0], label)


def test_walls_at_a_small_angle_are_not_joined():
    points, label = labelled(chain((2, -1.5), (2, 0), (2.15, 1.5)))
    np.testing.assert_array_equal(kernels.merge_collinear(points, label)[0], label)


@given(seeds)
def test_parting_at_corners_is_that_of_a_loop(seed):
    rng = np.random.default_rng(seed)
    world, pose = random_room(rng)
    points, label = labelled(world, seed=seed % 1000, beams=120, view=5.5, pose=pose, stray=0.05)
    found = kernels.settled(points, label)
    edges = np.flatnonzero(np.diff(label))
    for edge in edges[rng.random(edges.size) < 0.8]:  # returns of the next wall, or of the last
        shift = int(rng.integers(-4, 5))
        low, high = max(0, min(edge + 1, edge + 1 + shift)), max(edge + 1, edge + 1 + shift)
        label[low:high] = label[edge] if shift > 0 else label[edge + 1]
    parted = kernels.part_at_corners(points, label, found)
    expected = reference_engine.part_at_corners(points, label, lines_of(found))
    np.testing.assert_array_equal(parted, expected)


@pytest.mark.parametrize("shift", [-3, 0, 3])
@pytest.mark.parametrize(
    "walls",
    [
        chain((2, -1.5), (2, 1.2), (-0.5, 1.2)),
        chain((1.5, -1.5), (1.5, 0.2), (3, 1.5)),
        chain((2, -1), (1.5, 0.1), (2, 1)),
    ],
    ids=["inner", "edge", "outer"],
)
def test_walls_are_parted_at_the_bearing_of_their_corner(walls, shift):
    points, label = labelled(walls, sigma=0.001)
    found = kernels.settled(points, label)
    edge = np.flatnonzero(np.diff(label))[0] + 1
    wrong = label.copy()
    wrong[min(edge, edge + shift) : max(edge, edge + shift)] = label[
        edge if shift < 0 else edge - 1
    ]
    parted = kernels.part_at_corners(points, wrong, found)
    near = np.array([reference_engine.chi_squared(points, each) < 9 for each in lines_of(found)])
    may_change = near.all(axis=0)
    np.testing.assert_array_equal(parted[may_change], label[may_change])


def test_walls_that_cross_behind_the_sensor_stay_as_they_are():
    points, label = labelled([[(2, -0.5), (2.2, -0.02)], [(2.2, 0.02), (2, 0.5)]])
    found = kernels.settled(points, label)
    found["d"] *= -1
    np.testing.assert_array_equal(kernels.part_at_corners(points, label, found), label)


def test_returns_that_cost_less_as_strays_are_freed_of_known_walls():
    points, label = labelled(chain((2, -1.5), (2, 1.2), (-0.5, 1.2)))
    found = kernels.settled(points, label)
    off = math.sqrt(STRAY_PRICE) * 1.2 * SIGMA
    changed = points._replace(x=points.x + off * points.ux, y=points.y + off * points.uy)
    free = kernels.free_outliers(changed, label, found, 1)
    chi2 = reference_engine.chi_squared(changed, lines_of(found)[0])
    np.testing.assert_array_equal(free == STRAY, (label == 0) & (chi2 > STRAY_PRICE))
    assert (free == STRAY).any()


def test_walls_of_few_returns_are_dropped_and_the_others_numbered_anew():
    points, _ = labelled([[(2, -1), (2, 1)]], beams=91)
    label = np.full(points.x.size, STRAY)
    label[:3], label[3:8], label[10:14] = 0, 1, 3
    expected = np.full(points.x.size, STRAY)
    expected[3:8], expected[10:14] = 0, 1
    pruned, found = kernels.prune(label, kernels.settled(points, label), 4)
    np.testing.assert_array_equal(pruned, expected)
    assert found["points"].tolist() == [5, 4]


def evidence_of(walls, *, stray=0.0, seed=0, beams=181):
    """Return the evidence of two walls, and what explaining without each gives."""
    points, label = labelled(walls, seed=seed, stray=stray, beams=beams)
    found = kernels.settled(points, label)
    lines = lines_of(found)
    expected = [reference_engine.evidence(points, label, lines, k) for k in range(len(lines))]
    return kernels.weigh_evidence(points, label, found), expected


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("bend", [0.0, 0.02, 0.1, 1.0])
def test_the_evidence_of_a_wall_is_what_is_lost_without_it(bend, seed):
    evidence, expected = evidence_of(chain((2, -1), (2, 0), (2 + bend, 1)), seed=seed)
    np.testing.assert_allclose(evidence, expected, rtol=1e-9)
    if bend == 1.0:
        assert (evidence > 50).all()


def test_the_evidence_is_the_same_where_strays_are_among_the_returns():
    walls = chain((2, -1), (2, 0), (2.04, 1))
    for seed in range(5):
        np.testing.assert_allclose(*evidence_of(walls, stray=0.1, seed=seed), rtol=1e-9)


def test_a_wall_alone_is_worth_its_strays_less_its_price():
    points, label = labelled([[(2, -0.2), (2, 0.2)]], sigma=0.0)
    (evidence,) = kernels.weigh_evidence(points, label, kernels.settled(points, label))
    assert evidence == pytest.approx(0.5 * (len(label) * STRAY_PRICE - PRICE), rel=1e-3)


def growth(walls, told, *, roughness=0.0, seed=0):
    """Return by how much the covariances of walls grow where a noise is told."""
    points, label = labelled(walls, seed=seed)
    kernels.weigh(points, told, 0.0, roughness)
    return kernels.inflate_covariances(points, kernels.settled(points, label))


CORNER = chain((2, -1.5), (2, 1.2), (-0.5, 1.2))


def test_covariances_stay_where_the_noise_explains_the_walls():
    ratios = np.array([growth(CORNER, SIGMA, seed=seed) for seed in range(20)])
    assert (ratios >= 1).all()
    assert np.mean(ratios) < 1.5
    np.testing.assert_allclose(growth(CORNER, 2 * SIGMA), 1.0, rtol=1e-4)


def test_covariances_grow_with_what_the_noise_does_not_explain():
    growths = [growth(CORNER, told).min() for told in (SIGMA, SIGMA / 2, SIGMA / 4)]
    assert growths[0] < growths[1] < growths[2]
    assert growths[1] > 2


def test_covariances_grow_with_the_roughness_told():
    growths = [growth(CORNER, SIGMA, roughness=rough).min() for rough in (0, SIGMA / 2, SIGMA)]
    assert growths[0] < growths[1] < growths[2]


def test_no_walls_have_no_covariances():
    points, _ = labelled(CORNER)
    label = np.full(points.x.size, STRAY)
    assert kernels.inflate_covariances(points, kernels.fit_walls(points, label)).size == 0
