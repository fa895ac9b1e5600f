"""Scans that go round: where the first beam is makes no difference."""

import math
import os

import numpy as np
import pytest
from scenes import TURN, found_lines, look, nearest_line, random_room

import laserfeatures as lf
from laserfeatures import LaserScan
from laserfeatures.simulation import World

ROWS = {"direct_hough": 180, "raster_hough": 4}  # turns by which their grids fall on themselves
SLOW = os.environ.get("NUMBA_DISABLE_JIT") == "1"
TURNS = 2 if SLOW else 12
rooms = pytest.mark.parametrize("seed", range(2 if SLOW else 4))
resolutions = pytest.mark.parametrize("beams", [360] if SLOW else [360, 720])
WALLS = [name for name in lf.list_extractors() if name != "kanade_tomasi"]
every_wall_extractor = pytest.mark.parametrize("name", WALLS)
ROOM = [(-3, -2.2), (2.6, -2.2), (2.6, 1.9), (-3, 1.9)]
COLUMN = [
    (-1.5 + 0.2 * math.cos(a), 0.2 * math.sin(a)) for a in np.linspace(0, TURN, 24, endpoint=False)
]


def around(ranges, first=-math.pi, **rest):
    """Return a scan of evenly spaced beams that go round once."""
    return LaserScan.uniform(ranges, first, TURN / len(ranges), range_max=30.0, **rest)


def room(seed, beams, *, sigma=0.005):
    """Return a scan around a random room, with partitions and a column."""
    rng = np.random.default_rng(seed)
    if seed % 2:
        world, pose = random_room(rng)
    else:
        x, y = rng.uniform(-0.4, 0.4, 2)
        partitions = [[(0.8, 1.9), (0.8, 0.7)], [(-0.6, -2.2), (-0.6, -1.0)]]
        column = [(x + 0.9, y - 1.1), (x + 1.1, y - 1.3), (x + 1.3, y - 1.1), (x + 1.1, y - 0.9)]
        parts = World.outline(ROOM, column).walls
        world, pose = World(walls=[*parts, *partitions]), lf.Pose2D(x, y, rng.uniform(-3, 3))
    view = TURN * (beams - 1) / beams
    return look(world, sigma=sigma, seed=seed, beams=beams, view=view, pose=pose)[0].ranges


def rotated(points, turn):
    """Return points turned about the sensor."""
    c, s = math.cos(turn), math.sin(turn)
    return points @ np.array([[c, s], [-s, c]])


def sorted_by(points, *others):
    """Return points and what goes with them in an order that errors of rounding keep."""
    key = np.round(points.reshape(len(points), points[:1].size or 1), 4)
    order = np.lexsort(key.T[::-1])
    return points[order], *(other[order] for other in others)


def normals(features):
    """Return the foot of each line, (L, 2)."""
    theta, d = found_lines(features).T
    return np.stack([d * np.cos(theta), d * np.sin(theta)], axis=1)


def assert_same(features, other, turn, shift):
    """Assert that two results are one to one the same, the other turned by so much.

    `shift`: by how many beams.
    """
    assert len(features.lines) == len(other.lines)
    assert len(features.segments) == len(other.segments)
    assert len(features.corners) == len(other.corners)
    feet, support, evidence = sorted_by(
        rotated(normals(features), turn), features.lines.support, features.lines.evidence
    )
    others = sorted_by(normals(other), other.lines.support, other.lines.evidence)
    np.testing.assert_allclose(others[0], feet, atol=1e-6)
    np.testing.assert_array_equal(others[1], support)
    np.testing.assert_allclose(others[2], evidence, rtol=1e-4, atol=1e-4)
    ends, beams = sorted_by(
        rotated(features.segments.endpoints, turn), np.roll(features.segments.points, shift, 1)
    )
    other_ends, other_beams = sorted_by(other.segments.endpoints, other.segments.points)
    np.testing.assert_allclose(other_ends, ends, atol=1e-6)
    np.testing.assert_array_equal(other_beams, beams)
    at, real, spread = sorted_by(
        rotated(features.corners.positions, turn),
        features.corners.real,
        np.trace(features.corners.covariance, axis1=1, axis2=2),
    )
    others = sorted_by(
        other.corners.positions,
        other.corners.real,
        np.trace(other.corners.covariance, axis1=1, axis2=2),
    )
    np.testing.assert_allclose(others[0], at, atol=1e-6)
    np.testing.assert_array_equal(others[1], real)
    np.testing.assert_allclose(others[2], spread, rtol=1e-4)


