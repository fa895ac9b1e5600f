"""Lines (theta, d) of truth: one form, differences across the wrap, merging, crossing."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import line_errors

from laserfeatures.evaluation.true_lines import (
    cross,
    difference,
    lines_through,
    merge_collinear,
    normalised,
)

angles = st.floats(-50, 50)
distances = st.floats(-30, 30)
small = st.floats(-1e-3, 1e-3)


def one(function, *values):
    return tuple(float(value[0]) for value in function(*(np.array([v]) for v in values)))


@given(angles, distances)
def test_the_normal_form_is_the_same_line(theta, d):
    turned, signed = one(normalised, theta, d)
    assert 0 <= turned < math.pi
    assert abs(signed) == abs(d)
    # The point of a line that is nearest to the origin, and its direction up to sign.
    assert signed * math.cos(turned) == pytest.approx(d * math.cos(theta), abs=1e-11)
    assert signed * math.sin(turned) == pytest.approx(d * math.sin(theta), abs=1e-11)
    assert math.sin(turned - theta) == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize(
    ("theta", "d", "expected"),
    [
        (0.0, 2.0, (0.0, 2.0)),
        (math.pi, 2.0, (0.0, -2.0)),
        (-math.pi, 2.0, (0.0, -2.0)),
        (2 * math.pi, 2.0, (0.0, 2.0)),
        (-math.pi / 2, 2.0, (math.pi / 2, -2.0)),
        (-1e-17, 2.0, (0.0, 2.0)),  # theta + pi rounds to pi
        (-5e-324, 2.0, (0.0, 2.0)),  # theta / pi rounds to 0
        (np.nextafter(17 * math.pi, 0), 2.0, (0.0, -2.0)),  # and to 17, from below
        (np.nextafter(math.pi, 0), 2.0, (np.nextafter(math.pi, 0), 2.0)),
    ],
)
def test_the_normal_form_at_the_wrap(theta, d, expected):
    assert one(normalised, theta, d) == expected


@given(angles, distances, small, small)
def test_a_difference_is_the_error_that_was_made(theta, d, turn, shift):
    found = one(normalised, theta, d)
    true = one(normalised, found[0] - turn, found[1] - shift)
    assert one(difference, *found, *true) == pytest.approx((turn, shift), abs=1e-12)


@given(st.floats(0, math.pi, exclude_max=True), distances, small, small)
def test_a_difference_counts_as_the_first_line_does_and_is_the_twins(theta, d, turn, shift):
    true = one(normalised, theta + turn, d + shift)
    there, back = one(difference, theta, d, *true), one(difference, *true, theta, d)
    flipped = abs(true[0] - theta) > 1
    assert back == pytest.approx((-there[0], there[1] if flipped else -there[1]), abs=1e-12)
    # The twin counts d as the true line does.
    twin = line_errors((theta, d), true)
    assert there == pytest.approx((twin[0], -twin[1] if flipped else twin[1]), abs=1e-12)


def test_a_difference_across_the_wrap_by_hand():
    near_pi = math.pi - 0.001
    assert one(difference, 0.002, 5.0, near_pi, -4.9) == pytest.approx((0.003, 0.1))
    assert one(difference, near_pi, -4.9, 0.002, 5.0) == pytest.approx((-0.003, 0.1))
    assert one(difference, 0.002, 5.0, near_pi, 4.9) == pytest.approx((0.003, 9.9))


@given(*[st.floats(-20, 20)] * 4)
def test_a_line_goes_through_both_points_in_either_order(ax, ay, bx, by):
    if math.dist((ax, ay), (bx, by)) < 0.01:
        bx += 1.0
    ends = np.array([[(ax, ay), (bx, by)], [(bx, by), (ax, ay)]])
    theta, d = lines_through(ends)
    assert ((theta >= 0) & (theta < math.pi)).all()
    off = ends[..., 0] * np.cos(theta)[:, None] + ends[..., 1] * np.sin(theta)[:, None]
    np.testing.assert_allclose(off, np.stack([d, d], axis=1), rtol=0, atol=1e-9)
    assert one(difference, theta[0], d[0], theta[1], d[1]) == pytest.approx((0, 0), abs=1e-9)


def test_lines_that_are_the_same_but_for_rounding_get_the_first_ones_number():
    theta = np.array([1.0, 1e-9, 1.0, math.pi - 1e-9, 1.0 + 1e-5, 1.0, 2e-9])
    d = np.array([2.0, 3.0, 2.0 + 1e-8, -3.0, 2.0, 2.0 + 1e-5, -3.0])
    assert merge_collinear(theta, d).tolist() == [0, 1, 0, 1, 4, 5, 6]


def test_nothing_is_merged_or_crossed_of_no_lines():
    nothing = np.empty(0)
    assert merge_collinear(nothing, nothing).shape == (0,)
    positions, pairs = cross(nothing, nothing)
    assert (positions.shape, pairs.shape) == ((0, 2), (0, 2))
    assert lines_through(np.empty((0, 2, 2)))[0].shape == (0,)


def crossings(theta, d):
    return len(cross(np.array(theta), np.array(d))[0])


@pytest.mark.parametrize(
    ("degrees", "count"),
    [(14.9999, 0), (15.0, 1), (15.0001, 1), (90.0, 1), (164.9999, 1), (165.0, 1), (165.0001, 0)],
)
@pytest.mark.parametrize("turn", [0.0, 10.0])
def test_lines_cross_at_fifteen_degrees_or_more(degrees, count, turn):
    assert crossings(np.radians([turn, turn + degrees]), [1.0, 1.0]) == count


@pytest.mark.parametrize(("away", "count"), [(19.9999, 1), (20.0, 1), (20.0001, 0), (-20.0001, 0)])
@pytest.mark.parametrize("axis", [0, 1])
def test_lines_cross_within_twenty_metres_of_the_sensor(away, count, axis):
    d = [0.0, 0.0]
    d[axis] = away
    assert crossings([0.0, math.pi / 2], d) == count


def test_each_pair_of_lines_crosses_once():
    theta, d = np.array([0.0, 0.7, 1.5, 2.4]), np.array([1.0, -2.0, 3.0, 0.5])
    positions, pairs = cross(theta, d)
    assert pairs.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]
    for point, pair in zip(positions, pairs, strict=True):
        off = point[0] * np.cos(theta[pair]) + point[1] * np.sin(theta[pair])
        np.testing.assert_allclose(off, d[pair], atol=1e-12)
