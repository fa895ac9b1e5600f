import math
import re
import sys
from pathlib import Path

import clouds
import numpy as np
import pytest
from clouds import cloud_of, o3d
from hypothesis import given
from hypothesis import strategies as st
from scenes import chain, random_room, scan_of

import laserfeatures as lf
from laserfeatures import point_clouds
from laserfeatures.optional import install_line
from laserfeatures.simulation import Scanner

PAGE = Path(__file__).parents[1] / "docs/point-clouds.md"
FULL_TURN = Scanner(beams=720, field_of_view=2 * math.pi * 719 / 720, range_max=30.0)


def seen(seed=1):
    """Return the scan of a room, some of its beams without return, and its features."""
    rng = np.random.default_rng(seed)
    world, pose = random_room(rng)
    scan = FULL_TURN.scan(world, pose, rng)
    ranges = np.where(rng.uniform(size=len(scan)) < 0.1, math.inf, scan.ranges)
    scan = lf.LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
    return scan, lf.get_extractor("direct_hough")(scan)


def test_points_come_back_to_the_last_bit():
    scan, features = seen()
    cloud = point_clouds.scan_to_point_cloud(scan, height=0.4)
    assert isinstance(cloud, o3d.geometry.PointCloud)
    assert set(np.asarray(cloud.points)[:, 2]) == {0.4}
    back = point_clouds.point_cloud_to_points(cloud)
    np.testing.assert_array_equal(back, scan.points)
    corners = point_clouds.corners_to_point_cloud(features)
    assert len(features.corners) > 4
    back = point_clouds.point_cloud_to_points(corners)
    np.testing.assert_array_equal(back, features.corners.positions)


def test_segments_come_back_to_the_last_bit():
    features = seen()[1]
    lines = point_clouds.features_to_line_set(features, height=-0.1)
    assert isinstance(lines, o3d.geometry.LineSet)
    assert set(np.asarray(lines.points)[:, 2]) == {-0.1}
    assert len(lines.lines) == len(features.segments) > 4
    back = point_clouds.line_set_to_endpoints(lines)
    np.testing.assert_array_equal(back, features.segments.endpoints)


def test_what_is_returned_does_not_change_with_the_cloud():
    scan, features = seen()
    cloud = point_clouds.scan_to_point_cloud(scan)
    lines = point_clouds.features_to_line_set(features)
    points = point_clouds.point_cloud_to_points(cloud)
    endpoints = point_clouds.line_set_to_endpoints(lines)
    cloud.translate((1.0, 0.0, 0.0))
    lines.translate((1.0, 0.0, 0.0))
    np.testing.assert_array_equal(points, scan.points)
    np.testing.assert_array_equal(endpoints, features.segments.endpoints)


def test_lines_may_share_points():
    points = [(0, 0, 0), (1, 0, 0), (1, 2, 0)]
    lines = o3d.geometry.LineSet(
        o3d.utility.Vector3dVector(points), o3d.utility.Vector2iVector([(0, 1), (2, 1)])
    )
    endpoints = point_clouds.line_set_to_endpoints(lines)
    assert endpoints.tolist() == [[[0, 0], [1, 0]], [[1, 2], [1, 0]]]
    lines.lines = o3d.utility.Vector2iVector([(0, 1), (1, 3)])
    with pytest.raises(ValueError, match=r"points 0 to 2 of the line set, got 0 to 3"):
        point_clouds.line_set_to_endpoints(lines)


def test_a_scan_without_returns_is_an_empty_cloud():
    scan = lf.LaserScan(angles=[0.0, 0.1], ranges=[math.inf, 0.0])
    features = lf.get_extractor("direct_hough")(scan)
    cloud = point_clouds.scan_to_point_cloud(scan)
    assert point_clouds.point_cloud_to_points(cloud).shape == (0, 2)
    lines = point_clouds.features_to_line_set(features)
    assert point_clouds.line_set_to_endpoints(lines).shape == (0, 2, 2)
    assert len(point_clouds.corners_to_point_cloud(features).points) == 0
    assert len(point_clouds.point_cloud_to_scan(cloud)) == 0
    back = point_clouds.point_cloud_to_scan(cloud, angles=scan.angles)
    assert not back.valid.any()
    assert len(back) == 2


def test_a_scan_comes_back_without_its_silent_beams():
    scan = seen()[0]
    cloud = point_clouds.scan_to_point_cloud(scan)
    back = point_clouds.point_cloud_to_scan(cloud, range_max=30.0, stamp=4.5)
    assert len(back) == scan.beams.size < len(scan)
    np.testing.assert_allclose(back.angles, scan.angles[scan.beams], rtol=0, atol=1e-12)
    np.testing.assert_allclose(back.ranges, scan.ranges[scan.beams], rtol=0, atol=1e-12)
    assert (back.range_max, back.stamp) == (30.0, 4.5)