def columns_in_walls(seed, beams):
    """Return the ranges of a scan around a room with half columns and a face behind another."""
    rng = np.random.default_rng(seed)
    poles = [(2.6, rng.uniform(-0.9, 0.9), 0.3), (rng.uniform(-2, 1), 1.9, 0.2), (-3, 0.2, 0.45)]
    outline = [(-3, -2.2), (0, -2.2), (0, -2.24), (2.6, -2.24), (2.6, 1.9), (-3, 1.9)]
    world = World(walls=World.outline(outline).walls, poles=poles)
    pose = lf.Pose2D(*rng.uniform(-0.4, 0.4, 2), rng.uniform(-3, 3))
    view = TURN * (beams - 1) / beams
    return look(world, sigma=0.005, seed=seed, beams=beams, view=view, pose=pose)[0].ranges


@every_wall_extractor
@resolutions
@rooms
@pytest.mark.parametrize(("scene", "least"), [(room, 5), (columns_in_walls, 4)])
def test_features_do_not_depend_on_where_a_full_turn_begins(name, beams, seed, scene, least):
    extractor = lf.get_extractor(name)
    ranges = scene(seed, beams)
    features = extractor(around(ranges))
    assert len(features.lines) >= least
    for shift in np.random.default_rng(seed).integers(1, beams, TURNS).tolist():
        begun = around(np.roll(ranges, shift), -math.pi - shift * TURN / beams)
        assert_same(features, extractor(begun), 0.0, shift)


