import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures import Pose2D
from laserfeatures.simulation import Scanner, World

WORLD = World(
    walls=[[(0, 0), (4, 0)], [(4, 0), (4, 3)]],
    boxes=[(1, 2, 1.0, 0.4, 0.0), (3, 2, 1.0, 0.4, math.pi / 4)],
    poles=[(2, 1, 0.2)],
)


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        (1.0, 2.0, r"the sensor at \(1, 2\) is inside box 0"),
        (1.49, 2.0, r"the sensor at \(1\.49, 2\) is inside box 0"),
        (3.3, 2.3, r"the sensor at \(3\.3, 2\.3\) is inside box 1"),
        (3.3, 1.7, None),
        (2.1, 1.0, r"the sensor at \(2\.1, 1\) is inside pole 0"),
        (2.2005, 1.0, r"the sensor at \(2\.2005, 1\) is on pole 0"),
        (2.2, 1.0, r"the sensor at \(2\.2, 1\) is on pole 0"),
        (2.202, 1.0, None),
        (1.0, 1.7991, r"the sensor at \(1, 1\.7991\) is on box 0"),
        (1.0, 1.798, None),
        (2.0, 0.0005, r"the sensor at \(2, 0\.0005\) is on wall 0"),
        (4.0, 0.0, r"the sensor at \(4, 0\) is on wall 0"),
        (4.0005, 3.0, r"the sensor at \(4\.0005, 3\) is on wall 1"),
        (4.0, 3.002, None),
        (-5.0, -5.0, None),
        (math.nan, 0.0, "the sensor must have a finite pose"),
    ],
)
def test_a_sensor_cannot_stand_in_or_on_anything(x, y, message):
    pose = Pose2D(x, y, 0.3)
    if message is None:
        WORLD.check_pose(pose)
        Scanner().scan(WORLD, pose, np.random.default_rng(0))
        return
    for look in (WORLD.check_pose, lambda p: Scanner().cast(WORLD, p)):
        with pytest.raises(ValueError, match=message):
            look(pose)
    with pytest.raises(ValueError, match=message):
        Scanner().observe(WORLD, pose, np.random.default_rng(0))


def test_an_empty_world_can_be_scanned():
    seen = Scanner().observe(World(), Pose2D(0, 0, 0), np.random.default_rng(0))
    assert not seen.scan.valid.any()
    assert (seen.surface == -1).all()


@given(st.integers(0, 10**6))
def test_distances_are_those_to_many_points_of_each_object(seed):
    rng = np.random.default_rng(seed)
    world = World(
        walls=rng.uniform(-3, 3, (2, 2, 2)),
        boxes=rng.uniform((-3, -3, 0.5, 0.5, -3), (3, 3, 2, 2, 3), (2, 5)),
        poles=rng.uniform((-3, -3, 0.2), (3, 3, 1), (2, 3)),
    )
    points = rng.uniform(-4, 4, (20, 2))
    share = np.linspace(0, 1, 2001)[:, None]
    rim = [start + share * (end - start) for start, end in world.sides]
    turn = 2 * math.pi * share
    rim += [(x, y) + r * np.hstack([np.cos(turn), np.sin(turn)]) for x, y, r in world.poles]
    surfaces = [np.hypot(*(points[:, None] - near).T).min(axis=0) for near in rim]
    expected = np.array([
        np.min([surfaces[s] for s in np.flatnonzero(world.object_of == k)], axis=0)
        for k in range(6)
    ]).T  # fmt: skip
    got = world.distances(points)
    np.testing.assert_allclose(abs(got), expected, atol=2e-3)
    for k, (x, y, length, width, heading) in enumerate(world.boxes):
        at = Pose2D(x, y, heading).transform([(0.4 * length, -0.4 * width), (0.6 * length, 0)])
        assert (world.distances(at)[:, 2 + k] < 0).tolist() == [True, False]
    assert (world.distances(world.poles[:, :2])[[0, 1], [4, 5]] == -world.poles[:, 2]).all()


def test_surfaces_know_their_object_and_its_colour():
    world = World(
        walls=[[(0, 0), (1, 0)]], boxes=[(3, 3, 1, 1, 0)], poles=[(6, 6, 1)],
        reflectivity=[0.1, 0.2, 0.3],
    )  # fmt: skip
    assert world.object_of.tolist() == [0, 1, 1, 1, 1, 2]
    assert world.reflectivity_of_surface.tolist() == [0.1, 0.2, 0.2, 0.2, 0.2, 0.3]


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"boxes": [(0, 0, 0, 1, 0)]}, "box 0 must have a finite area > 0"),
        ({"boxes": [(0, 0, 1, 1, math.inf)]}, "box 0 must have a finite area > 0"),
        ({"poles": [(0, 0, -1)]}, "pole 0 must have a finite radius > 0"),
        ({"poles": [(0, 0, 1)], "reflectivity": [0.0]}, r"reflectivity 0 must be in \(0, 1\]"),
        ({"poles": [(0, 0, 1)], "reflectivity": [1.1]}, r"reflectivity 0 must be in \(0, 1\]"),
        ({"poles": [(0, 0, 1)], "reflectivity": []}, r"reflectivity must have shape \(1\)"),
        ({"walls": [[(0, 0), (1e-12, 0)]]}, "wall 0 must have a finite length > 0"),
    ],
)
def test_a_world_that_makes_no_sense_is_refused(parts, message):
    with pytest.raises(ValueError, match=message):
        World(**parts)
