import math

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import ORIGIN, wall

from laserfeatures import Pose2D
from laserfeatures.simulation import Scanner, World, hallway

seeds = st.integers(0, 10**6).map(np.random.default_rng)


@given(seeds, st.integers(1, 6))
def test_rays_meet_the_walls_of_the_slow_twin(rng, count):
    walls = rng.uniform(-5, 5, (count, 2, 2))
    pose = Pose2D(*rng.uniform(-3, 3, 2), rng.uniform(-9, 9))
    scanner = Scanner(beams=13, field_of_view=rng.uniform(0.1, 6.2))
    ranges, hit = scanner.cast(World(walls=walls), pose)
    expected = [reference.cast(walls, pose.x, pose.y, pose.theta + a) for a in scanner.angles]
    np.testing.assert_allclose(ranges, [r for r, _ in expected], rtol=1e-9)
    assert hit.tolist() == [k for _, k in expected]


def test_the_nearer_of_two_walls_hides_the_other():
    world = World(walls=[wall(0.0, 3.0, -9, 9), wall(0.0, 2.0, 0.0, 9)])
    ranges, hit = Scanner(beams=3, field_of_view=1.0).cast(world, ORIGIN)
    far = math.cos(0.5)
    np.testing.assert_allclose(ranges, [3 / far, 2, 2 / far])
    assert hit.tolist() == [0, 1, 1]


def test_a_wall_behind_the_beams_gives_no_return():
    behind = World(walls=[wall(0.0, -2.0, -1, 1)])
    ranges, hit = Scanner(beams=5, field_of_view=1.0).cast(behind, ORIGIN)
    assert np.isinf(ranges).all()
    assert (hit == -1).all()


def test_a_turned_scanner_sees_the_turned_world():
    world = World(walls=[wall(1.2, 2.0, -1.0, 1.0)])
    there, _ = Scanner(beams=181).cast(world, Pose2D(0, 0, 1.2))
    assert there[90] == pytest.approx(2.0)
    rng = np.random.default_rng(0)
    points = Scanner(beams=181, range_sigma=0).scan(world, Pose2D(0, 0, 1.2), rng).points
    np.testing.assert_allclose(points[:, 0], 2.0)


def test_beams_are_centred_on_the_x_axis_and_evenly_spaced():
    angles = Scanner(beams=5, field_of_view=2.0).angles
    np.testing.assert_allclose(angles, [-1, -0.5, 0, 0.5, 1])


def test_noise_has_the_mean_and_deviation_asked_for():
    scanner = Scanner(beams=181, range_sigma=0.02)
    world, poses = hallway()
    truth, hit = scanner.cast(world, poses[0])
    rng = np.random.default_rng(1)
    errors = np.array([scanner.scan(world, poses[0], rng).ranges - truth for _ in range(200)])
    errors = errors[:, hit >= 0].ravel()
    assert errors.size > 30000
    assert abs(errors.mean()) < 4 * 0.02 / math.sqrt(errors.size)
    assert errors.std() == pytest.approx(0.02, rel=0.02)
    assert np.quantile(abs(errors), 0.6827) == pytest.approx(0.02, rel=0.03)  # Gaussian


def test_the_same_seed_gives_the_same_scan_and_another_does_not():
    world, poses = hallway()
    scans = [
        Scanner().scan(world, poses[0], np.random.default_rng(seed)).ranges for seed in (3, 3, 4)
    ]
    np.testing.assert_array_equal(scans[0], scans[1])
    assert (scans[0] != scans[2]).any()


def test_a_scan_tells_where_and_when_it_was_taken_and_what_the_scanner_can_see():
    world, poses = hallway()
    scan = Scanner(range_max=4.0).scan(world, poses[2], np.random.default_rng(0), stamp=7.5)
    assert (scan.pose, scan.stamp, scan.range_max) == (poses[2], 7.5, 4.0)
    assert 0 < len(scan.points) < 181
    assert np.hypot(*scan.points.T).max() < 4.0


def test_an_outline_is_closed():
    world = World.outline([(0, 0), (1, 0), (1, 1)], [(5, 5), (6, 5), (6, 6), (5, 6)])
    assert world.walls.shape == (7, 2, 2)
    assert world.walls[:3].tolist() == [[[1, 1], [0, 0]], [[0, 0], [1, 0]], [[1, 0], [1, 1]]]


def test_from_each_pose_of_the_hallway_every_beam_meets_a_wall():
    world, poses = hallway()
    for pose in poses:
        ranges, hit = Scanner(beams=360, field_of_view=6.28).cast(world, pose)
        assert (hit >= 0).all()
        assert ranges.min() > 0.3


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"beams": 1}, "beams must be >= 2, got 1"),
        ({"field_of_view": 0.0}, r"field_of_view must be in \(0, 2 pi\] rad, got 0\.0"),
        ({"field_of_view": 6.3}, r"field_of_view must be in \(0, 2 pi\] rad, got 6\.3"),
        ({"range_max": 0.0}, r"range_max must be > 0 m, got 0\.0"),
        ({"range_sigma": -0.1}, r"range_sigma must be >= 0 m, got -0\.1"),
    ],
)
def test_a_scanner_that_makes_no_sense_is_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        Scanner(**parameters)


@pytest.mark.parametrize(
    ("walls", "message"),
    [
        ([[(0, 0), (0, 0)]], "wall 0 must have a finite length > 0"),
        ([[(0, 0), (1, 0)], [(0, 0), (0, math.nan)]], "wall 1 must have a finite length > 0"),
        ([[(0, 0), (1, math.inf)]], "wall 0 must have a finite length > 0"),
        ([(0, 0)], r"walls must have shape \(n, 2, 2\), got \(1, 2\)"),
    ],
)
def test_a_wall_that_is_none_is_refused(walls, message):
    with pytest.raises(ValueError, match=message):
        World(walls=walls)
