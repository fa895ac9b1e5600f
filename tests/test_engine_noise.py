"""The noise of a scan's ranges, as the scan itself tells it."""

import math

import kernels
import numpy as np
import pytest
import reference_engine
from scenes import TURN, look, needs_compiler, random_room
from scipy.signal import lfilter

from laserfeatures import LaserScan, Pose2D
from laserfeatures.engine import noise, sequence
from laserfeatures.engine.detector import WallDetector
from laserfeatures.simulation import World

ROOM = World.outline([(-3, -2.2), (5, -2.2), (5, 3.5), (-3, 3.5)])


def estimated(scan):
    """Return sigma [m] and the relative noise of a scan."""
    return kernels.estimate_noise(kernels.weighed(scan, 1.0))[:2]


def correlation(scan):
    """Return how alike the errors of neighbouring ranges are."""
    return kernels.estimate_noise(kernels.weighed(scan, 1.0)).correlation


def deviations(found, ranges=(1.0, 3.0, 6.0)):
    """Return the standard deviation of some ranges [m]."""
    return np.hypot(found[0], found[1] * np.array(ranges))


def a_room(seed, sigma, relative=0.0, beams=720):
    """Return a scan around a room of some shape."""
    world, pose = random_room(np.random.default_rng(seed))
    view = TURN * (beams - 1) / beams
    scan, _ = look(world, seed=seed, beams=beams, view=view, pose=pose)
    more = np.random.default_rng(seed + 1).normal(0, 1, beams)
    ranges = scan.ranges + more * np.hypot(sigma, relative * scan.ranges)
    return LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)


@pytest.mark.parametrize("sigma", [0.002, 0.005, 0.01, 0.03])
def test_the_noise_of_rooms_is_estimated(sigma):
    found = np.array([deviations(estimated(a_room(seed, sigma))) for seed in range(20)])
    assert np.median(found[:, 1]) == pytest.approx(sigma, rel=0.15)
    assert (abs(np.log(found[:, 1] / sigma)) < math.log(1.5)).all()


def test_noise_that_grows_with_the_range_is_estimated():
    truth = deviations((0.004, 0.008), (1.0, 2.0, 4.0))
    found = [deviations(estimated(a_room(k, 0.004, 0.008)), (1.0, 2.0, 4.0)) for k in range(30)]
    np.testing.assert_allclose(np.median(found, axis=0), truth, rtol=0.15)


@pytest.mark.parametrize("sigma", [0.005, 0.01])
def test_clutter_in_half_of_a_scan_does_not_mislead(sigma):
    found = []
    for seed in range(20):
        scan = a_room(seed, sigma)
        ranges = scan.ranges.copy()
        rng = np.random.default_rng(seed)
        start = int(rng.integers(0, 720))
        clutter = (start + np.arange(360)) % 720
        ranges[clutter] = rng.uniform(0.5, 4.0, 360)
        cluttered = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
        found.append(deviations(estimated(cluttered))[1])
    assert np.median(found) == pytest.approx(sigma, rel=0.3)
    assert (abs(np.log(np.array(found) / sigma)) < math.log(1.5)).mean() > 0.9


@pytest.mark.parametrize("step", [0.001, 0.01, 0.03])
def test_ranges_in_steps_have_at_least_the_noise_of_the_steps(step):
    for seed in range(10):
        scan = a_room(seed, 0.0)
        ranges = step * np.round(scan.ranges / step)
        coarse = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
        least = step / math.sqrt(12)
        assert 0.99 * least < deviations(estimated(coarse))[1] < 2 * least + 0.001


def test_ranges_without_noise_are_not_taken_to_be_exact():
    for seed in range(10):
        scan = a_room(seed, 0.0)
        sigma, relative = estimated(scan)
        mean = scan.ranges.mean()
        assert noise.FINEST * mean * 0.999 <= sigma < 0.001
        assert relative < 0.001


@pytest.mark.parametrize("beams", [0, 1, 2, 7, 8, 12, 20, 31])
def test_few_returns_have_a_noise_too(beams):
    scan = a_room(3, 0.005)
    few = LaserScan(angles=scan.angles[:beams], ranges=scan.ranges[:beams], range_max=30.0)
    sigma, relative = estimated(few)
    assert math.isfinite(sigma)
    assert relative >= 0
    if beams:
        assert 0 < sigma < 0.05
    if 0 < beams < noise.STRETCH:
        assert sigma >= noise.UNKNOWN * few.ranges.mean() * 0.999


