import math

import kernels
import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import line_errors

from laserfeatures import LaserScan, geometry

seeds = st.integers(0, 10**6).map(np.random.default_rng)
ranges = st.lists(
    st.one_of(st.floats(allow_nan=True, allow_infinity=True), st.floats(0, 10)), max_size=30
)


@given(ranges, st.floats(0, 5), st.floats(5.1, 20) | st.just(math.inf))
def test_returns_are_the_points_and_beams_of_the_scan(values, range_min, range_max):
    scan = LaserScan.uniform(values, -1.0, 0.1, range_min=range_min, range_max=range_max)
    found, beam = kernels.returns(scan)
    points, beams = reference.returns(scan.angles, values, range_min, range_max)
    np.testing.assert_allclose(found, points, rtol=1e-15, atol=1e-12)
    np.testing.assert_array_equal(beam, beams)
    np.testing.assert_array_equal(found, scan.points)
    np.testing.assert_array_equal(beam, scan.beams)


def noisy_line(rng, count=None):
    theta, d = rng.uniform(0, math.pi), rng.uniform(-5, 5)
    along = rng.uniform(-3, 3) + rng.uniform(0.3, 3) * np.sort(rng.uniform(-1, 1, count or 20))
    off = d + rng.normal(0, 0.01, along.size)
    c, s = math.cos(theta), math.sin(theta)
    return theta, d, np.stack([off * c - along * s, off * s + along * c], axis=1)


