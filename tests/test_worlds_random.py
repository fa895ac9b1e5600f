import math

import numpy as np
import pytest

from laserfeatures import Pose2D
from laserfeatures.simulation import (
    Scanner,
    World,
    random_corridor,
    random_hallway,
    random_office,
    random_room,
)
from laserfeatures.simulation.random_sides import walk

ALL_ROUND = Scanner(beams=360, field_of_view=2 * math.pi * 359 / 360, range_max=100.0)


def room(seed):
    world, pose = random_room(seed, poles=seed % 7)
    return world, [pose]


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("family", [room, random_corridor, random_hallway])
def test_from_every_pose_there_is_a_clear_view_and_a_wall_all_round(family, seed):
    world, poses = family(seed)
    assert poses
    for pose in poses:
        assert world.distances((pose.x, pose.y)).min() > 0.4
        ranges, surface = ALL_ROUND.cast(world, pose)
        assert (surface >= 0).all()
        assert ranges.min() > 0.4


@pytest.mark.parametrize("family", [room, random_corridor, random_hallway, random_office])
def test_the_same_seed_gives_the_same_world_and_another_does_not(family):
    first, second, other = repr(family(4)), repr(family(4)), repr(family(5))
    assert first == second
    assert first != other


def test_random_rooms_are_those_that_the_benchmarks_have_always_had():
    world, pose = random_room(7)
    assert world.walls.shape == (20, 2, 2)
    assert world.walls.sum() == pytest.approx(254.76530775573104, rel=1e-12)
    assert pose == Pose2D(3.1944692781281754, 5.459050772761205, 0.811952503519767)


def test_poles_change_nothing_else_of_a_room():
    for seed in range(30):
        (plain, pose), (poles, same) = random_room(seed), random_room(seed, poles=6)
        np.testing.assert_array_equal(plain.walls, poles.walls)
        assert pose == same
        assert poles.poles.shape == (6, 3)
        assert World(walls=plain.walls).distances(poles.poles[:, :2]).min() > 0


def test_a_scaled_room_is_the_same_but_larger():
    (plain, pose), (large, far) = random_room(3), random_room(3, scale=2.0, poles=2)
    np.testing.assert_array_equal(2.0 * plain.walls, large.walls)
    assert (far.x, far.y, far.theta) == (2 * pose.x, 2 * pose.y, pose.theta)
    for seed in range(100):
        world, pose = random_room(seed, scale=0.5, poles=3)
        assert world.distances((pose.x, pose.y)).min() > 0.4


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"scale": 0.4}, r"scale must be >= 0\.5, got 0\.4"),
        ({"scale": math.nan}, r"scale must be >= 0\.5, got nan"),
        ({"poles": -1}, "poles must be 0 to 20, got -1"),
        ({"poles": 21}, "poles must be 0 to 20, got 21"),
    ],
)
def test_a_room_that_makes_no_sense_is_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        random_room(1, **parameters)


def turns(walls):
    """Return the acute angles between neighbours of a closed outline [rad]."""
    step = walls[:, 1] - walls[:, 0]
    heading = np.arctan2(step[:, 1], step[:, 0])
    return np.arccos(abs(np.cos(heading - np.roll(heading, 1))))


@pytest.mark.parametrize("family", [random_corridor, random_hallway])
def test_corridors_have_doors_oblique_walls_furniture_and_colours(family):
    worlds = [family(seed)[0] for seed in range(40)]
    oblique = [(abs(turns(w.walls) - math.pi / 2) > 0.1).any() for w in worlds]
    assert 0.3 < np.mean(oblique) <= 1.0
    assert sum(len(w.walls) > 12 for w in worlds) > 30
    assert any(len(w.boxes) for w in worlds)
    assert any(len(w.poles) for w in worlds)
    shares = np.concatenate([w.reflectivity for w in worlds])
    assert shares.min() < 0.25
    assert shares.max() > 0.85


def test_the_hallway_is_an_l():
    for seed in range(20):
        _, poses = random_hallway(seed)
        way = np.array([(p.x, p.y) for p in poses])
        assert way[-1, 1] > way[0, 1] + 2
        assert way[-1, 0] > way[0, 0] + 4


@pytest.mark.parametrize("seed", range(25))
def test_an_office_is_a_loop_that_a_robot_can_drive(seed):
    plan = random_office(seed)
    path = plan.drive.waypoints
    points, _ = walk(path, 0.02)
    assert plan.world.distances(points).min() > 0.4
    again = np.hypot(*(path[:-1] - path[-1]).T)
    assert again.min() == 0  # the end has been passed before
    round_ = path[int(again.argmin()) :]
    assert np.hypot(*np.diff(round_, axis=0).T).sum() >= 60
    corners = path[[np.argmin(path @ d) for d in ((1, 1), (-1, 1), (-1, -1), (1, -1))]]
    assert 2 * (math.dist(corners[0], corners[1]) + math.dist(corners[1], corners[2])) >= 60
    assert len(plan.world.boxes) >= 5


def test_a_walk_goes_along_its_path_in_even_steps():
    points, heading = walk(np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)]), 0.4)
    expected = [(0, 0), (0.4, 0), (0.8, 0), (1, 0.2), (1, 0.6), (1, 1.0), (1, 1.4), (1, 1.8)]
    np.testing.assert_allclose(points, expected)
    np.testing.assert_allclose(heading, [0.0] * 3 + [math.pi / 2] * 5)
