"""The raster's kernels beside their twins."""

import math

import kernels
import kernels_raster
import numpy as np
import pytest
import reference_candidates
import reference_raster
from hypothesis import given
from hypothesis import strategies as st
from laserfeatures_plugins.raster import drawing, shape, surfaces, walls
from laserfeatures_plugins.raster.uncertainty import covariances, edge_angles
from scenes import niche, niche_scan

seeds = st.integers(0, 10**6).map(np.random.default_rng)
PLAIN = math.atan(surfaces.PLAIN)
RESOLUTION = 0.02
SIGMA = 0.008
baselines = st.sampled_from([0.05, 0.1, 0.3])  # [m]


@given(seeds, st.floats(0.02, 0.8))
def test_near_returns_are_as_the_twin_says(rng, incidence):
    a = rng.uniform(-3, 3, 2)
    b = a + rng.normal(0, 0.5, 2)
    assert kernels_raster.is_near(a, b, incidence) == reference_raster.is_near(a, b, incidence)


@given(seeds, st.sampled_from([-1, 1]), baselines)
def test_a_point_lies_behind_a_surface_as_the_twin_says(rng, way, baseline):
    points, _, _ = niche(rng)
    m, other = rng.choice(len(points), 2, replace=False)
    found = kernels_raster.behind(points, m, way, other, 0.01, baseline)
    expected = reference_raster.behind(points, m, way, other, 0.01, (surfaces.NOISES, baseline))
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@given(seeds, st.floats(0.03, 0.3), st.sampled_from([0.002, 0.02]), baselines, st.integers(0, 4))
def test_surfaces_are_chained_as_the_twin_does(rng, incidence, sigma, baseline, max_missed):
    points, beams, _ = niche(rng)
    live = np.flatnonzero(rng.random(len(points)) < 0.95)[: rng.integers(0, len(points))]
    found = kernels_raster.contours(points, beams, live, incidence, sigma, baseline, max_missed)
    rules = surfaces.NOISES, baseline
    expected = reference_raster.contours(
        points[live], beams[live], incidence, sigma, max_missed, PLAIN, rules
    )
    assert found == [live[chain].tolist() for chain in expected]


@given(seeds, st.floats(0.005, 0.2), st.integers(0, 12))
def test_points_are_placed_as_the_twin_does(rng, resolution, margin):
    points = rng.uniform(-4, 4, 2) + rng.normal(0, 1, (rng.integers(1, 30), 2))
    chosen = rng.choice(len(points), rng.integers(1, 40))
    x, y, width, height, pixels = kernels_raster.place(points, chosen, resolution, margin)
    origin, size, expected = reference_raster.place(points[chosen], resolution, margin)
    np.testing.assert_allclose((x, y), origin, atol=1e-12)
    assert (width, height) == tuple(size)
    np.testing.assert_allclose(pixels / 2**drawing.FRACTION, expected, atol=0.51 / 2**4)
    nearest = np.floor(pixels / 2**drawing.FRACTION + 0.5)
    assert nearest.min() >= margin
    assert (nearest.max(axis=0) <= (width - 1 - margin, height - 1 - margin)).all()


@given(seeds, st.integers(6, 400), st.floats(0.005, 0.2))
def test_a_line_in_pixels_is_the_same_line_in_metres(rng, rows, resolution):
    rho, row, origin = rng.uniform(-900, 900), rng.integers(rows), rng.uniform(-9, 9, 2)
    line = rho, row * math.pi / rows
    theta, c, s, d = kernels_raster.to_metres(line, origin, rows, resolution)
    assert theta == pytest.approx(line[1])
    assert (c, s) == pytest.approx((math.cos(line[1]), math.sin(line[1])))
    along = rng.uniform(-500, 500)
    pixel = np.array([rho * c - along * s, rho * s + along * c])
    assert (origin + resolution * pixel) @ (c, s) == pytest.approx(d, abs=1e-4 * resolution * 900)


def bounds(max_missed, max_gap):
    """Return what a wall may be, as the kernels take it."""
    return 4, max_missed, max_gap, 0.4, 48, False


@given(seeds, st.integers(0, 3), st.floats(0.02, 0.6))
def test_a_seed_is_in_the_middle_of_the_longest_run(rng, max_missed, max_gap):
    points, beams, lines = niche(rng)
    line = lines[rng.integers(len(lines))] + rng.normal(0, 0.01, 2)
    free = np.flatnonzero(rng.random(len(points)) < 0.9)
    rules = (walls.LEAST, max_missed, max_gap)
    found = kernels_raster.seed_on(points, beams, free, line, 0.03, bounds(max_missed, max_gap))
    expected = reference_raster.seed_on(points[free], beams[free], line, 0.03, rules)
    assert found == (free[expected] if expected >= 0 else -1)


@given(seeds)
def test_only_free_points_are_kept(rng):
    taken = rng.random(30) < 0.5
    places = np.flatnonzero(rng.random(30) < 0.7)
    expected = [m for m in places if not taken[m]]
    assert kernels_raster.keep_free(taken, places).tolist() == expected


@given(seeds, st.sampled_from([0.0, 0.01, 3.13]))
def test_lines_repeat_each_other_as_the_twin_says(rng, theta):
    lines = [((theta + turn) % math.pi, rng.uniform(-1, 1)) for turn in rng.normal(0, 0.1, 3)]
    point = rng.uniform(-1, 1, 2)
    args = (theta, point, lines, math.radians(1), 0.05)
    expected = reference_raster.repeats(*args, walls.WINDOW)
    assert kernels_raster.repeats(*args) == expected


