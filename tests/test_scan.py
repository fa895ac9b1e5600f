import dataclasses
import math

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures import LaserScan, Pose2D

ranges = st.lists(
    st.sampled_from([0.0, -1.0, 0.5, 2.0, 5.0, math.inf, -math.inf, math.nan]) | st.floats(0, 9),
    max_size=30,
)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        (
            {"angles": [0.0, 0.2, 0.1], "ranges": [1, 1, 1]},
            r"strictly increasing, got 0\.2 rad at beam 1 and 0\.1 rad at beam 2",
        ),
        ({"angles": [0.0, 0.0], "ranges": [1, 1]}, "got 0 rad at beam 0 and 0 rad at beam 1"),
        (
            {"angles": [0.0, math.nan, 1.0], "ranges": [1, 1, 1]},
            "got 0 rad at beam 0 and nan rad at beam 1",
        ),
        ({"angles": [math.nan], "ranges": [1]}, r"at most one turn, got nan \.\. nan rad"),
        ({"angles": [0.0, math.inf], "ranges": [1, 1]}, r"at most one turn, got 0 \.\. inf rad"),
        ({"angles": [0.0, 6.3], "ranges": [1, 1]}, r"at most one turn, got 0 \.\. 6\.3 rad"),
        ({"angles": [0.0, 0.1], "ranges": [1]}, r"ranges must have shape \(2\), got \(1,\)"),
        ({"angles": [[0.0]], "ranges": [[1]]}, r"angles must have shape \(n\), got \(1, 1\)"),
        (
            {"angles": [0.0], "ranges": [1], "range_min": -0.1},
            r"0 <= range_min < range_max, got -0\.1 and inf m",
        ),
        (
            {"angles": [0.0], "ranges": [1], "range_min": 2.0, "range_max": 2.0},
            r"got 2\.0 and 2\.0 m",
        ),
        ({"angles": [0.0], "ranges": [1], "range_max": math.nan}, r"got 0\.0 and nan m"),
        ({"angles": [0.0], "ranges": [1], "range_min": math.nan}, "got nan and inf m"),
    ],
)
def test_a_scan_that_makes_no_sense_is_refused_with_what_is_wrong(fields, message):
    with pytest.raises(ValueError, match=message):
        LaserScan(**fields)


@given(ranges, st.sampled_from([0.0, 0.5, 1.0]), st.sampled_from([5.0, 8.0, math.inf]))
def test_valid_beams_and_points_are_those_of_a_loop(values, range_min, range_max):
    scan = LaserScan.uniform(values, -1.0, 0.1, range_min=range_min, range_max=range_max)
    points, beams = reference.returns(scan.angles, values, range_min, range_max)
    np.testing.assert_array_equal(scan.beams, beams)
    np.testing.assert_array_equal(np.flatnonzero(scan.valid), beams)
    np.testing.assert_allclose(scan.points, points, rtol=1e-15, atol=1e-15)
    assert scan.points.shape == (len(beams), 2)
    assert len(scan) == len(values)


def test_range_max_itself_is_no_return_and_range_min_is_one():
    scan = LaserScan(angles=[0.0, 0.1], ranges=[0.5, 5.0], range_min=0.5, range_max=5.0)
    assert scan.valid.tolist() == [True, False]


def test_a_full_turn_may_have_a_beam_at_both_ends():
    scan = LaserScan(angles=np.linspace(-math.pi, math.pi, 361), ranges=np.ones(361))
    assert len(scan.points) == 361


def test_uniform_beams_are_evenly_spaced_from_angle_min():
    scan = LaserScan.uniform([1, 2, 3], -0.5, 0.25, stamp=4.0, pose=Pose2D(1, 2, 3))
    np.testing.assert_allclose(scan.angles, [-0.5, -0.25, 0.0])
    assert scan.ranges.tolist() == [1, 2, 3]
    assert (scan.stamp, scan.pose) == (4.0, Pose2D(1, 2, 3))


def test_a_negative_increment_turns_angles_and_ranges_round():
    scan = LaserScan.uniform([1, 2, 3], 0.5, -0.25)
    np.testing.assert_allclose(scan.angles, [0.0, 0.25, 0.5])
    assert scan.ranges.tolist() == [3, 2, 1]
    assert scan.ranges.flags.c_contiguous


def test_an_increment_of_0_is_refused():
    with pytest.raises(ValueError, match="strictly increasing"):
        LaserScan.uniform([1, 2], 0.0, 0.0)


def test_writable_arrays_are_copied_and_read_only_ones_are_not():
    angles, values = np.array([0.0, 0.1]), np.array([1.0, 2.0])
    angles.flags.writeable = False
    scan = LaserScan(angles=angles, ranges=values)
    assert scan.angles is angles
    values[0] = 9.0
    assert scan.ranges.tolist() == [1.0, 2.0]
    assert values.flags.writeable


def test_a_scan_cannot_be_changed():
    scan = LaserScan(angles=[0.0, 0.1], ranges=[1, 2])
    with pytest.raises(dataclasses.FrozenInstanceError):
        scan.stamp = 1.0
    for array in (scan.angles, scan.ranges, scan.valid, scan.beams, scan.points, scan.directions):
        assert not array.flags.writeable
        assert array.flags.c_contiguous
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert scan.angles.dtype == scan.ranges.dtype == np.float64


def test_scans_that_share_their_angles_share_their_directions():
    first = LaserScan(angles=[0.0, 0.1], ranges=[1, 2])
    second = LaserScan(angles=first.angles, ranges=[3, 4])
    assert second.directions is first.directions
    other = LaserScan(angles=[0.0, math.pi / 2], ranges=[3, 4])
    np.testing.assert_allclose(other.directions, [(1, 0), (0, 1)], atol=1e-15)
    np.testing.assert_allclose(first.directions[1], (math.cos(0.1), math.sin(0.1)))


def test_what_is_asked_twice_is_computed_once():
    scan = LaserScan(angles=[0.0, 0.1], ranges=[1, 2])
    assert scan.points is scan.points
    assert scan.valid is scan.valid


def test_a_pose_carries_points_into_its_frame():
    quarter = Pose2D(1.0, 2.0, math.pi / 2)
    np.testing.assert_allclose(quarter.transform([(1, 0), (0, 1)]), [(1, 3), (0, 2)], atol=1e-12)
    assert quarter.transform([]).shape == (0, 2)


def test_what_a_mask_covers_is_no_return():
    ranges = np.ma.masked_array([1, 2, 3], mask=[False, True, False])
    for scan in (
        LaserScan(angles=[0.0, 0.1, 0.2], ranges=ranges),
        LaserScan.uniform(ranges, 0.0, 0.1),
    ):
        assert type(scan.ranges) is np.ndarray
        assert scan.valid.tolist() == [True, False, True]
        assert np.isnan(scan.ranges[1])
    turned = LaserScan.uniform(np.ma.masked_array([1.0, 2.0], mask=[True, False]), 0.1, -0.1)
    assert turned.valid.tolist() == [True, False]
    with pytest.raises(ValueError, match="angles must be"):
        LaserScan(angles=np.ma.masked_array([0.0, 0.1], mask=[0, 1]), ranges=[1.0, 2.0])
