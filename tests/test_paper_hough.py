import math

import numpy as np
import pytest
import reference_hough
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.direct_hough import paper
from laserfeatures_plugins.direct_hough.paper import PaperHough
from scenes import line_errors, nearest_line, scan_of, wall

from laserfeatures import LaserScan, get_extractor

seeds = st.integers(0, 10**6).map(np.random.default_rng)


def scan_at(points):
    """Return a scan whose returns are at some points, by bearing; nan stands for a missed beam."""
    points = np.array(points, dtype=float)
    angles = np.arctan2(points[:, 1], points[:, 0])
    order = np.argsort(angles)
    return LaserScan(angles=angles[order], ranges=np.hypot(*points.T)[order])


THREE = scan_at([(2, -1), (2, 0), (2, 1)])
COARSE = {"theta_step": math.pi / 8, "distance_step": 1.0, "max_distance": 0.1}


def test_accumulator_of_three_points_is_that_worked_out_by_hand():
    plane = PaperHough(**COARSE).accumulator(THREE)
    assert plane.d.tolist() == [-4, -3, -2, -1, 0, 1, 2, 3, 4]
    np.testing.assert_allclose(plane.theta, np.arange(8) * math.pi / 8)
    votes = {
        0: {2: 3},  # x = 2 is the line through all three
        1: {1: 1, 2: 2},
        2: {1: 2, 2: 1},
        3: {0: 1, 1: 1, 2: 1},
        4: {-1: 1, 0: 1, 1: 1},
        5: {-2: 1, -1: 1, 0: 1},
        6: {-2: 1, -1: 2},
        7: {-2: 2, -1: 1},
    }
    expected = [[votes[t].get(d, 0) for d in range(-4, 5)] for t in range(8)]
    assert plane.votes.tolist() == expected


@pytest.mark.parametrize(
    ("neighborhood", "peaks"),
    [
        # In cells (theta, d); after the first, cells of two votes come in order of theta.
        ((1, 1), [(0, 2), (1, 2), (2, 1), (6, -1), (7, -2)]),
        ((1, 3), [(0, 2), (2, 1), (6, -1)]),  # theta 7 is beside theta 0, at -d
        ((3, 3), [(0, 2), (2, 1), (6, -1)]),
        ((3, 5), [(0, 2)]),
        ((1, 5), [(0, 2), (2, 1), (6, -1)]),
    ],
)
def test_a_peak_suppresses_its_window_and_goes_on_at_minus_d(neighborhood, peaks):
    detector = PaperHough(min_votes=2, relative_threshold=0, neighborhood=neighborhood, **COARSE)
    lines = detector(THREE).lines
    found = np.stack([lines.theta / (math.pi / 8), lines.d], axis=1)
    np.testing.assert_allclose(found, peaks, atol=1e-9)


def test_no_more_than_max_peaks_are_found_the_highest_first():
    detector = PaperHough(
        min_votes=1, relative_threshold=0, neighborhood=(1, 1), max_peaks=2, **COARSE
    )
    assert detector(THREE).lines.d.tolist() == [2, 2]


@given(
    seeds, st.integers(1, 4), st.integers(1, 6),
    st.sampled_from([1, 3, 5]), st.sampled_from([1, 3, 5, 17]),
)  # fmt: skip
def test_peaks_are_those_of_the_twin(rng, threshold, max_peaks, window_d, window_theta):
    shape = (rng.integers(2, 9), 2 * rng.integers(1, 6) + 1)
    votes = rng.integers(0, 6, shape).astype(np.int32)
    kept = votes.copy()
    rows, columns = paper._find_peaks(votes, threshold, max_peaks, window_d, window_theta)
    expected = reference_hough.peaks(votes, threshold, max_peaks, window_d, window_theta)
    assert list(zip(rows.tolist(), columns.tolist(), strict=True)) == expected
    np.testing.assert_array_equal(votes, kept)


@pytest.mark.parametrize(("points", "found"), [(10, 0), (11, 1)])
def test_half_a_vote_of_the_threshold_is_rounded_up(points, found):
    # 0.15 * 70 votes is 10.5: eleven are needed (Eq. 2), not the ten of round-half-to-even.
    x = [(4.0, y) for y in np.linspace(-3, 3, 70)]
    y = [(x, 3.5) for x in np.linspace(-2, 2, points)]
    scan = scan_at(x + y)
    detector = PaperHough(min_votes=1, max_peaks=1000, neighborhood=(1, 1))
    assert detector.accumulator(scan).votes.max() == 70
    lines = detector(scan).lines
    here = (abs(lines.theta - math.pi / 2) < 1e-9) & (abs(lines.d - 3.5) < 0.01)
    assert here.sum() == found


@pytest.mark.parametrize(("min_votes", "lines"), [(3, 1), (4, 0)])
def test_peaks_have_min_votes_however_low_the_threshold(min_votes, lines):
    detector = PaperHough(min_votes=min_votes, relative_threshold=0.0, max_peaks=1, **COARSE)
    assert len(detector(THREE).lines) == lines