def test_nothing_but_clutter_is_noise():
    rng = np.random.default_rng(2)
    scan = LaserScan.uniform(rng.uniform(0.5, 4.0, 360), -3.1, 0.017)
    sigma, relative = estimated(scan)
    assert sigma > 0 or relative > 0
    assert math.isfinite(sigma + relative)


def test_a_stretch_shows_its_scatter_about_its_line():
    points = kernels.weighed(a_room(4, 0.005), 1.0)
    variance, square, steps, least, mean = kernels.stretches(points)
    every = noise.STRETCH
    assert len(variance) == len(square) == len(steps) == 720 // every
    for k in range(0, len(variance), 7):
        expected, ratio = reference_engine.stretch_noise(points, k * every)
        assert variance[k] == pytest.approx(max(expected, least), rel=1e-6)
        assert steps[k] == pytest.approx(ratio, rel=1e-6)
        stretch = slice(k * every, (k + 1) * every)
        assert square[k] == pytest.approx(np.mean(points.x[stretch] ** 2 + points.y[stretch] ** 2))
    assert mean == pytest.approx(np.hypot(points.x, points.y).mean())


def lasting(scan, sigma, keep, seed):
    """Return a scan with errors of `sigma`, each of which keeps the share `keep` of the last."""
    rng = np.random.default_rng(seed)
    fresh = rng.normal(0.0, sigma * math.sqrt(1 - keep**2), len(scan))
    errors = lfilter([1.0], [1.0, -keep], fresh)
    return LaserScan(angles=scan.angles, ranges=scan.ranges + errors, range_max=30.0)


def test_independent_errors_show_the_ratio_of_von_neumann():
    points = [kernels.weighed(a_room(seed, 0.005), 1.0) for seed in range(40)]
    seen = np.concatenate([np.array(kernels.stretches(each)[:3]) for each in points], axis=1)
    ratios = seen[2, seen[0] < (2 * 0.005) ** 2]  # on walls
    assert np.median(ratios) == pytest.approx(noise.INDEPENDENT, rel=0.02)
    assert np.std(ratios) == pytest.approx(noise.SCATTER, rel=0.1)


@pytest.mark.parametrize("radius", [1.0, 2.0, 5.0])
def test_a_bend_of_the_wall_is_no_likeness_of_errors(radius):
    for seed in range(20):
        ranges = np.full(720, radius) + np.random.default_rng(seed).normal(0, 0.005, 720)
        scan = LaserScan.uniform(ranges, -math.pi, TURN / 720)
        assert correlation(scan) == 0


@pytest.mark.parametrize(("sigma", "relative"), [(0.005, 0.0), (0.01, 0.0), (0.004, 0.008)])
def test_independent_errors_are_not_alike(sigma, relative):
    found = [
        correlation(a_room(seed, sigma, relative, beams))
        for seed in range(50)
        for beams in (90, 181, 720)
    ]
    assert np.mean(np.array(found) > 0) < 0.02


@pytest.mark.parametrize("step", [0.001, 0.01, 0.03])
def test_steps_of_the_sensor_are_not_alike(step):
    for seed in range(20):
        scan = a_room(seed, 0.0)
        coarse = LaserScan(
            angles=scan.angles, ranges=step * np.round(scan.ranges / step), range_max=30.0
        )
        assert correlation(coarse) <= sequence.LIKENESS


@needs_compiler
def test_errors_that_last_do_not_part_walls():
    white, last, plain = [], [], []
    for seed in range(20):
        exact = a_room(seed, 0.0)
        scan = lasting(exact, 0.01, 0.97, seed)
        assert sequence.LIKENESS < correlation(scan) < 0.5
        white.append(len(WallDetector()(lasting(exact, 0.01, 0.0, seed)).lines))
        last.append(len(WallDetector()(scan).lines))
        plain.append(len(WallDetector(roughness=0.0)(scan).lines))
    assert np.mean(plain) > 3 * np.mean(white)
    assert np.mean(last) < 1.5 * np.mean(white)


def test_the_noise_does_not_depend_on_where_the_scan_looks():
    scan, _ = look(ROOM, sigma=0.005, beams=720, view=TURN * 719 / 720, pose=Pose2D(0.3, 0.2, 0.4))
    first = estimated(scan)
    for turn in (0.5, 1.0, 2.0):
        turned = LaserScan(angles=scan.angles + turn, ranges=scan.ranges, range_max=30.0)
        np.testing.assert_allclose(estimated(turned), first, rtol=1e-6, atol=1e-9)
