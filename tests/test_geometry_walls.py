import math
from dataclasses import replace

import kernels
import numpy as np
import pytest
import reference
import reference_walls
from hypothesis import assume, given
from hypothesis import strategies as st
from scenes import chain, niche, poles, scan_of, wall

from laserfeatures import LaserScan, geometry
from laserfeatures.geometry import arcs, growth, noise, segments, walls

GAPS = (2, 0.15)  # max_missed, max_gap
seeds = st.integers(0, 10**6).map(np.random.default_rng)


@given(seeds, st.floats(0.01, 0.1))
def test_a_wall_grows_to_its_gaps_as_its_twin_does(rng, gate):
    points, beams, lines = niche(rng)
    line = lines[rng.integers(len(lines))] + rng.normal(0, 0.01, 2)
    line[0] = np.clip(line[0], 0, 3.14)
    free = rng.random(len(points)) < 0.9
    off = abs(points @ (math.cos(line[0]), math.sin(line[0])) - line[1])
    assume((free & (off < gate)).any())
    seed = int(rng.choice(np.flatnonzero(free & (off < gate))))
    members = kernels.grow(points, beams, free, seed, line, gate, *GAPS)
    expected = reference_walls.grow(
        points, beams, free, seed, line, gate, *GAPS, segments.MAX_GROWTH
    )  # fmt: skip
    assert sorted(members) == sorted(expected)
    assert members[0] == seed


@given(seeds, st.integers(4, 40))
def test_a_run_is_a_wall_where_it_is_tight_and_straight(rng, count):
    sigma = 0.005
    # From straight to clearly bent, from short to long, and from tight to loose.
    along = rng.choice([0.1, 0.2, 1.0]) * np.sort(rng.uniform(-1, 1, count))
    noise = rng.normal(0, rng.choice([0.002, 0.005, 0.02]), count)
    off = rng.choice([0, 0.3, 0.6, 1.0, 2.0]) * along**2 + noise
    points = np.stack([2.0 + off, rng.choice([0.0, 30.0]) + along], axis=1)
    members = np.arange(count)
    fit = kernels.fit_line(points, members, 0.0)
    flat, variance, worst = kernels.is_wall(points, members, fit, sigma)
    error = points @ (math.cos(fit[0]), math.sin(fit[0])) - fit[1]
    residual = (error**2).sum() / (count - 2)
    cosine = 1 / np.sqrt(reference.weights(points, fit[0], 0.0))
    loose = residual > max(2 * sigma, walls.FLATNESS) ** 2
    assert worst == pytest.approx(abs(error).max())
    grazing = count < walls.FEW and cosine.mean() < walls.GRAZING
    curve, deviation = reference_walls.bend(points, fit[:2])
    bent = abs(curve) > max(walls.CURVED * sigma * deviation, 0.5 / walls.FLAT_RADIUS)
    assert flat == (not (loose or grazing or bent))
    if flat:
        mean_variance = (cosine**2 + geometry.INCIDENCE_FLOOR).mean()
        assert variance == pytest.approx(residual / mean_variance, rel=1e-6)


def wall_from(points, beams, free, seed, theta, *, min_points=4):
    return kernels.find_wall(points, beams, free, seed, theta, sigma=0.005, cut=(min_points, *GAPS))


@given(seeds)
def test_a_wall_found_is_settled_free_and_explains_its_points(rng):
    points, beams, _ = niche(rng)
    free = rng.random(len(points)) < 0.95
    seed = int(rng.choice(np.flatnonzero(free)))
    members, fit, _ = wall_from(points, beams, free, seed, rng.integers(180) * math.pi / 180)
    if len(members) == 0:
        return
    assert len(members) >= 4
    assert free[members].all()
    assert len(set(members.tolist())) == len(members)
    assert kernels.is_wall(points, members, fit, 0.005)[0]
    np.testing.assert_allclose(kernels.fit_line(points, members, fit[0])[:2], fit[:2], atol=2e-3)
    off = abs(points[members] @ (math.cos(fit[0]), math.sin(fit[0])) - fit[1])
    assert off.max() < max(growth.SIGMAS * 0.005, 1.5 * walls.FLATNESS) + 0.01