@given(
    first=st.floats(-7, 7),
    view=st.floats(0.1, 2 * math.pi - 0.01),
    ranges=st.lists(st.floats(0.01, 100) | st.just(math.inf), min_size=2, max_size=60),
)
def test_with_its_angles_every_beam_comes_back(first, view, ranges):
    scan = lf.LaserScan.uniform(ranges, first, view / (len(ranges) - 1))
    cloud = point_clouds.scan_to_point_cloud(scan)
    back = point_clouds.point_cloud_to_scan(cloud, angles=scan.angles)
    np.testing.assert_array_equal(back.angles, scan.angles)
    np.testing.assert_array_equal(back.valid, scan.valid)
    np.testing.assert_allclose(back.points, scan.points, rtol=0, atol=1e-12)
    np.testing.assert_allclose(back.ranges, scan.ranges, rtol=0, atol=1e-12)


@pytest.mark.parametrize("first", [-math.pi, 0.0])
def test_both_ends_of_a_full_turn_come_back(first):
    scan = lf.LaserScan(angles=first + np.linspace(0, 2 * math.pi, 9), ranges=np.arange(1.0, 10.0))
    cloud = point_clouds.scan_to_point_cloud(scan)
    back = point_clouds.point_cloud_to_scan(cloud, angles=scan.angles)
    np.testing.assert_allclose(back.ranges, scan.ranges, rtol=0, atol=1e-12)


def test_of_points_on_one_beam_the_nearest_counts():
    cloud = cloud_of([(3, 0, 5), (2, 0, 0), (4, 0, 0), (0, 0, 1), (math.nan, 1, 1), (0, 1, 0)])
    for angles in (None, [0.0, math.pi / 2]):
        scan = point_clouds.point_cloud_to_scan(cloud, angles=angles)
        np.testing.assert_allclose(scan.angles, [0.0, math.pi / 2])
        assert scan.ranges.tolist() == [2.0, 1.0]


@pytest.mark.parametrize(
    ("angles", "complaint"),
    [
        ([0.0, 0.2], r"on one of the beams, got one at 0\.1 rad, 0\.1 rad off the nearest"),
        ([3.0, 3.1], r"on one of the beams, got one at 0\.1 rad"),
        ([0.2, 0.0], "strictly increasing"),
        ([], "must be those of 1 points, got none"),
    ],
)
def test_angles_that_are_not_the_clouds(angles, complaint):
    cloud = cloud_of([(math.cos(0.1), math.sin(0.1), 0)])
    with pytest.raises(ValueError, match=complaint):
        point_clouds.point_cloud_to_scan(cloud, angles=angles)


TAKERS = [
    (point_clouds.point_cloud_to_points, "PointCloud"),
    (point_clouds.point_cloud_to_scan, "PointCloud"),
    (point_clouds.line_set_to_endpoints, "LineSet"),
    (lambda cloud: point_clouds.slice_point_cloud(cloud, 0, 1), "PointCloud or .N, 3. array"),
]


@pytest.mark.parametrize(("function", "wanted"), TAKERS)
def test_other_things_than_open3ds_legacy_geometries_are_refused(function, wanted):
    tensors = o3d.t.geometry.PointCloud(), o3d.t.geometry.LineSet()
    others = o3d.geometry.TriangleMesh(), [[1.0, 2.0, 3.0]], None
    for geometry in tensors + others:
        with pytest.raises(TypeError, match=f"expected an open3d.geometry.{wanted}, got a"):
            function(geometry)
    for geometry in tensors:
        with pytest.raises(TypeError, match=r"of Open3D's tensor kind; .* to_legacy\(\)$"):
            function(geometry)


def test_without_open3d_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "open3d", None)
    scan = scan_of(*chain((2, -1), (2, 1)))
    with pytest.raises(lf.MissingDependencyError, match=re.escape(install_line("open3d"))):
        point_clouds.scan_to_point_cloud(scan)
    array = np.array([[2.0, 0.0, 0.4]])
    assert point_clouds.slice_point_cloud(array, 0.3, 0.5).points.shape == (1, 2)


def test_the_rooms_corners_are_found_in_its_slice():
    scan = point_clouds.slice_point_cloud(clouds.room(), *clouds.BAND)
    corners = lf.get_extractor("direct_hough")(scan).corners
    clouds.check_corners(corners.positions, corners.real, 1e-3)


def test_the_pages_python_finds_four_corners_and_takes_them_there_and_back():
    names = {}
    for code in re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL):
        exec(compile(code, PAGE.name, "exec"), names)  # noqa: S102 - our own page
    off = names["corners"][:, None] - np.array([[0, 0], [0, 4], [6, 0], [6, 4]])
    assert sorted(np.hypot(*off.T).argmin(axis=0)) == [0, 1, 2, 3]
    assert np.hypot(*off.T).min(axis=0).max() < 1e-3
    assert len(names["marks"].points) == 4