@pytest.mark.parametrize("theta", [0.0, 0.004, math.pi - 0.004, math.pi - 0.02])
@pytest.mark.parametrize("d", [2.0, -2.0])
def test_a_wall_at_the_wrap_of_theta_is_found_once(theta, d):
    scan = scan_of(wall(theta, d, -1, 1), view=2 * math.pi * 719 / 720, beams=720)
    # All that has half of the votes of the wall: nothing but the wall itself.
    lines = PaperHough(relative_threshold=0.5)(scan).lines
    found = np.stack([lines.theta, lines.d], axis=1)
    assert len(nearest_line(found, (theta, d), math.radians(4), 0.1)) == 1
    assert len(found) == 1


def test_points_nearer_than_max_distance_are_the_lines():
    scan = scan_at([(2, -0.4), (2, -0.2), (2.039, 0), (2.041, 0.2), (2, 0.4), (2, 0.6)])
    segments = PaperHough(max_peaks=1, max_distance=0.04)(scan)
    assert segments.lines.support.tolist() == [5]
    assert segments.points.any(axis=0).tolist() == [True, True, True, False, True, True]
    assert PaperHough(max_peaks=1, max_distance=0.06)(scan).lines.support.tolist() == [6]


def test_a_missed_beam_cuts_a_segment():
    angles = np.linspace(-0.4, 0.4, 9)
    ranges = 2 / np.cos(angles)
    ranges[3] = np.nan  # no return
    ranges[6] = 1.0  # something before the wall
    segments = PaperHough(max_peaks=1)(LaserScan(angles=angles, ranges=ranges))
    held = [np.flatnonzero(row).tolist() for row in segments.points]
    assert held == [[0, 1, 2], [4, 5], [7, 8]]
    assert segments.support.tolist() == [3, 2, 2]
    assert segments.line.tolist() == [0, 0, 0]
    np.testing.assert_allclose(segments.endpoints[0, 0], (2, 2 * math.tan(-0.4)), atol=1e-9)
    np.testing.assert_allclose(segments.endpoints[2, 1], (2, 2 * math.tan(0.4)), atol=1e-9)


def test_a_wide_step_between_successive_beams_does_not_cut():
    scan = scan_at([(2, -3), (2, 0), (2, 3), (2, 9)])
    assert len(PaperHough(max_peaks=1, max_distance=0.1)(scan)) == 1


def test_lines_are_cells_and_their_covariance_that_of_a_cell():
    detector = PaperHough(max_peaks=1)
    lines = detector(scan_of(wall(0.3, 2.0, -1, 1), sigma=0.005)).lines
    assert abs(line_errors((lines.theta[0], lines.d[0]), (0.3, 2.0))).max() < 0.03
    assert lines.theta[0] / detector.theta_step == pytest.approx(
        round(lines.theta[0] * 180 / math.pi)
    )
    assert lines.d[0] / detector.distance_step == pytest.approx(round(lines.d[0] / 0.02))
    expected = np.diag([detector.theta_step**2 / 12, detector.distance_step**2 / 12])
    np.testing.assert_allclose(lines.covariance[0], expected)


def test_the_stages_of_the_preset_take_the_papers_values():
    extractor = get_extractor("direct_hough", preset="paper", max_peaks=3)
    assert extractor.detector == PaperHough(max_peaks=3)
    assert extractor.segment_filter.max_error == 0.02
    assert extractor.intersections.max_distance == 20.0
    assert extractor.intersections.min_angle == 0
    assert extractor.intersections.max_sigma == math.inf


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"theta_step": 0.0}, r"theta_step must be in \[0.0001, pi/8\] rad, got 0\.0"),
        ({"theta_step": 0.4}, r"theta_step must be in \[0.0001, pi/8\] rad, got 0\.4"),
        ({"distance_step": 0.0}, r"distance_step must be in \[0.0001, 10\] m, got 0\.0"),
        ({"distance_step": 11.0}, r"distance_step must be in \[0.0001, 10\] m, got 11\.0"),
        ({"neighborhood": (21, 10)}, r"two odd numbers of cells >= 1, got \(21, 10\)"),
        ({"neighborhood": (-1, 11)}, r"two odd numbers of cells >= 1, got \(-1, 11\)"),
        ({"neighborhood": (21,)}, r"two odd numbers of cells >= 1, got \(21,\)"),
        ({"min_votes": 0}, "min_votes must be >= 1, got 0"),
        ({"max_peaks": 0}, "max_peaks must be >= 1, got 0"),
        ({"relative_threshold": 1.1}, r"relative_threshold must be in \[0, 1\], got 1\.1"),
        ({"relative_threshold": -0.1}, r"relative_threshold must be in \[0, 1\], got -0\.1"),
        ({"max_distance": 0.0}, r"max_distance must be > 0 m, got 0\.0"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        PaperHough(**parameters)
