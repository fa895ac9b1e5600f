import math

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import segments_of

from laserfeatures import Intersections

seeds = st.integers(0, 10**6).map(np.random.default_rng)


def random_segments(rng):
    lines = int(rng.integers(0, 6))
    theta = rng.uniform(0, math.pi, lines)
    root = rng.normal(0, 0.02, (lines, 2, 2))
    pieces = []
    for k in rng.integers(0, max(lines, 1), rng.integers(0, 9) * (lines > 0)):
        low = rng.uniform(-4, 4)
        pieces.append((int(k), low, low + rng.uniform(0, 5), range(rng.integers(1, 9)), 0.01))
    d = rng.uniform(0.3, 4, lines) * rng.choice([-1, 1], lines)
    return segments_of(theta, d, pieces, covariance=root @ root.swapaxes(1, 2))


@given(seeds, st.sampled_from([0.0, 0.3, 1.0]), st.sampled_from([0.1, math.inf]))
def test_corners_are_those_of_the_twin(rng, min_angle, max_sigma):
    segments = random_segments(rng)
    stage = Intersections(min_angle=min_angle, max_sigma=max_sigma)
    found = stage(segments)
    expected = reference.corners(segments, stage)
    assert [tuple(pair) for pair in found.lines.tolist()] == [e[2] for e in expected]
    for i, (position, spread, _, angle, real) in enumerate(expected):
        np.testing.assert_allclose(found.positions[i], position, atol=1e-9)
        scale = np.abs(spread).max()
        np.testing.assert_allclose(found.covariance[i], spread, rtol=1e-4, atol=1e-4 * scale)
        assert found.angles[i] == pytest.approx(angle, abs=1e-7)
        assert found.real[i] == real


def right_angle(first=(-1.0, 1.0), second=(-1.0, 1.0), spread=1e-6):
    """Return the walls x = 2 and y = 1, which cross at (2, 1); pieces are measured from there."""
    pieces = [
        (0, 1 + first[0], 1 + first[1], range(20), 0.01),
        (1, -2 + second[0], -2 + second[1], range(20, 40), 0.01),
    ]
    covariance = np.tile(np.diag([spread, spread]), (2, 1, 1))
    return segments_of([0.0, math.pi / 2], [2.0, 1.0], pieces, covariance=covariance)


def test_a_corner_is_where_two_lines_cross():
    corners = Intersections()(right_angle())
    np.testing.assert_allclose(corners.positions, [[2.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(corners.angles, [math.pi / 2])
    assert corners.lines.tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("first", "second", "real"),
    [
        ((-1.0, 1.0), (-1.0, 1.0), True),  # both hold it
        ((-1.0, 0.0), (-1.0, 0.0), True),  # both end there
        ((-1.0, -0.04), (-1.0, 0.0), True),  # ends within reach
        ((-1.0, -0.9), (-1.0, 0.0), False),  # one wall ends before it
        ((-1.0, 0.0), (-3.0, -2.5), False),
        ((0.9, 1.5), (0.9, 1.5), False),
    ],
)
def test_a_corner_is_real_where_both_lines_have_a_segment_that_reaches_it(first, second, real):
    assert Intersections()(right_angle(first, second)).real.tolist() == [real]


def test_a_wall_of_few_beams_reaches_as_far_as_its_beams_are_apart():
    # Three beams on a metre of wall: the next might have hit the wall half a metre on.
    walls = segments_of(
        [0.0, math.pi / 2], [2.0, 1.0], [(0, -0.5, 0.5, range(3), 0.01), (1, -2.5, -2, range(9), 0)]
    )
    assert Intersections().reach < 0.5
    assert Intersections()(walls).real.tolist() == [True]


def test_corners_beyond_max_distance_are_dropped():
    distance = math.hypot(2, 1)
    assert len(Intersections(max_distance=distance + 0.01)(right_angle())) == 1
    assert len(Intersections(max_distance=distance - 0.01)(right_angle())) == 0


@pytest.mark.parametrize(("turn", "corners"), [(14.9, 0), (15.1, 1), (164.9, 1), (165.1, 0)])
def test_lines_that_cross_at_less_than_min_angle_have_no_corner(turn, corners):
    pieces = [(0, -1.0, 1.0, range(9), 0.01), (1, -1.0, 1.0, range(9, 18), 0.01)]
    walls = segments_of([0.1, 0.1 + math.radians(turn)], [0.5, 0.6], pieces)
    assert len(Intersections()(walls)) == corners


def test_parallel_lines_have_no_corner_even_at_min_angle_0():
    pieces = [(0, -1.0, 1.0, range(9), 0.01), (1, -1.0, 1.0, range(9, 18), 0.01)]
    walls = segments_of([1.0, 1.0], [0.5, 1.6], pieces)
    assert len(Intersections(min_angle=0.0)(walls)) == 0


def test_uncertain_corners_are_withheld():
    # Each line's offset at the corner has the variance spread * (1 + along^2): 2 and 5.
    walls = right_angle(spread=0.01)
    assert len(Intersections(max_sigma=math.sqrt(0.051))(walls)) == 1
    assert len(Intersections(max_sigma=math.sqrt(0.049))(walls)) == 0


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"max_distance": 0.0}, r"max_distance must be > 0 m, got 0\.0"),
        ({"max_sigma": -1.0}, r"max_sigma must be > 0 m, got -1\.0"),
        ({"min_angle": math.pi / 2}, r"min_angle must be in \[0, pi/2\) rad, got 1\.57"),
        ({"min_angle": -0.1}, r"min_angle must be in \[0, pi/2\) rad, got -0\.1"),
        ({"reach": -0.1}, r"reach must be >= 0 m, got -0\.1"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        Intersections(**parameters)
