"""What every search for walls starts and ends with, in the four detectors that do."""

import math

import kernels
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.direct_hough import DirectHough
from laserfeatures_plugins.ransac import Ransac
from laserfeatures_plugins.region_growing import RegionGrowing
from laserfeatures_plugins.split_and_merge import SplitAndMerge
from scenes import chain, poles, scan_of, wall

from laserfeatures import LaserScan
from laserfeatures.geometry import settle, walls

every_detector = pytest.mark.parametrize(
    "detector", [DirectHough, Ransac, RegionGrowing, SplitAndMerge]
)
seeds = st.integers(0, 10**6).map(np.random.default_rng)


def degree_scan(r):
    """Return a scan at 1 degree all of whose ranges are r metres."""
    return LaserScan.uniform([r] * 181, -math.pi / 2, math.radians(1))


@every_detector
def test_a_gap_smaller_than_the_beam_spacing_is_refused_with_the_numbers(detector):
    scan = scan_of(wall(0.0, 2.0, -1, 1), beams=181)
    message = "max_gap is 0.001 m, but beams 1 deg apart are 0.0175 m apart at 1.00 m: every step"
    with pytest.raises(ValueError, match=message):
        detector(max_gap=0.001)(scan)
    assert len(detector()(scan)) == 1


@every_detector
@pytest.mark.parametrize("degrees", [0.1, 1.0, 5.0, 14.0])
@pytest.mark.parametrize("r", [0.05, 1.0, 15.0, 80.0])
def test_the_default_gap_suits_every_scan(detector, degrees, r):
    detector()(LaserScan.uniform([r] * 13, -0.5, math.radians(degrees)))


@pytest.mark.parametrize(
    ("r", "max_gap", "right"),
    [
        (15.0, 0.018, True),  # nearer walls may come: at 1 m it will do
        (15.0, 0.017, False),
        (0.5, 0.009, True),  # the nearest return is nearer than 1 m
        (0.5, 0.008, False),
        (math.nan, 0.018, True),
        (math.nan, 0.017, False),
    ],
)
def test_a_gap_is_measured_at_the_nearest_return_or_at_a_metre(r, max_gap, right):
    if right:
        settle.check_gap(degree_scan(r), max_gap)
    else:
        with pytest.raises(ValueError, match=f"max_gap is {max_gap} m"):
            settle.check_gap(degree_scan(r), max_gap)


@pytest.mark.parametrize("beams", [0, 1])
def test_one_beam_has_no_spacing(beams):
    settle.check_gap(LaserScan.uniform([2.0] * beams, 0.0, 0.01), 1e-6)


@every_detector
@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"range_sigma": 0.0}, r"range_sigma must be in \(0, 1\] m, got 0\.0"),
        ({"range_sigma": 1.5}, r"range_sigma must be in \(0, 1\] m, got 1\.5"),
        ({"range_sigma": math.nan}, r"range_sigma must be in \(0, 1\] m, got nan"),
        ({"min_points": 2}, "min_points must be >= 3, got 2"),
        ({"max_missed": -1}, "max_missed must be >= 0, got -1"),
        ({"max_gap": 0.0}, r"max_gap must be > 0 m, got 0\.0"),
        ({"max_gap": math.inf}, r"max_gap must be > 0 m, got inf"),
        ({"object_gap": -0.1}, r"object_gap must be > 0 m, got -0\.1"),
        ({"object_gap": math.nan}, r"object_gap must be > 0 m, got nan"),
        ({"max_pole_radius": -0.1}, r"max_pole_radius must be >= 0 m, got -0\.1"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(detector, parameters, message):
    with pytest.raises(ValueError, match=message) as caught:
        detector(**parameters)
    assert "\n" not in str(caught.value)


@every_detector
def test_round_objects_are_walls_only_where_they_may_be(detector):
    scan = poles((1.5, 0.0), radius=0.3)
    assert len(detector(range_sigma=0.005)(scan)) == 0
    assert len(detector(range_sigma=0.005, max_pole_radius=0.0)(scan)) > 0
    assert len(detector(range_sigma=0.005, max_pole_radius=0.2)(scan)) > 0


@every_detector
def test_noise_that_is_not_given_is_that_of_the_walls(detector):
    room = chain((3, -2), (3, 1), (1, 1.5), (-0.5, 1.2))
    for sigma in (0.005, 0.015):
        ratios = []
        for seed in range(10):
            scan = scan_of(*room, sigma=sigma, seed=seed)
            stated, due = (
                np.sqrt(np.linalg.det(detector(range_sigma=given)(scan).lines.covariance).min())
                for given in (None, sigma)
            )
            ratios.append(stated / due)
        assert np.mean(ratios) == pytest.approx(1.0, rel=0.15)


@given(seeds, st.integers(0, 6), st.integers(0, 9))
def test_what_is_packed_comes_out_again(rng, lines, count):
    count = count if lines else 0
    theta, d, support = rng.uniform(0, math.pi, lines), rng.normal(size=lines), rng.random(lines)
    covariance = rng.normal(size=(lines, 2, 2))
    covariance += covariance.swapaxes(1, 2)
    line = np.sort(rng.integers(0, max(lines, 1), count))
    endpoints = rng.normal(size=(count, 2, 2))
    points_on, rms = rng.integers(1, 50, count).astype(float), rng.random(count)
    points = rng.random((count, 7)) < 0.5
    found = settle.line_segments(
        kernels.pack(theta, d, support, covariance, (line, endpoints, points_on, rms, points))
    )
    for record, fields in (
        (found.lines, {"theta": theta, "d": d, "support": support, "covariance": covariance}),
        (found, {"line": line, "endpoints": endpoints, "support": points_on, "rms": rms}),
        (found, {"points": points}),
    ):
        for name, expected in fields.items():
            array = getattr(record, name)
            np.testing.assert_array_equal(array, expected)
            assert not array.flags.writeable
            assert array.flags.c_contiguous


def test_an_inlier_is_within_three_sigmas_or_the_flatness_of_walls():
    assert kernels.gate_of(0.02) == pytest.approx(0.06)
    assert kernels.gate_of(0.001) == pytest.approx(1.5 * walls.FLATNESS)