@every_wall_extractor
@resolutions
@rooms
def test_features_turn_with_the_world(name, beams, seed):
    extractor = lf.get_extractor(name)
    ranges = room(seed, beams)
    features = extractor(around(ranges))
    step = beams // ROWS.get(name, beams)
    for count in np.random.default_rng(seed + 9).integers(1, beams // step, TURNS).tolist():
        shift = step * count
        other = extractor(around(np.roll(ranges, shift)))
        assert_same(features, other, shift * TURN / beams, shift)


@every_wall_extractor
@pytest.mark.parametrize("harm", ["no returns", "outliers", "coarse", "half", "few beams"])
def test_a_poor_scan_may_begin_anywhere_too(name, harm):
    extractor = lf.get_extractor(name)
    rng = np.random.default_rng(3)
    beams = 90 if harm == "few beams" else 360
    ranges = np.array(room(2, beams))
    lost = rng.random(beams) < (0.5 if harm == "half" else 0.08)
    if harm == "no returns":
        ranges[lost], ranges[100:150] = math.inf, math.inf
    elif harm in {"outliers", "half"}:
        ranges[lost] = rng.uniform(0.3, 10, lost.sum())
    elif harm == "coarse":
        ranges = np.round(ranges, 2)
    features = extractor(around(ranges))
    for shift in rng.integers(1, beams, TURNS).tolist():
        begun = around(np.roll(ranges, shift), -math.pi - shift * TURN / beams)
        assert_same(features, extractor(begun), 0.0, shift)


def seen(walls, *, beams=360, heading=0.0, seed=0):
    """Return a scan around some walls whose first beam points backwards, and what it hits."""
    step = TURN / beams
    pose = lf.Pose2D(0.0, 0.0, heading - step / 2)
    scan, hit = look(walls, sigma=0.005, seed=seed, beams=beams, view=TURN - step, pose=pose)
    return around(scan.ranges), hit


def the_line(features, theta, d):
    """Return the index of a line, which must be there once."""
    (k,) = nearest_line(found_lines(features), (theta, d), math.radians(2), 0.02)
    return k


@every_wall_extractor
def test_a_wall_across_the_seam_is_one_segment(name):
    scan, hit = seen(World.outline(ROOM))
    features = lf.get_extractor(name)(scan)
    assert len(features.lines) == len(features.segments) == 4
    k = the_line(features, 0.0, -3.0)
    (j,) = np.flatnonzero(features.segments.line == k)
    held = features.segments.points[j]
    assert held[0]
    assert held[-1]
    assert (held != (hit == hit[0])).sum() <= 2  # at the corners
    assert features.segments.support[j] == features.lines.support[k] == held.sum()
    np.testing.assert_allclose(
        features.segments.endpoints[j], [(-3, 1.9), (-3, -2.2)], atol=0.1
    )  # in the order of the beams


@every_wall_extractor
@pytest.mark.parametrize("degrees", [-3.5, -0.5, 0.0, 0.5, 2.5])
def test_a_corner_at_the_seam_is_there_once(name, degrees):
    heading = math.atan2(1.9, -3.0) - math.pi - math.radians(degrees)
    scan, _ = seen(World.outline(ROOM), heading=heading)
    features = lf.get_extractor(name)(scan)
    assert len(features.lines) == len(features.segments) == len(features.corners) == 4
    corner = rotated(np.array([[-3.0, 1.9]]), -heading)
    off = np.hypot(*(features.corners.positions - corner).T)
    assert (off < 0.02).sum() == 1
    assert features.corners.real.all()


@every_wall_extractor
def test_a_panel_of_seven_beams_across_the_seam_is_a_wall(name):
    half = 1.5 * math.tan(math.radians(3.2))
    panel = [[(-1.5, -half), (-1.5, half)]]
    scan, _ = seen(World(walls=[*World.outline(ROOM).walls, *panel]))
    assert (scan.ranges[[0, 1, 2, 3, -1, -2, -3]] < 1.6).all()
    features = lf.get_extractor(name)(scan)
    k = the_line(features, 0.0, -1.5)
    assert features.lines.support[k] == 7
    assert (features.segments.line == k).sum() == 1
    assert len(features.lines) == 5


@every_wall_extractor
@pytest.mark.parametrize("seed", range(3))
def test_a_column_across_the_seam_is_no_wall(name, seed):
    scan, _ = seen(World.outline(ROOM, COLUMN), beams=720, seed=seed)
    assert scan.ranges[0] < 1.4
    features = lf.get_extractor(name)(scan)
    assert len(features.lines) == 4
    assert not features.segments.points[:, scan.ranges < 1.6].any()


@every_wall_extractor
@pytest.mark.parametrize("seed", range(3))
def test_a_direction_measured_twice_counts_once(name, seed):
    ranges = room(seed, 360)
    twice = LaserScan.uniform([*ranges, ranges[0] + 0.004], -math.pi, TURN / 360, range_max=30.0)
    assert twice.closed
    extractor = lf.get_extractor(name)
    once, features = extractor(around(ranges)), extractor(twice)
    assert features.segments.points.shape[1] == 361
    np.testing.assert_array_equal(features.segments.support, once.segments.support)
    np.testing.assert_array_equal(features.lines.support, once.lines.support)
    np.testing.assert_allclose(features.lines.d, once.lines.d, atol=1e-9)
    np.testing.assert_array_equal(features.segments.points[:, :-1], once.segments.points)
    np.testing.assert_array_equal(features.segments.points.sum(axis=1), features.segments.support)


@every_wall_extractor
def test_a_direction_measured_twice_counts_by_the_beam_that_returned(name):
    ranges = np.append(room(1, 360), 0.0)
    ranges[[0, -1]] = ranges[[-1, 0]]
    scan = LaserScan.uniform(ranges, -math.pi, TURN / 360, range_max=30.0)
    points = lf.get_extractor(name)(scan).segments.points
    assert not points[:, 0].any()
    assert points[:, -1].any()


@every_wall_extractor
def test_the_ends_of_an_open_scan_are_not_joined(name):
    beams = 271
    scan = look(World.outline(ROOM), sigma=0.005, beams=beams, view=math.radians(270))[0]
    assert not scan.closed
    features = lf.get_extractor(name)(scan)
    ends = features.segments.points[:, [0, -1]]
    assert ends.sum() == 2
    assert not ends.all(axis=1).any()


@pytest.mark.parametrize(
    ("beams", "degrees", "ring"),
    [
        (360, 359.0, 1),
        (361, 360.0, 2),
        (720, 359.5, 1),
        (360, 358.6, 1),
        (360, 359.4, 1),
        (360, 359.6, 1),
        (360, 358.0, 0),
        (271, 270.0, 0),
        (2, 180.0, 0),
        (1, 0.0, 0),
        (0, 0.0, 0),
        (4, 270.0, 1),
    ],
)
def test_a_scan_is_closed_where_the_next_beam_would_be_the_first(beams, degrees, ring):
    angles = np.linspace(-math.pi, -math.pi + math.radians(degrees), beams)
    scan = LaserScan(angles=angles, ranges=np.ones(beams))
    assert scan.ring == ring
    assert scan.closed == (ring > 0)


@every_wall_extractor
@pytest.mark.parametrize("aside", [0.0, 0.4, 1.0])
def test_a_round_room_has_no_walls_and_no_corners(name, aside):
    directions = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    across = aside * np.sin(directions)
    ranges = np.sqrt(2.0**2 - across**2) - aside * np.cos(directions)
    for seed in range(3):
        noise = np.random.default_rng(seed).normal(0, 0.01, 720)
        features = lf.get_extractor(name)(around(ranges + noise))
        assert len(features.lines) == len(features.corners) == 0


@every_wall_extractor
def test_a_stray_inside_a_wall_is_no_place_to_cut(name):
    # Before, 68 to 75 of 200 such scans had a wall in two segments.
    directions = (np.arange(720) + 0.3) * TURN / 720
    c, s = np.cos(directions), np.sin(directions)
    ranges = np.minimum(np.where(c > 0, 3 / c, -2 / c), np.where(s > 0, 2.5 / s, -1.5 / s))
    extractor, rng, parted = lf.get_extractor(name), np.random.default_rng(1), 0
    for _ in range(10 if SLOW else 60):
        scan = LaserScan(angles=directions, ranges=ranges + rng.normal(0, 0.01, 720), range_max=20)
        parted += len(extractor(scan).segments) != 4
    assert parted <= 2
