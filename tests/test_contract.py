"""What every extractor must do, whoever wrote it."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields

import numpy as np
import pytest
from contract import (
    every_extractor,
    finds_corners_only,
    finds_lines,
    finds_walls_only,
    the_corner,
    the_line,
)
from scenes import (
    TURN,
    chain,
    found_lines,
    line_errors,
    look,
    nearest_line,
    needs_compiler,
    normalised,
    poles,
    random_room,
    scan_of,
    true_lines,
    wall,
)

from laserfeatures import LaserScan

CORNER = chain((2, -1.5), (2, 1.2), (-0.5, 1.2))


@every_extractor
@pytest.mark.parametrize(
    "scan",
    [
        LaserScan(angles=[], ranges=[]),
        LaserScan(angles=[0.3], ranges=[2.0]),
        LaserScan(angles=[0.3, 0.4], ranges=[2.0, 2.0]),
        LaserScan.uniform([math.nan] * 90, -1.5, 0.03),
        LaserScan.uniform([math.inf] * 90, -1.5, 0.03),
        LaserScan.uniform([0.0] * 90, -1.5, 0.03),
        LaserScan.uniform([12.0, 0.01] * 45, -1.5, 0.03, range_min=0.05, range_max=10.0),
    ],
    ids=["empty", "one beam", "two beams", "nan", "inf", "zero", "outside the limits"],
)
def test_a_scan_without_walls_has_no_features(case, scan):
    features = case.make()(scan)
    assert len(features.lines) == len(features.segments) == len(features.corners) == 0
    assert features.segments.points.shape == (0, len(scan))
    assert features.segments.endpoints.shape == features.lines.covariance.shape == (0, 2, 2)
    assert features.corners.positions.shape == (0, 2)


@finds_lines
@pytest.mark.parametrize("d", [0.6, 2.0, 6.0])
@pytest.mark.parametrize("theta", np.radians([-61, -20, 3, 30, 77]))
def test_a_wall_is_one_line_with_one_segment(case, theta, d):
    scan = scan_of(wall(theta, d, -0.8, 1.0), sigma=0.003, beams=721)
    features = case.make()(scan)
    k = the_line(case, features, normalised(theta, d))
    if not case.literal:
        assert len(features.lines) == len(features.segments) == 1
    longest = np.argmax(np.where(features.segments.line == k, features.segments.lengths, 0))
    if d * math.tan(abs(theta)) < d:  # grazing walls lose their far end
        assert features.segments.lengths[longest] == pytest.approx(1.8, abs=0.1)


@finds_lines
@pytest.mark.parametrize("off", [0.0, 1e-6, 0.003, -1e-6, -0.003])
@pytest.mark.parametrize("d", [2.0, -2.0])
def test_a_wall_at_the_wrap_of_theta_is_found_once(case, off, d):
    scan = scan_of(wall(off, d, -1.0, 1.0), sigma=0.003, view=TURN * 719 / 720, beams=720)
    features = case.make()(scan)
    the_line(case, features, normalised(off, d))
    # Just once also where twice the tolerance is allowed, and more.
    assert len(nearest_line(found_lines(features), normalised(off, d), 0.08, 0.2)) == 1


@finds_lines
def test_both_walls_of_a_corner_are_found(case):
    features = case.make()(scan_of(*CORNER, sigma=0.003))
    for truth in true_lines(CORNER):
        the_line(case, features, truth)


@every_extractor
def test_a_corner_is_found_where_it_is(case):
    features = case.make()(scan_of(*CORNER, sigma=0.003))
    k = the_corner(case, features, (2.0, 1.2))
    assert features.corners.real[k]
    assert features.corners.angles[k] == pytest.approx(math.pi / 2, abs=2 * case.angle)


@finds_walls_only
def test_a_corner_that_a_gap_hides_is_virtual(case):
    walls = [[(2, -1.5), (2, 0.4)], [(1.2, 1.2), (-0.5, 1.2)]]
    features = case.make()(scan_of(*walls, sigma=0.003))
    np.testing.assert_allclose(features.corners.positions, [[2.0, 1.2]], atol=0.02)
    assert features.corners.real.tolist() == [False]


@finds_lines
def test_both_walls_of_a_corridor_are_kept(case):
    walls = [wall(math.pi / 2, 0.7, -4, 1), wall(math.pi / 2, -0.6, -4, 1)]
    features = case.make()(scan_of(*walls, sigma=0.003))
    first, second = (the_line(case, features, truth) for truth in true_lines(walls))
    assert first != second


@finds_walls_only
def test_a_wall_with_a_door_is_one_line_with_two_segments(case):
    walls = [[(2, -1.6), (2, -0.5)], [(2, 0.5), (2, 1.6)]]
    features = case.make()(scan_of(*walls, [(3.5, -2), (3.5, 2)], sigma=0.003))
    k = the_line(case, features, (0.0, 2.0))
    pieces = features.segments.endpoints[features.segments.line == k]
    np.testing.assert_allclose(np.sort(pieces[:, :, 1].ravel()), [-1.6, -0.5, 0.5, 1.6], atol=0.05)
    the_line(case, features, (0.0, 3.5))  # what is seen through the door
    assert len(features.lines) == 2


@finds_walls_only
@pytest.mark.parametrize("radius", [0.04, 0.1, 0.2])
def test_poles_are_no_walls(case, radius):
    for seed in range(20):
        scan = poles((1.5, 0.8), (1.8, -0.7), (3.0, 0.1), (2.5, 2.0), radius=radius, seed=seed)
        assert len(scan.points) > 10
        assert len(case.make()(scan).lines) == 0


@finds_walls_only
@pytest.mark.parametrize("seed", range(8))
def test_no_surface_is_found_twice(case, seed):
    rng = np.random.default_rng(seed)
    world, pose = random_room(rng)
    scan, _ = look(world, sigma=0.005, seed=seed, beams=720, view=TURN * 719 / 720, pose=pose)
    features = case.make()(scan)
    assert len(features.lines) >= 5
    lines = found_lines(features)
    for i, line in enumerate(lines):
        errors = abs(line_errors(np.delete(lines, i, axis=0), line))
        assert not ((errors[:, 0] < math.radians(4)) & (errors[:, 1] < 0.08)).any()
    # No beam is on two walls, but for a few at the corners.
    assert (features.segments.points.sum(axis=0) > 1).sum() <= len(features.corners)


@every_extractor
@pytest.mark.parametrize("turn", [0.1, 1.0, math.pi / 2, 2.0, math.pi, -2.5])
def test_a_turned_scan_has_the_turned_features(case, turn):
    scan = scan_of(*CORNER, sigma=0.003)
    turned = LaserScan(angles=scan.angles + turn, ranges=scan.ranges, range_max=scan.range_max)
    extractor = case.make()
    features, other = extractor(scan), extractor(turned)
    for truth in true_lines(CORNER) if case.lines else ():
        before = found_lines(features)[the_line(case, features, truth)]
        expected = normalised(before[0] + turn, before[1])
        after = the_line(case, other, expected)
        assert abs(line_errors(found_lines(other)[after], expected)).max() < case.angle
    c, s = math.cos(turn), math.sin(turn)
    the_corner(case, features, (2.0, 1.2))
    the_corner(case, other, (2.0 * c - 1.2 * s, 2.0 * s + 1.2 * c))


@every_extractor
@pytest.mark.parametrize("degrees", [5, 60, 180, 270, 359.5, 360])
def test_any_field_of_view_will_do(case, degrees):
    square = chain((2, -2), (2, 2), (-2, 2), (-2, -2), (2, -2))
    scan, hit = look(square, sigma=0.003, view=math.radians(degrees), beams=361)
    features = case.make()(scan)
    seen = [(hit == k).sum() > 30 for k in range(4)]
    for k, truth in enumerate(true_lines(square)):
        if case.lines and seen[k]:
            the_line(case, features, truth)
        if seen[k] and seen[(k + 1) % 4]:
            the_corner(case, features, square[k][1])


@every_extractor
def test_features_are_arrays_that_cannot_be_changed(case):
    features = case.make()(scan_of(*CORNER, sigma=0.003))
    kinds = {"line": np.int64, "lines": np.int64, "points": np.bool_, "real": np.bool_}
    for record in (features.lines, features.segments, features.corners):
        for field in fields(record):
            array = getattr(record, field.name)
            if not isinstance(array, np.ndarray):
                continue
            assert array.dtype == kinds.get(field.name, np.float64), field.name
            assert array.flags.c_contiguous, field.name
            assert not array.flags.writeable, field.name
            assert np.isfinite(array).all(), field.name
    assert ((features.lines.theta >= 0) & (features.lines.theta < math.pi)).all()


@finds_lines
def test_features_fit_together(case):
    rng = np.random.default_rng(5)
    world, pose = random_room(rng)
    scan, _ = look(world, sigma=0.005, beams=720, view=TURN * 719 / 720, pose=pose)
    features = case.make()(scan)
    segments, corners = features.segments, features.corners
    assert features.scan is scan
    assert set(segments.line.tolist()) == set(range(len(features.lines)))
    np.testing.assert_array_equal(segments.points.sum(axis=1), segments.support)
    assert not segments.points[:, ~scan.valid].any()
    normal = np.stack([np.cos(features.lines.theta), np.sin(features.lines.theta)], axis=1)
    for j, k in enumerate(segments.line):
        np.testing.assert_allclose(
            segments.endpoints[j] @ normal[k], features.lines.d[k], atol=1e-9
        )
    for pair, position in zip(corners.lines, corners.positions, strict=True):
        np.testing.assert_allclose(normal[pair] @ position, features.lines.d[pair], atol=1e-9)


@finds_corners_only
def test_corners_without_lines_are_real_and_on_none(case):
    rng = np.random.default_rng(5)
    world, pose = random_room(rng)
    scan, _ = look(world, sigma=0.005, beams=720, view=TURN * 719 / 720, pose=pose)
    features = case.make()(scan)
    assert features.scan is scan
    assert len(features.lines) == len(features.segments) == 0
    assert len(features.corners) >= 4
    assert features.corners.real.all()
    assert (features.corners.lines == -1).all()
    assert ((features.corners.angles > 0) & (features.corners.angles <= math.pi / 2)).all()


@every_extractor
def test_covariances_are_symmetric_and_positive_definite(case):
    rng = np.random.default_rng(6)
    for _ in range(5):
        world, pose = random_room(rng)
        scan, _ = look(world, sigma=0.005, beams=720, view=TURN * 719 / 720, pose=pose)
        features = case.make()(scan)
        for record in (features.lines, features.corners) if case.lines else (features.corners,):
            covariance = record.covariance
            assert len(covariance) > 0
            np.testing.assert_array_equal(covariance, covariance.swapaxes(1, 2))
            assert (np.linalg.eigvalsh(covariance)[:, 0] > 0).all()


def same(features, other):
    """Tell whether two results are the same to the last bit."""
    return all(
        np.array_equal(getattr(a, field.name), getattr(b, field.name))
        for a, b in zip(
            (features.lines, features.segments, features.corners),
            (other.lines, other.segments, other.corners),
            strict=True,
        )
        for field in fields(a)
        if isinstance(getattr(a, field.name), np.ndarray)
    )


def some_scans(count):
    rng = np.random.default_rng(8)
    rooms = [random_room(rng) for _ in range(count)]
    return [
        look(world, sigma=0.005, seed=n, beams=360, view=TURN * 359 / 360, pose=pose)[0]
        for n, (world, pose) in enumerate(rooms)
    ]


@every_extractor
def test_the_same_scan_gives_the_same_features_whatever_came_before(case):
    extractor = case.make()
    scans = some_scans(5)
    first = [extractor(scan) for scan in scans]
    assert not same(first[0], first[1])
    again = [extractor(scan) for scan in reversed(scans)][::-1]
    fresh = [case.make()(scan) for scan in scans]
    for a, b, c in zip(first, again, fresh, strict=True):
        assert same(a, b)
        assert same(a, c)


@every_extractor
@needs_compiler
def test_threads_that_share_an_extractor_get_the_same_features(case):
    extractor = case.make()
    scans = some_scans(6) * 20
    alone = [extractor(scan) for scan in scans]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(extractor, scans))
    assert all(same(a, b) for a, b in zip(alone, together, strict=True))


@every_extractor
def test_inputs_are_left_as_they_were(case):
    scan = scan_of(*CORNER, sigma=0.003)
    before = scan.angles.copy(), scan.ranges.copy(), scan.points.copy()
    case.make()(scan)
    for array, kept in zip((scan.angles, scan.ranges, scan.points), before, strict=True):
        np.testing.assert_array_equal(array, kept)


@every_extractor
@needs_compiler
def test_a_hundred_thousand_beams_are_no_trouble(case):
    scan = scan_of(*CORNER, sigma=0.003, beams=100_000)
    features = case.make()(scan)
    for truth in true_lines(CORNER) if case.lines else ():
        the_line(case, features, truth)
    the_corner(case, features, (2.0, 1.2))


@finds_walls_only
@pytest.mark.parametrize("count", [6, 12])
def test_beams_that_return_one_and_the_same_range_far_off_are_no_wall(case, count):
    scan = scan_of(*CORNER, sigma=0.005, seed=3, beams=361)
    ranges = scan.ranges.copy()
    ranges[200 : 200 + count] = 29.9  # what a sensor tells that is blinded
    spoiled = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
    lines = len(case.make()(spoiled).lines)
    missing = LaserScan(
        angles=scan.angles, ranges=np.where(ranges == 29.9, np.inf, ranges), range_max=30.0
    )
    assert lines == len(case.make()(missing).lines)