def some_lines(rng, truth):
    """Return what OpenCV might find of some walls, as it gives it and in metres."""
    origin, rows = rng.uniform(-3, 0, 2), 180
    true = truth[rng.choice(len(truth), 12)] + rng.normal(0, 0.01, (12, 2))
    row = np.floor(true[:, 0] * rows / math.pi).astype(int) % rows
    theta = row * math.pi / rows
    normal = np.stack([np.cos(theta), np.sin(theta)], axis=1)
    rho = np.round((true[:, 1] - normal @ origin) / RESOLUTION)
    found = kernels_raster.lines(np.stack([rho, theta], axis=1), origin, rows)
    return found, list(zip(theta, rho * RESOLUTION + normal @ origin, strict=True))


@given(seeds, st.integers(0, 4), st.sampled_from([0.05, 0.25]))
def test_lines_are_proposed_as_the_twin_does(rng, max_missed, max_gap):
    scan, truth = niche_scan(rng)
    points = kernels.weighed(scan, SIGMA)
    found, lines = some_lines(rng, truth)
    rules = (walls.LEAST, max_missed, max_gap)
    gate = RESOLUTION + walls.SIGMAS * SIGMA
    expected = reference_raster.propose(points, lines, gate, RESOLUTION, rules)
    rows = kernels_raster.propose(points, found, RESOLUTION, SIGMA, bounds(max_missed, max_gap))
    reference_candidates.assert_same(rows, expected)


@given(seeds, st.integers(0, 4))
def test_bins_are_taken_as_the_twin_does(rng, max_missed):
    scan, truth = niche_scan(rng)
    points = kernels.weighed(scan, SIGMA)
    found, lines = some_lines(rng, truth)
    bins = kernels_raster.bins_on(
        points, len(scan), found, RESOLUTION, SIGMA, bounds(max_missed, 0.25)
    )
    gate, step = RESOLUTION + walls.SIGMAS * SIGMA, math.pi / 180
    rules = (walls.LEAST, max_missed, 0.25)
    expected = reference_raster.bins(points, lines, gate, RESOLUTION, step, rules, walls.WINDOW)
    assert len(bins.lines) == len(expected)
    for k, (theta, d, spread, members) in enumerate(expected):
        assert (bins.lines.theta[k], bins.lines.d[k]) == pytest.approx((theta, d))
        np.testing.assert_allclose(bins.lines.covariance[k], spread, atol=1e-9)
        held = np.flatnonzero(bins.points[bins.line == k].any(axis=0))
        np.testing.assert_array_equal(held, points.beam[members])


def picture(rng):
    return rng.integers(0, 256, (24, 30)).astype(np.uint8)


@given(seeds)
def test_brightness_is_interpolated_as_the_twin_does(rng):
    image, u, v = picture(rng), rng.uniform(-2, 32), rng.uniform(-2, 26)
    expected = reference_raster.brightness(image, u, v)
    assert kernels_raster.brightness(image, u, v) == pytest.approx(expected)


@given(seeds, st.integers(3, 64), st.sampled_from([3, 256]))
def test_the_turn_on_a_ring_is_as_the_twin_says(rng, samples, levels):
    ring = rng.integers(0, levels, samples).astype(float)
    expected = reference_raster.turn_of(ring, levels / 2)
    assert kernels_raster.turn_of(ring, levels / 2) == pytest.approx(expected, abs=1e-9)


@given(seeds, st.floats(20.0, 255.0))
def test_the_turn_at_a_point_is_that_of_the_ring_around_it(rng, ridge):
    image, point = picture(rng), rng.uniform((0, 0), (29, 23))
    phi = np.arange(shape.SAMPLES) * 2 * math.pi / shape.SAMPLES
    ring = [
        reference_raster.brightness(
            image, point[0] + shape.RING * math.cos(a), point[1] + shape.RING * math.sin(a)
        )
        for a in phi
    ]
    expected = reference_raster.turn_of(ring, shape.LINE * ridge)
    assert kernels_raster.turns(image, point[None], ridge) == pytest.approx([expected], abs=1e-6)


@given(seeds)
def test_the_structure_tensor_is_as_the_twin_says(rng):
    image = picture(rng)
    points = rng.uniform((0, 0), (29, 23), (3, 2))
    expected = [reference_raster.structure(image, point, shape.WINDOW) for point in points]
    np.testing.assert_allclose(kernels_raster.structure(image, points), expected, rtol=1e-9)


@given(seeds, st.integers(0, 20))
def test_distinct_points_are_as_the_twin_says(rng, count):
    points, reach = rng.uniform(0, 1, (count, 2)), rng.uniform(0.1, 0.4, count)
    expected = reference_raster.distinct(points, reach)
    assert kernels_raster.distinct(points, reach).tolist() == expected


@given(seeds)
def test_a_covariance_is_the_inverse_tensor_of_trace_1_times_the_variance(rng):
    half = rng.normal(0, 1, (2, 2))
    tensor = half @ half.T + 0.1 * np.eye(2)
    points = int(rng.integers(0, 30))
    found = covariances(tensor[None], np.array([points]), 0.18, 0.02, 0.005)[0]
    n = max(points, 1)
    variance = 0.005**2 / n + (0.2 * 0.02) ** 2 + (0.08 * 0.36 / n) ** 2
    expected = variance * np.linalg.inv(tensor / np.trace(tensor))
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@given(st.floats(0.05, math.pi / 2), st.floats(0, math.pi))
def test_two_edges_have_their_angle(angle, turn):
    edges = [turn, turn + angle]
    tensor = sum(np.outer(g, g) for g in [(math.cos(a), math.sin(a)) for a in edges])
    assert edge_angles(tensor[None]) == pytest.approx([angle], abs=1e-6)
