"""Walls of two faces, waves and half columns, as all extractors of lines find them."""

import math

import numpy as np
import pytest
from scenes import TURN, found_lines, line_errors, look, needs_compiler, true_lines

import laserfeatures as lf
from laserfeatures import LaserScan
from laserfeatures.simulation import World

SIGMA = 0.005
WALLS = [name for name in lf.list_extractors() if name != "kanade_tomasi"]
every_wall_extractor = pytest.mark.parametrize("name", WALLS)
ROOM = [(-3, -2.2), (2.6, -2.2), (2.6, 1.9), (-3, 1.9)]
RADII = [0.15, 0.2, 0.3, 0.4, 0.5]
SEEDS = 24

pytestmark = needs_compiler


def are_lines(features, walls):
    """Tell whether the lines found are those of some walls, each d within 3 of its sigmas."""
    truth = true_lines(walls)
    errors = line_errors(found_lines(features)[:, None], truth)
    nearest = abs(errors[..., 1]).argmin(axis=0)
    off = errors[nearest, np.arange(len(truth)), 1]
    known = abs(off) < 3 * np.sqrt(features.lines.covariance[nearest, 1, 1])
    return bool(sorted(nearest) == list(range(len(features.lines))) and known.all())


def faces(gap):
    """Return a wall whose second half is farther by a gap."""
    return [[(2, -1.2), (2, 0)], [(2 + gap, 0), (2 + gap, 1.2)]]


def leaf_in_wall(gap):
    """Return a wall, a door leaf that stands before it by a gap, and the wall again."""
    return [[(2, -1.5), (2, -0.4)], [(2 - gap, -0.4), (2 - gap, 0.5)], [(2, 0.5), (2, 1.5)]]


def seen(walls, seed, *, sigma=SIGMA, beams=541):
    """Return a scan of walls ahead and which of them each beam hits."""
    return look(walls, sigma=sigma, seed=seed, beams=beams, view=math.radians(120))


@every_wall_extractor
@pytest.mark.parametrize("gap", [0.03, 0.04, 0.05, 0.08, -0.03])
def test_two_faces_a_few_centimetres_apart_are_two_lines(name, gap):
    extractor = lf.get_extractor(name)
    for seed in range(6):
        assert are_lines(extractor(seen(faces(gap), seed)[0]), faces(gap))


@every_wall_extractor
@pytest.mark.parametrize("gap", [0.03, 0.06, -0.04])
def test_a_wall_on_both_sides_of_a_door_leaf_is_one_line_and_the_leaf_another(name, gap):
    walls = leaf_in_wall(gap)
    extractor = lf.get_extractor(name)
    for seed in range(6):
        scan, hit = seen(walls, seed)
        features = extractor(scan)
        assert are_lines(features, walls[:2])
        leaf = abs(abs(features.lines.d) - 2 + gap).argmin()
        members = features.segments.points[features.segments.line == leaf].any(axis=0)
        assert (members != (hit == 1)).sum() <= 4  # at its edges


# Measured, of 20 seeds, of all extractors: 15 to 19, 14 to 19, 18 to 19; before walls were parted
# at steps 3, 3 and 7, but optimal_partition 19, 19 and 18. What is not right is mostly three
# lines, one of them tilted and on both far ends.
@every_wall_extractor
@pytest.mark.parametrize(
    ("walls", "sigma", "beams", "least"),
    [
        (faces(0.03), 0.012, 361, 13),
        (faces(0.04), 0.016, 361, 12),
        (leaf_in_wall(0.03), 0.02, 181, 16),
    ],
    ids=["faces 3 cm", "faces 4 cm", "leaf"],
)
def test_most_faces_apart_by_two_standard_deviations_are_lines_of_their_own(
    name, walls, sigma, beams, least
):
    extractor = lf.get_extractor(name)
    scans = [seen(walls, seed, sigma=sigma, beams=beams)[0] for seed in range(20)]
    right = sum(are_lines(extractor(scan), walls[:2]) for scan in scans)
    assert right >= least


def wavy(seed, length, height=0.003, beams=361):
    """Return a scan of a wall of 5 m that waves by so much to either side."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(-0.9, 0.9, beams)
    waves = height * np.sin(TURN * 2 * np.tan(angles) / length + rng.uniform(0, TURN))
    ranges = (2 + waves) / np.cos(angles) + rng.normal(0, SIGMA, beams)
    return LaserScan(angles=angles, ranges=ranges, range_max=30.0)


@every_wall_extractor
@pytest.mark.parametrize(("length", "least"), [(0.1, 20), (0.3, 20), (0.7, 17)])
def test_a_wall_with_waves_lower_than_the_noise_is_one_line(name, length, least):
    # Measured, of 40 seeds: 40, 40, 37. Waves of 1.5 m part more walls: 31 of 40 are one line.
    lines = [len(lf.get_extractor(name)(wavy(seed, length)).lines) for seed in range(20)]
    assert lines.count(1) >= least


def half_column(radius, seed, ring):
    """Return a scan of a room with a half column in a wall, and which beams hit that."""
    rng = np.random.default_rng(seed)
    pole = [(2.6, rng.uniform(-0.9, 0.7), radius)]
    world = World(walls=World.outline(ROOM).walls, poles=pole)
    pose = lf.Pose2D(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-1, 1) * (3 if ring else 0.5))
    beams, view = (720, TURN * 719 / 720) if ring else (541, math.radians(270))
    scan, hit = look(world, sigma=SIGMA, seed=seed, beams=beams, view=view, pose=pose)
    return scan, hit == 4


def false_lines(features, on_column):
    """Return how many lines have most of their returns on the column."""
    members = np.zeros((len(features.lines), len(on_column)), bool)
    np.logical_or.at(members, features.segments.line, features.segments.points)
    return int((2 * (members & on_column).sum(axis=1) > members.sum(axis=1)).sum())


# Measured, of 120 scans: with one false line at the most, and with none; and the least number of
# the 24 of one radius with one at the most. A column of 0.15 m may as well be a box of two sides.
#                     open             ring
# direct_hough        101, 93; 18       98, 95; 17
# optimal_partition    99, 91; 18       99, 95; 17
# ransac              101, 97; 17       99, 96; 15
# raster_hough         96, 89; 17       93, 88; 13
# region_growing       92, 77; 17       85, 79; 14
# split_and_merge     102, 94; 17      102, 92; 16
# Columns of less than 1.8 rad are left as walls: in real logs they were boxes.
# Before columns were looked for, direct_hough had 15, 13 in open scans and 49, 47 in rings.
@every_wall_extractor
@pytest.mark.parametrize(("ring", "least"), [(False, 90), (True, 84)])
def test_a_half_column_in_a_wall_is_at_most_one_line_in_most_scans(name, ring, least):
    extractor = lf.get_extractor(name)
    none, few = [], []
    for radius in RADII:
        scans = [half_column(radius, seed, ring) for seed in range(SEEDS)]
        false = np.array([false_lines(extractor(scan), on) for scan, on in scans])
        none.append((false == 0).sum())
        few.append((false <= 1).sum())
    assert sum(few) >= least
    assert min(few) > SEEDS / 2
    assert sum(none) >= 72
