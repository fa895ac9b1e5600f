"""The virtual scanner, on arrays: Open3D is not needed."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import laserfeatures as lf
from laserfeatures.point_clouds import slice_point_cloud
from laserfeatures.point_clouds.slicing import CLEARANCE

ANYWHERE = st.floats(-5, 5, allow_subnormal=False)
CLOUDS = st.lists(st.tuples(ANYWHERE, ANYWHERE, st.floats(-1, 1)), min_size=1, max_size=40)


def wall(x=2.0, *, sigma=0.0, tilt=0.0, points=40_000, seed=0):
    """Return points of a wall before the sensor, 4 m wide, turned by `tilt` about its middle."""
    rng = np.random.default_rng(seed)
    along, off = rng.uniform(-2, 2, points), rng.normal(0, sigma, points)
    c, s = math.cos(tilt), math.sin(tilt)
    return np.stack([x + c * off - s * along, s * off + c * along, rng.uniform(0, 1, points)], 1)


def by_hand(points, low, high, beams, max_gap, min_points):
    """Return beam and range of each surface seen; the slow twin, without the rule for edges."""
    seen = {}
    for x, y, z in points:
        if low <= z < high and (x or y):
            share = (math.atan2(y, x) + math.pi) / (2 * math.pi)
            seen.setdefault(min(int(share * beams), beams - 1), []).append((math.hypot(x, y), x, y))
    result = {}
    for beam, returns in seen.items():
        surfaces = []
        for r, x, y in sorted(returns):
            if not surfaces or r - surfaces[-1][-1][0] > max_gap:
                surfaces.append([])
            surfaces[-1].append((r, x, y))
        enough = min(min_points, max(map(len, surfaces)))
        first = next(surface for surface in surfaces if len(surface) >= enough)
        result[beam] = np.mean([(x, y) for _, x, y in first], axis=0)
    return result


@given(CLOUDS, st.integers(3, 50), st.sampled_from([0.01, 0.5, 2.0]), st.integers(1, 4))
def test_the_scan_is_that_of_a_loop(points, beams, max_gap, min_points):
    points = np.array([*points, (3.0, 0.0, 0.0)])  # the last one is in the band
    points += np.array([0.0137, 0.0071, 0.0])  # off the borders of bins
    near = np.hypot(*points[abs(points[:, 2]) < 0.5, :2].T) < CLEARANCE
    assume(near.sum() < min_points)
    scan = slice_point_cloud(points, -0.5, 0.5, beams=beams, max_gap=max_gap, min_points=min_points)
    assert len(scan) == beams
    expected = by_hand(points, -0.5, 0.5, beams, max_gap, min_points)
    assert scan.beams.tolist() == sorted(expected)
    inside = points[(points[:, 2] >= -0.5) & (points[:, 2] < 0.5), :2]
    for beam, point in zip(scan.beams, scan.points, strict=True):
        is_mean = np.allclose(point, expected[beam], rtol=0, atol=1e-9)
        is_one = np.isclose(inside, point, rtol=0, atol=1e-9).all(axis=1).any()
        assert is_mean or is_one  # where surfaces scatter unlike each other


@pytest.mark.parametrize("tilt", [0, 20, 50, 70])
def test_a_noisy_wall_stays_where_it_is(tilt):
    tilt = math.radians(tilt)
    scan = slice_point_cloud(wall(sigma=0.01, tilt=tilt), 0.3, 0.5)
    off = (scan.points - (2.0, 0.0)) @ (math.cos(tilt), math.sin(tilt))
    assert abs(off.mean()) < 6e-4  # the nearest points of the bins are 2 cm before it
    assert np.abs(np.median(off)) < 6e-4
    assert off.std() < 0.005


def test_a_wall_without_noise_is_seen_to_the_last_digits():
    scan = slice_point_cloud(wall(tilt=0.5), 0.3, 0.5)
    off = (scan.points - (2.0, 0.0)) @ (math.cos(0.5), math.sin(0.5))
    assert np.abs(off).max() < 1e-12
    assert np.isfinite(scan.angles).all()


def test_an_edge_is_not_put_into_the_air():
    y = np.linspace(-1, 1, 4001)
    points = np.concatenate([
        np.stack([np.full_like(y, 1.0037), y, 0 * y], axis=1),
        np.stack([y, np.full_like(y, 1.0037), 0 * y], axis=1),
    ])  # fmt: skip
    scan = slice_point_cloud(points, -1, 1, beams=90)
    assert np.abs(scan.points - 1.0037).min(axis=1).max() < 1e-9


def test_what_lies_behind_is_hidden():
    scan = slice_point_cloud(np.concatenate([wall(3.0), wall(2.0)]), 0.3, 0.5)
    assert np.abs(scan.points[:, 0] - 2.0).max() < 1e-12


def test_heights_outside_the_band_do_not_count():
    low, high = wall(1.0) - [0, 0, 0.7], wall(1.0) - [0, 0, -0.5]
    border = [[1.0, 0.0, 0.5], [1.5, 0.0, 0.3]]
    scan = slice_point_cloud(np.concatenate([low, high, wall(), border]), 0.3, 0.5, min_points=1)
    assert sorted(set(scan.points[:, 0].round(9))) == [1.5, 2.0]


def test_stray_points_do_not_replace_a_wall():
    stray = np.array([[1.0, 0.001, 0.4], [1.5, 0.001, 0.4], [1.0, 0.5, 0.4]])
    clean = slice_point_cloud(wall(), 0.3, 0.5)
    dirty = slice_point_cloud(np.concatenate([wall(), stray]), 0.3, 0.5)
    np.testing.assert_array_equal(dirty.points, clean.points)
    believed = slice_point_cloud(np.concatenate([wall(), stray]), 0.3, 0.5, min_points=1)
    assert np.sum(believed.points[:, 0] < 1.9) == 2


def test_a_sparse_cloud_needs_no_more_than_a_point_a_beam():
    points = [[2.0, y, 0.4] for y in np.linspace(-1, 1, 21)]
    scan = slice_point_cloud(np.array(points), 0.3, 0.5)
    np.testing.assert_allclose(scan.points, np.array(points)[:, :2], rtol=0, atol=1e-12)


def test_beams_that_hit_nothing_point_to_the_middle_of_their_bin():
    scan = slice_point_cloud(np.array([[2.0, 0.1, 0.4]]), 0.3, 0.5, beams=4)
    np.testing.assert_allclose(
        scan.angles, [-0.75 * math.pi, -math.pi / 4, math.atan(0.05), 0.75 * math.pi]
    )
    assert scan.valid.tolist() == [False, False, True, False]


def test_a_scanner_elsewhere():
    pose = lf.Pose2D(1.0, 0.5, 2.0)
    scan = slice_point_cloud(wall(sigma=0.003), 0.3, 0.5, origin=pose)
    assert scan.pose == pose
    on_wall = pose.transform(scan.points)
    assert np.abs(on_wall[:, 0] - 2.0).max() < 0.005
    assert np.ptp(on_wall[:, 1]) > 3.9
    assert slice_point_cloud(wall(), 0.3, 0.5).pose == lf.Pose2D(0.0, 0.0, 0.0)


def test_points_beyond_the_range_and_those_that_are_none_are_left_out():
    none = [[math.nan, 0, 0.4], [0, math.inf, 0.4], [1, 1, math.nan], [0.0, 0.0, 0.4]]
    scan = slice_point_cloud(np.concatenate([wall(), none]), 0.3, 0.5, range_max=2.2)
    assert scan.range_max == 2.2
    assert 1.9 < scan.ranges[scan.beams].min() < scan.ranges[scan.beams].max() < 2.2
    assert np.isinf(scan.ranges[~scan.valid]).all()
    here = np.array([[0.0, 0.0, 0.4], [2.0, 0.001, 0.4]])
    assert slice_point_cloud(here, 0.3, 0.5).points.round(12).tolist() == [[2.0, 0.001]]
    nothing = slice_point_cloud(wall(), 0.3, 0.5, range_max=1.0)
    assert len(nothing) == 720
    assert not nothing.valid.any()


def test_points_all_around_are_in_increasing_order():
    angles = np.linspace(-math.pi, math.pi, 4 * 720 + 1)  # on the borders of the bins as well
    points = np.stack([2 * np.cos(angles), 2 * np.sin(angles), 0 * angles], axis=1)
    scan = slice_point_cloud(points, -1, 1)
    assert scan.valid.all()
    np.testing.assert_allclose(scan.ranges, 2.0, atol=1e-4)


@pytest.mark.parametrize(
    ("points", "options", "complaint"),
    [
        ([[1, 2]], {}, r"points must have shape \(n, 3\), got \(1, 2\)"),
        ([1, 2, 3], {}, r"got \(3,\)"),
        (np.empty((0, 3)), {}, "expected finite points, got none among 0 points"),
        (np.full((7, 3), math.nan), {}, "expected finite points, got none among 7 points"),
        (
            [[1, 2, -0.25], [1, 2, 2.5]],
            {},
            r"with 0\.3 <= z < 0\.5 m, got none: the 2 points of .* span z = -0\.250 \.\. 2\.500 m",
        ),
        ([[1, 2, 3]], {"low": 0.5}, r"low < high \[m\], got 0\.5 and 0\.5"),
        ([[1, 2, 3]], {"high": math.nan}, r"low < high \[m\], got 0\.3 and nan"),
        ([[1, 2, 3]], {"beams": 2}, "beams must be >= 3, got 2"),
        ([[1, 2, 3]], {"max_gap": 0}, "max_gap must be > 0 m, got 0"),
        ([[1, 2, 3]], {"min_points": 0}, "min_points must be >= 1, got 0"),
        ([[1, 2, 0.4]], {"range_max": -1.0}, r"range_max, got 0\.0 and -1\.0 m"),
    ],
)
def test_what_makes_no_sense_is_refused(points, options, complaint):
    with pytest.raises(ValueError, match=complaint):
        slice_point_cloud(np.asarray(points), **({"low": 0.3, "high": 0.5} | options))
