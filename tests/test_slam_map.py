"""The map as users get it: walls counted from the map's origin, theta in [0, pi)."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import look, normalised

from laserfeatures import Pose2D, get_extractor
from laserfeatures.simulation import World
from laserfeatures.slam import EkfSlam
from laserfeatures.slam.map import _from_origin

ROOM = World.outline([(0, 0), (5, 0), (5, 4), (0, 4)])
START = Pose2D(3.0, 1.5, 2.5)
metres = st.floats(-10.0, 10.0)


@given(st.floats(-10.0, 10.0), metres, metres, metres)
def test_a_wall_is_the_same_line_counted_from_the_origin(alpha, rho, x, y):
    values, _ = _from_origin(np.array([alpha, rho]), np.eye(2), np.array([x, y]))
    theta, d = values
    assert 0 <= theta <= math.pi
    normal, other = (np.array([math.cos(t), math.sin(t)]) for t in (alpha, theta))
    foot = (x, y) + rho * normal  # a point on the wall
    assert abs(normal @ other) == pytest.approx(1.0)
    assert other @ foot == pytest.approx(d, abs=1e-7)


@given(st.floats(0.01, 3.1), st.integers(-2, 2), metres, metres, metres)
def test_its_covariance_is_carried_along(alpha, halves, rho, x, y):
    turned = alpha + halves * math.pi
    covariance, anchor = np.array([[4e-4, 1e-4], [1e-4, 9e-4]]), np.array([x, y])
    step = 1e-6
    numeric = np.stack(
        [
            (_from_origin(np.array([turned, rho]) + off, covariance, anchor)[0]
             - _from_origin(np.array([turned, rho]) - off, covariance, anchor)[0]) / (2 * step)
            for off in step * np.eye(2)
        ],
        axis=1,
    )  # fmt: skip
    _, found = _from_origin(np.array([turned, rho]), covariance, anchor)
    np.testing.assert_allclose(found, numeric @ covariance @ numeric.T, atol=1e-8)


def test_the_map_of_a_room_is_the_room():
    scan, _ = look(ROOM, view=2 * math.pi - 0.01, beams=361, sigma=0.003, pose=START)
    slam = EkfSlam(sightings=1)
    assert slam.map == ()
    for _ in range(3):
        slam.step(START, get_extractor("direct_hough")(scan), START)
    walls = [each for each in slam.map if each.kind == "wall"]
    corners = [each for each in slam.map if each.kind == "corner"]
    wanted = normalised([0, 0, math.pi / 2, math.pi / 2], [0, 5, 0, 4])
    found = np.array([each.values for each in walls])
    off = abs(found[:, None] - wanted[None])
    off[:, :, 0] = np.minimum(off[:, :, 0], math.pi - off[:, :, 0])
    off[:, :, 1] = abs(abs(found[:, None, 1]) - wanted[None, :, 1])
    assert sorted(off.sum(axis=2).argmin(axis=1)) == [0, 1, 2, 3]
    assert off.sum(axis=2).min(axis=1).max() < 0.03
    places = np.array([each.values for each in corners])
    true = np.array([(0, 0), (5, 0), (5, 4), (0, 4)])
    away = np.linalg.norm(places[:, None] - true[None], axis=2)
    assert sorted(away.argmin(axis=1)) == [0, 1, 2, 3]
    assert away.min(axis=1).max() < 0.03
    for each in slam.map:
        assert each.sightings == 3
        assert np.linalg.eigvalsh(each.covariance)[0] > 0
    for each in corners:
        np.testing.assert_allclose(each.ends, [each.values, each.values])
    for each in walls:
        theta, d = each.values
        np.testing.assert_allclose(each.ends @ (math.cos(theta), math.sin(theta)), d, atol=1e-9)
        assert np.linalg.norm(each.ends[1] - each.ends[0]) > 3.5


def test_a_landmark_is_a_copy_that_later_scans_leave_alone():
    scan, _ = look(ROOM, view=2 * math.pi - 0.01, sigma=0.003, pose=START)
    other, _ = look(ROOM, view=2 * math.pi - 0.01, sigma=0.02, seed=7, pose=START)
    slam = EkfSlam(sightings=1)
    slam.step(START, get_extractor("direct_hough")(scan), START)
    before = slam.map
    numbers = [(each.values.copy(), each.covariance.copy(), each.ends.copy()) for each in before]
    slam.step(START, get_extractor("direct_hough")(other))
    for each, (values, covariance, ends) in zip(before, numbers, strict=True):
        np.testing.assert_array_equal(each.values, values)
        np.testing.assert_array_equal(each.covariance, covariance)
        np.testing.assert_array_equal(each.ends, ends)
    assert any((now.values != was.values).any() for now, was in zip(slam.map, before, strict=True))