def test_a_wall_is_found_from_any_of_its_points_and_a_direction_2_degrees_off():
    scan = scan_of(wall(0.3, 2.0, -1.0, 1.0), sigma=0.005)
    count = len(scan.points)
    for seed in range(5, count - 5, 7):
        members, fit, variance = wall_from(
            scan.points, scan.beams, np.ones(count, bool), seed, 0.3 + math.radians(2)
        )
        assert len(members) > 0.97 * count
        assert fit[:2] == pytest.approx((0.3, 2.0), abs=0.005)
        assert math.sqrt(variance) == pytest.approx(0.005, rel=0.2)


def test_a_wall_of_fewer_than_min_points_is_none():
    scan = scan_of(wall(0.3, 2.0, -0.05, 0.05))
    count = len(scan.points)
    everything = np.ones(count, bool)
    args = (scan.points, scan.beams, everything, count // 2, 0.3)
    assert len(wall_from(*args, min_points=count)[0]) == count
    assert len(wall_from(*args, min_points=count + 1)[0]) == 0


@given(seeds, st.integers(1, 20))
def test_nearest_member_is_the_nearest_of_them(rng, count):
    points = rng.uniform(-1, 1, (30, 2))
    members = np.sort(rng.choice(30, count, replace=False))
    theta, d = rng.uniform(0, math.pi), rng.uniform(-1, 1)
    off = abs(points @ (math.cos(theta), math.sin(theta)) - d)
    expected = members[off[members].argmin()]
    assert kernels.nearest_member(points, members, (theta, d)) == expected


@given(seeds, st.integers(1, 20))
def test_off_line_is_the_root_mean_square_distance(rng, count):
    points = rng.uniform(-1, 1, (30, 2))
    members = rng.choice(30, count, replace=False)
    off = points[members] @ (math.cos(1.1), math.sin(1.1)) - 0.3
    expected = math.sqrt((off**2).mean())
    assert kernels.off_line(points, members, (1.1, 0.3)) == pytest.approx(expected)


@given(seeds, st.integers(3, 99))  # of more points, it takes some
def test_noise_is_estimated_as_its_twin_says(rng, count):
    points = niche(rng)[0]
    first = rng.integers(len(points))
    points = points[first : first + count]
    expected = reference_walls.estimate_sigma(points, noise.BASELINE)
    sigma = kernels.estimate_sigma(points)
    if expected is None:
        assert sigma == 5 * noise.MIN_SIGMA
    else:
        limited = np.clip(expected, noise.MIN_SIGMA, noise.MAX_SIGMA)
        assert sigma == pytest.approx(limited, abs=2e-5)  # the kernel bisects


@given(seeds, st.integers(1, 60))
def test_the_median_is_the_upper_one_as_far_as_it_matters(rng, count):
    values = rng.choice([0.001, 0.02, 0.1]) * rng.exponential(1.0, count)
    expected = min(np.sort(values)[count // 2], noise.NORMAL * noise.MAX_SIGMA)
    limited = min(kernels.median(values), noise.NORMAL * noise.MAX_SIGMA)
    assert limited == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("sigma", [0.004, 0.01])
@pytest.mark.parametrize(
    "room",
    [
        [wall(0.3, 2.0, -2.0, 2.0)],
        chain((3, -2), (3, 1), (1, 1.5), (-0.5, 1.2)),
        chain((1, -2), (1, -0.5), (1.3, -0.5), (1.3, 0.4), (1, 0.4), (1, 2)),
    ],
)
def test_the_noise_estimated_is_about_the_true_one(room, sigma):
    # Measured: 1.00 to 1.35 times the truth; most where corners hide in the noise.
    estimates = [
        kernels.estimate_sigma(scan_of(*room, sigma=sigma, seed=seed).points) for seed in range(20)
    ]
    assert 0.85 * sigma < np.mean(estimates) < 1.5 * sigma


def test_noise_is_guessed_where_too_few_points_tell_it():
    points = scan_of(wall(0.0, 2.0, -0.05, 0.05)).points[:8]
    assert kernels.estimate_sigma(points) == 5 * noise.MIN_SIGMA


def test_no_scanner_is_taken_to_be_better_than_min_sigma():
    assert kernels.estimate_sigma(scan_of(wall(0.0, 2.0, -2, 2)).points) == noise.MIN_SIGMA


def set_aside(points, beams, radius=0.4, sigma=0.005):
    return kernels.set_arcs_aside(points, beams, sigma, 0.15, radius)


@given(seeds, st.sampled_from([0.1, 0.4]), st.sampled_from([0.005, 0.015]))
def test_arcs_are_set_aside_as_their_twin_says(rng, max_radius, sigma):
    radius = rng.choice([0.03, 0.08, 0.15, 0.3, 0.5])
    scan = poles((1.5, rng.uniform(-0.2, 0.2)), (1.7, 1.5), radius=radius, sigma=sigma, seed=rng)
    objects = chain((0.8, -2), (1, -1.2)), [[(2.0, -1), (2.0, -0.9)]], [[(1.9, 0.5), (2.1, 0.7)]]
    flat = scan_of(*(w for walls_ in objects for w in walls_), sigma=0.005, seed=rng)
    scan = LaserScan(angles=scan.angles, ranges=np.fmin(scan.ranges, flat.ranges), range_max=30.0)
    false = rng.random(len(scan)) < rng.choice([0.0, 0.1])
    scan = replace(scan, ranges=np.where(false, rng.uniform(0.5, 3.0, len(scan)), scan.ranges))
    keep = rng.random(len(scan.points)) < 0.9
    points, beams = scan.points[keep], scan.beams[keep]
    rules = (arcs.POST, arcs.FLAT, arcs.MAX_MISSED, arcs.MAX_STRAY, arcs.SMALL, arcs.EVIDENCE)
    expected = reference_walls.arcs(points, beams, sigma, 0.15, max_radius, rules)
    np.testing.assert_array_equal(set_aside(points, beams, max_radius, sigma), expected)


def test_poles_are_arcs_and_walls_are_not():
    post = poles((1.5, 0.0), radius=0.15)
    assert set_aside(post.points, post.beams).all()
    box = scan_of(*chain((1.4, 0.2), (1.4, -0.2)), sigma=0.005)
    assert not set_aside(box.points, box.beams).any()


@pytest.mark.parametrize(("radius", "away"), [(0.05, 1.5), (0.07, 1.5), (0.1, 2.0), (0.15, 2.0)])
def test_small_poles_are_told_from_small_boxes_in_noise(radius, away):
    aside = [
        set_aside(post.points, post.beams, sigma=0.01).all()
        for post in (poles((away, 0.0), radius=radius, sigma=0.01, seed=seed) for seed in range(50))
    ]
    assert np.mean(aside) >= 0.95
    boxes = [scan_of(wall(0.0, 1.5, -0.1, 0.1), sigma=0.01, seed=seed) for seed in range(50)]
    assert np.mean([set_aside(box.points, box.beams, sigma=0.01).any() for box in boxes]) <= 0.05


def test_an_arc_hollow_to_the_sensor_is_no_pole():
    bow = np.linspace(-0.9, 0.9, 60)
    hollow = np.stack([1.5 + 0.3 * np.cos(bow), 0.3 * np.sin(bow)], axis=1)
    assert not set_aside(hollow, np.arange(60)).any()
    convex = np.stack([1.5 - 0.3 * np.cos(bow), 0.3 * np.sin(bow)], axis=1)
    assert set_aside(convex, np.arange(60)).all()


def spoiled(scan, false):
    """Return a scan whose beams `false` are 1.2 m short, and which of its points are true."""
    ranges = scan.ranges.copy()
    ranges[false] -= 1.2
    return replace(scan, ranges=ranges), ~np.isin(scan.beams, false)


def test_what_false_beams_leave_of_a_wall_between_them_is_no_post():
    # Four beams of it are 7 cm wide: each piece alone would be a post.
    scan = scan_of(wall(0.0, 2.0, -0.26, 0.27), sigma=0.003)
    assert len(scan.points) == 30
    scan, _ = spoiled(scan, scan.beams[4::5])
    assert not set_aside(scan.points, scan.beams).any()


def test_a_pole_with_a_false_beam_in_its_middle_is_still_one():
    # Its halves alone would be walls: what bends so little is flat.
    scan = poles((1.5, 0.0), radius=0.15)
    scan, true = spoiled(scan, scan.beams[[len(scan.points) // 2]])
    np.testing.assert_array_equal(set_aside(scan.points, scan.beams), true)
