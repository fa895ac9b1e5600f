import math

import numpy as np
import pytest
from laserfeatures_plugins.direct_hough import DirectHough
from scenes import chain, line_errors, needs_compiler, poles, scan_of, wall

from laserfeatures import LaserScan

SCENE = chain((2, -2), (2, 0.5), (1.5, 0.5), (1.5, 1.5), (-0.5, 1.5))  # with a pillar


def theta_and_d(segments):
    return np.stack([segments.lines.theta, segments.lines.d], axis=1)


def test_every_wall_is_found_and_each_point_is_on_one():
    scan = scan_of(*SCENE, sigma=0.005)
    segments = DirectHough()(scan)
    assert len(segments.lines) == 4
    assert segments.points.sum(axis=0).max() == 1
    assert segments.points.sum() > 0.97 * len(scan.points)


def test_noise_that_is_given_scales_the_covariances():
    scan = scan_of(wall(0.3, 2.0, -1, 1), sigma=0.005)
    one, two = (DirectHough(range_sigma=s)(scan).lines.covariance for s in (0.006, 0.012))
    # Not to the last digit: the weights are those at the angle of the peak, which may be another.
    scale = np.sqrt(np.linalg.det(two[0]))
    np.testing.assert_allclose(two, 4 * one, rtol=1e-3, atol=0.02 * scale)


@needs_compiler
@pytest.mark.parametrize("sigma", [0.004, 0.01, 0.02])
def test_noise_that_is_not_given_is_that_of_the_walls(sigma):
    # Measured: the standard deviations stated are 0.99 to 1.03 times those for the true noise.
    scans = [scan_of(*SCENE, sigma=sigma, seed=seed) for seed in range(20)]
    stated, due = (
        np.mean([
            np.sqrt(detector(scan).lines.covariance[:, 0, 0]).min() for scan in scans
        ])
        for detector in (DirectHough(), DirectHough(range_sigma=sigma))
    )  # fmt: skip
    assert stated == pytest.approx(due, rel=0.15)


def test_the_steps_are_the_accumulators():
    plane = DirectHough(theta_step=0.1, distance_step=0.25).accumulator(scan_of(*SCENE))
    np.testing.assert_allclose(np.diff(plane.theta), math.pi / 31)
    np.testing.assert_allclose(np.diff(plane.d), 0.25)


@pytest.mark.parametrize("theta_step", [math.radians(0.5), math.radians(2), math.radians(4)])
@pytest.mark.parametrize("distance_step", [0.01, 0.05])
def test_walls_do_not_hang_on_the_steps(theta_step, distance_step):
    scan = scan_of(*SCENE, sigma=0.005)
    fine = theta_and_d(DirectHough()(scan))
    other = theta_and_d(DirectHough(theta_step=theta_step, distance_step=distance_step)(scan))
    for line in fine:
        assert abs(line_errors(other, line)).sum(axis=1).min() < 0.02


def test_a_wall_of_fewer_than_min_points_is_not_found():
    scan = scan_of(wall(0.0, 2.0, -0.2, 0.2))
    count = len(scan.points)
    assert len(DirectHough(min_points=count)(scan)) == 1
    assert len(DirectHough(min_points=count + 1)(scan)) == 0


def test_max_missed_and_max_gap_say_what_cuts_a_wall():
    scan = scan_of(wall(0.0, 2.0, -1.0, 1.0))
    ranges = scan.ranges.copy()
    middle = len(scan) // 2
    ranges[middle - 5 : middle + 5] = 0.0  # ten beams, 17 cm of the wall
    holed = LaserScan(angles=scan.angles, ranges=ranges)
    counts = [
        len(DirectHough(max_missed=missed, max_gap=gap)(holed))
        for missed, gap in [(9, 0.1), (10, 0.1), (9, 0.25)]
    ]
    assert counts == [2, 1, 1]
    assert len(DirectHough(max_missed=9, max_gap=0.1)(holed).lines) == 1


def test_round_objects_are_walls_only_where_they_may_be():
    scan = poles((1.5, 0.0), radius=0.3)
    assert len(DirectHough(range_sigma=0.005)(scan)) == 0
    assert len(DirectHough(range_sigma=0.005, max_pole_radius=0.0)(scan)) > 0
    assert len(DirectHough(range_sigma=0.005, max_pole_radius=0.2)(scan)) > 0


def test_poles_are_no_walls_where_the_noise_is_known():
    detector = DirectHough(range_sigma=0.005)
    for radius in (0.04, 0.1, 0.2):
        for seed in range(10):
            scan = poles((1.5, 0.8), (1.8, -0.7), (3.0, 0.1), radius=radius, seed=seed)
            assert len(detector(scan)) == 0


def test_a_closed_room_without_a_jump_is_no_pole():
    # Its scan ends beside the point where it began.
    corners = [(2, -2), (2, 2), (-2, 2), (-2, -2), (2, -2)]
    scan = scan_of(*chain(*corners), sigma=0.003, view=2 * math.pi * 719 / 720, beams=720)
    assert len(DirectHough()(scan).lines) == 4


def test_walls_farther_apart_than_the_bins_reach_are_told_apart():
    # The votes of d are kept in turns of 1024 bins, 20.48 m here: both walls share a bin.
    walls = [wall(0.0, 1.0, -0.4, 0.4), wall(0.0, 21.48, -21, -11), wall(0.0, 21.48, 11, 21)]
    found = theta_and_d(DirectHough()(scan_of(*walls, sigma=0.003, beams=721)))
    for truth in [(0.0, 1.0), (0.0, 21.48)]:
        near = abs(line_errors(found, truth))
        assert ((near[:, 0] < 0.02) & (near[:, 1] < 0.1)).sum() == 1
    assert len(found) == 2


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"theta_step": 0.0}, r"theta_step must be in \[0.0001, pi/8\] rad, got 0\.0"),
        ({"distance_step": math.nan}, r"distance_step must be in \[0.0001, 10\] m, got nan"),
        ({"range_sigma": 0.0}, r"range_sigma must be in \(0, 1\] m, got 0\.0"),
        ({"range_sigma": 1.5}, r"range_sigma must be in \(0, 1\] m, got 1\.5"),
        ({"min_points": 2}, "min_points must be >= 3, got 2"),
        ({"max_missed": -1}, "max_missed must be >= 0, got -1"),
        ({"max_gap": 0.0}, r"max_gap must be > 0 m, got 0\.0"),
        ({"max_gap": math.inf}, r"max_gap must be > 0 m, got inf"),
        ({"pair_distance": 0.0}, r"pair_distance must be > 0 m, got 0\.0"),
        ({"range_sigma_relative": 0.01}, "range_sigma_relative 0.01 needs a range_sigma beside it"),
        (
            {"range_sigma": 0.01, "range_sigma_relative": 1.0},
            r"range_sigma_relative must be in \[0, 1\), got 1\.0",
        ),
        ({"roughness": -0.1}, r"roughness must be in \[0, 1\] m, got -0\.1"),
        ({"max_pole_radius": -0.1}, r"max_pole_radius must be >= 0 m, got -0\.1"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        DirectHough(**parameters)