@given(seeds, st.integers(2, 30))
def test_fit_is_the_smallest_eigenvector_of_the_weighted_scatter(rng, count):
    theta, _, points = noisy_line(rng, count)
    members = np.flatnonzero(rng.random(count) < 0.8)
    if len(members) < 2:
        members = np.arange(count)
    w = reference.weights(points[members], theta, geometry.INCIDENCE_FLOOR)
    expected = reference.fit_line(points[members], w, 1.0)
    fit = kernels.fit_line(points, members, theta)
    assert 0 <= fit[0] < math.pi
    assert abs(line_errors(fit[:2], expected[:2])).max() < 1e-9
    sign = 1 if abs(fit[0] - expected[0]) < 1 else -1  # theta at 0 may come as pi, with -d
    np.testing.assert_allclose(fit[2::2], expected[2::2], rtol=1e-6)
    np.testing.assert_allclose(fit[3], sign * expected[3], rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("theta", [0.0, 1e-9, math.pi / 2, math.pi - 1e-9])
@pytest.mark.parametrize("d", [-2.0, 0.5, 3.0])
def test_fit_keeps_theta_below_pi_at_the_wrap(theta, d):
    along = np.linspace(-1, 2, 20)
    c, s = math.cos(theta), math.sin(theta)
    points = np.stack([d * c - along * s, d * s + along * c], axis=1)
    fit = kernels.fit_line(points, np.arange(20), theta)
    assert 0 <= fit[0] < math.pi
    np.testing.assert_allclose(line_errors(fit[:2], (theta, d)), 0, atol=1e-7)


def test_a_grazing_beam_weighs_more_than_a_head_on_one():
    # Its range error hardly moves its point off the wall: two points at 1.02 m outvote two at 1 m.
    points = np.array([(1.0, -0.1), (1.0, 0.1), (1.02, 7.9), (1.02, -7.9)])
    d = kernels.fit_line(points, np.arange(4), 0.0)[1]
    assert d == pytest.approx(1.02, abs=0.001)


@pytest.mark.parametrize(
    ("steps", "way", "spacing", "gap"),
    [
        (1, 0.2, 0.2, False),  # not wider than max_gap
        (9, 0.2, 0.01, False),  # many beams missed, but a short way
        (4, 0.3, 0.2, False),  # three missed, as allowed
        (5, 0.3, 0.2, True),  # four missed
        (1, 0.9, 0.3, False),  # thrice the spacing: grazing incidence
        (1, 1.3, 0.3, True),  # more than four times the spacing: a jump
        (2, 2.3, 0.3, False),  # the growth is for each beam
        (1, 50.0, math.inf, False),  # no spacing is known yet
    ],
)
def test_a_gap_is_wide_and_misses_beams_or_jumps(steps, way, spacing, gap):
    assert kernels.is_gap(steps, way, spacing, 3, 0.25, 4.0) == gap


@given(seeds, st.integers(0, 40), st.integers(0, 3), st.integers(0, 4), st.sampled_from([0.0, 0.3]))
def test_segments_are_the_runs_between_gaps(rng, count, lines, max_missed, max_gap):
    points = rng.uniform(-3, 3, (count, 2)) * (1.0, 0.01) + (0.0, 2.0)
    points = points[np.argsort(points[:, 0])]
    total = 2 * count + 1
    beams = np.sort(rng.choice(total, count, replace=False))
    members = rng.random((lines, count)) < rng.uniform(0.3, 1)
    fits = np.stack([rng.uniform(1.5, 1.6, lines), rng.uniform(1.9, 2.1, lines)], axis=1)
    growth = rng.choice([2.0, 8.0, math.inf])
    gaps = (max_missed, max_gap, growth)
    line, endpoints, support, rms, held = kernels.cut_segments(
        points, beams, total, fits, members, *gaps
    )
    expected = reference.cut_segments(points, beams, fits, members, *gaps)
    assert held.shape == (len(expected), total)
    assert line.tolist() == [k for k, *_ in expected]
    for j, (_, ends, beams_held, error) in enumerate(expected):
        np.testing.assert_allclose(endpoints[j], ends, atol=1e-12)
        np.testing.assert_array_equal(np.flatnonzero(held[j]), beams_held)
        assert support[j] == len(beams_held)
        assert rms[j] == pytest.approx(error, abs=1e-12)


@given(seeds)
def test_the_major_axis_is_the_largest_eigenvector_of_the_scatter(rng):
    points = rng.normal(size=(5, 2)) * rng.choice([1e-3, 1.0, 1e3], 2)
    scatter = points.T @ points
    *axis, spread = kernels.major_axis(scatter)
    values, vectors = np.linalg.eigh(scatter)
    assert spread == pytest.approx(values[1], rel=1e-9)
    assert np.hypot(*axis) == pytest.approx(1.0, rel=1e-12)
    # Parallel, as far as two eigenvalues are apart.
    across = axis[0] * vectors[1, 1] - axis[1] * vectors[0, 1]
    assert abs(across) < 1e-12 * values[1] / (values[1] - values[0])


@pytest.mark.parametrize(
    ("scatter", "axis"),
    [
        ([[2, 0], [0, 1]], (1, 0)),
        ([[1, 0], [0, 2]], (0, 1)),
        ([[1, 1], [1, 1]], (math.sqrt(0.5), math.sqrt(0.5))),
        ([[1, -1], [-1, 1]], (math.sqrt(0.5), -math.sqrt(0.5))),
        ([[1, 0], [0, 1]], (1, 0)),  # no direction is the major one
        ([[0, 0], [0, 0]], (1, 0)),
    ],
)
def test_the_major_axis_of_special_scatters(scatter, axis):
    *found, spread = kernels.major_axis(np.array(scatter, float))
    np.testing.assert_allclose(np.multiply(found, np.sign(found @ np.array(axis))), axis)
    assert spread == pytest.approx(max(np.linalg.eigvalsh(scatter)[1], 1e-12))


def assert_unweighted(fit, points):
    """Check a fit against the smallest eigenvector of the scatter."""
    expected = reference.fit_line(points, np.ones(len(points)), 1.0)
    assert 0 <= fit[0] < math.pi
    assert abs(line_errors(fit[:2], expected[:2])).max() < 1e-9
    sign = 1 if abs(fit[0] - expected[0]) < 1 else -1
    np.testing.assert_allclose(fit[2::2], expected[2::2], rtol=1e-6)
    np.testing.assert_allclose(fit[3], sign * expected[3], rtol=1e-6, atol=1e-9)


@given(seeds, st.integers(2, 30))
def test_the_fit_in_a_hurry_is_the_one_without_weights(rng, count):
    points = noisy_line(rng, count)[2]
    members = np.sort(rng.choice(count, rng.integers(2, count + 1), replace=False))
    assert_unweighted(kernels.fit_unweighted(points, members), points[members])


@given(seeds, st.integers(2, 30))
def test_sums_from_any_origin_on_give_the_line(rng, count):
    points = noisy_line(rng, count)[2]
    origin = rng.uniform(-5, 5, 2)
    assert_unweighted(kernels.line_of_sums(points - origin, origin), points)


@pytest.mark.parametrize("slope", [1e-17, -1e-17, 1e-300])
def test_an_angle_that_rounds_to_pi_is_0(slope):
    along = np.linspace(-1, 2, 20)
    theta, d, *_ = kernels.line_of_sums(np.stack([slope * along, along], axis=1), (2.0, 0.5))
    assert 0 <= theta < math.pi
    np.testing.assert_allclose(line_errors((theta, d), (0.0, 2.0)), 0, atol=1e-12)


@pytest.mark.parametrize("theta", [0.0, 1e-9, math.pi / 2, math.pi - 1e-9])
@pytest.mark.parametrize("d", [-2.0, 0.5, 3.0])
def test_the_fit_in_a_hurry_keeps_theta_below_pi_at_the_wrap(theta, d):
    c, s = math.cos(theta), math.sin(theta)
    for along in (np.linspace(-1, 2, 20), np.linspace(2, -1, 20)):
        points = np.stack([d * c - along * s, d * s + along * c], axis=1)
        fit = kernels.fit_unweighted(points, np.arange(20))
        assert 0 <= fit[0] < math.pi
        np.testing.assert_allclose(line_errors(fit[:2], (theta, d)), 0, atol=1e-7)


def test_the_fit_in_a_hurry_is_as_good_a_kilometre_away():
    along = np.linspace(-0.15, 0.15, 30)
    points = np.stack([1000.0 + along, 1000.0 - 0.5 * along], axis=1)
    theta, d, *_ = kernels.fit_unweighted(points, np.arange(30))
    truth = math.atan2(1.0, 0.5), 1500.0 / math.hypot(1.0, 0.5)
    # The coordinates are good to 1e-13 m.
    np.testing.assert_allclose(line_errors((theta, d), truth), 0, atol=2e-9)
