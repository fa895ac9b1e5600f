import math
import pickle
from itertools import pairwise

import numpy as np
import pytest
from laserfeatures_plugins.raster import KanadeTomasi
from recordings import DATA, RECORDINGS, needs_recordings
from scenes import chain, look, needs_compiler, poles, random_room, scan_of, wall
from scipy.optimize import linear_sum_assignment

from laserfeatures import Pose2D, get_extractor, open_source

CHI2_95 = 5.991
GATE = 0.2  # [m]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"resolution": -1.0}, r"resolution must be in \[0.0001, 10\] m, got -1.0"),
        ({"resolution": 0.004}, "40 m x 40 m at a resolution of 0.004 m has 100000000 pixels"),
        ({"scales": 1}, "scales must be in 2 .. 8, got 1"),
        ({"blur": 0.0}, r"blur must be in \[0.5, 20\] pixels, got 0.0"),
        ({"blur": 30.0}, r"blur must be 0 or in \[0.5, 20\] pixels, got 30.0"),
        ({"blur_growth": 2.0}, r"blur_growth must be in \[0, 1\] m/m, got 2.0"),
        ({"quality": 0.0}, r"quality must be in \(0, 1\), got 0.0"),
        ({"min_turn": 0.0}, r"min_turn must be in \(0, pi/2\) rad, got 0.0"),
        ({"range_sigma": 2.0}, r"range_sigma must be in \(0, 1\] m, got 2.0"),
        ({"max_missed": -1}, "max_missed must be >= 0, got -1"),
        ({"max_pole_radius": -0.1}, "max_pole_radius must be >= 0, got -0.1"),
    ],
)
def test_parameters_are_checked(parameters, message):
    with pytest.raises(ValueError, match=message):
        KanadeTomasi(**parameters)


def test_a_large_image_is_refused_at_the_scan_where_only_that_can_tell():
    corners = [(500, -500), (500, 500), (-500, 500), (-500, -500), (500, -500)]
    scan = scan_of(*chain(*corners), beams=1441, view=2 * math.pi, range_max=1000.0)
    with pytest.raises(ValueError, match="1001 m x 1001 m at a resolution of"):
        KanadeTomasi(max_range=math.inf)(scan)


def test_an_extractor_can_be_sent_to_another_process_after_use():
    extractor = get_extractor("kanade_tomasi")
    scan = scan_of(*chain((2, -1.5), (2, 1.2), (-0.5, 1.2)), sigma=0.003)
    before = extractor(scan).corners.positions
    sent = pickle.loads(pickle.dumps(extractor))  # noqa: S301 - our own
    np.testing.assert_array_equal(sent(scan).corners.positions, before)


def corner_of(degrees, turn, at=(2.0, 0.3), length=1.2):
    """Return two walls that meet at an angle, the first in direction `turn` from the corner."""
    ends = [
        np.add(at, length * np.array([math.cos(a), math.sin(a)]))
        for a in (turn, turn + math.radians(degrees))
    ]
    return chain(tuple(ends[0]), at, tuple(ends[1]))


@pytest.mark.parametrize("degrees", [50, 70, 90, 110, 130, 145])
def test_a_corner_has_the_place_and_the_angle_of_its_walls(degrees):
    found = 0
    for step in range(16):
        walls = corner_of(degrees, step * math.pi / 8)
        scan, hit = look(walls, sigma=0.003, seed=step, beams=721)
        arms = [scan.points[hit[scan.beams] == k] for k in (0, 1)]
        off = [np.hypot(*(arm - (2.0, 0.3)).T).min(initial=9.0) for arm in arms]
        if min(map(len, arms)) < 25 or max(off) > 0.05:
            continue  # one wall hides the other, or is met at a grazing angle
        corners = KanadeTomasi()(scan)
        assert len(corners) == 1
        assert math.dist(corners.positions[0], (2.0, 0.3)) < 0.04
        expected = math.radians(min(degrees, 180 - degrees))
        assert corners.angles[0] == pytest.approx(expected, abs=math.radians(10))
        found += 1
    assert found >= 3


SINGLE = [
    [wall(0.3, 2.0, -1.0, 1.0)],
    [wall(1.2, 1.5, -2.0, 1.0)],
    [wall(math.pi / 2, 0.7, -4, 1), wall(math.pi / 2, -0.6, -4, 1)],
    [[(2, -1.6), (2, -0.5)], [(2, 0.5), (2, 1.6)], [(3.5, -2), (3.5, 2)]],
    [[(2, -0.5), (2, 0.4)], [(2.6, -2), (2.6, 2)]],
]


@pytest.mark.parametrize("walls", SINGLE, ids=["wall", "slanted", "corridor", "door", "box"])
def test_the_ends_of_walls_are_no_corners_unless_wanted(walls):
    for seed in range(5):
        scan = scan_of(*walls, sigma=0.005, seed=seed, beams=541)
        assert len(KanadeTomasi()(scan)) == 0
        ends = KanadeTomasi(keep_ends=True)(scan)
        assert len(ends) >= 2
        seen = scan.points[[0, -1]]
        off = np.hypot(*(ends.positions[:, None] - seen).transpose(2, 0, 1))
        assert (off.min(axis=0) < 0.1).all()
        assert ((ends.angles > 0) & (ends.angles <= math.pi / 2)).all()
        assert (np.linalg.eigvalsh(ends.covariance) > 0).all()


def test_a_junction_of_three_walls_is_one_right_angled_corner():
    pose = Pose2D(-1.0, -1.0, math.atan2(1, 1))
    walls = [*chain((0.9, 0), (0, 0), (-0.9, 0)), [(0, -0.25), (0, 0)]]
    scan, _ = look(walls, sigma=0.002, beams=1441, pose=pose)
    corners = KanadeTomasi()(scan)
    # The third wall hides some of the first: a corner where it meets the second, in front.
    at = np.hypot(*(corners.positions - (math.sqrt(2), 0.0)).T)
    assert (at < 0.05).sum() == 1
    assert corners.angles[at.argmin()] == pytest.approx(math.pi / 2, abs=0.15)


def test_poles_are_corners_only_if_drawn():
    scan = poles((1.5, 0.8), (1.8, -0.7), radius=0.15, beams=721)
    assert len(KanadeTomasi()(scan)) == 0
    assert len(KanadeTomasi(max_pole_radius=0.0, keep_ends=True)(scan)) > 0


def test_what_is_far_has_no_corners():
    walls = chain((7, -1.5), (7, 1.2), (5, 1.2))
    scan = scan_of(*walls, sigma=0.003, beams=721)
    assert len(KanadeTomasi()(scan)) == 1
    assert len(KanadeTomasi(max_range=6.0)(scan)) == 0


def test_bumps_of_the_finer_scale_are_no_corners_and_corners_of_any_scale_are_found_once():
    # A zigzag of 3 cm in a wall: it turns at the scale of 2 cm, but goes straight on at 4 cm.
    bump = [(2, 0.0), (1.97, 0.03), (2.0, 0.06)]
    scan = scan_of(*chain((2, -1.5), *bump, (2, 1.2), (-0.5, 1.2)), beams=2001)
    corners = KanadeTomasi(min_turn=math.radians(15))(scan)
    np.testing.assert_allclose(corners.positions, [[2.0, 1.2]], atol=0.02)
    coarser = KanadeTomasi(scales=4)(scan)
    np.testing.assert_allclose(coarser.positions, [[2.0, 1.2]], atol=0.02)


def test_a_blur_that_grows_finds_the_same_corners():
    walls = chain((2, -1.5), (2, 1.2), (-0.5, 1.2))
    scan = scan_of(*walls, sigma=0.005, beams=541)
    corners = KanadeTomasi(blur_growth=0.003)(scan)
    np.testing.assert_allclose(corners.positions, [[2.0, 1.2]], atol=0.04)


def true_corners(world, pose, hit, least):
    """Return the ends that two walls share where the scan goes over from one to the other."""
    c, s = math.cos(pose.theta), math.sin(pose.theta)
    ends = (world.walls - (pose.x, pose.y)) @ np.array([[c, -s], [s, c]])
    beams = np.bincount(hit[hit >= 0], minlength=len(ends))
    corners = set()
    for a, b in {(a, b) for a, b in pairwise(hit) if a != b}:
        if min(a, b) >= 0 and min(beams[a], beams[b]) >= least:
            corners |= {tuple(p.round(9)) for p in ends[a] for q in ends[b] if np.allclose(p, q)}
    return np.array(sorted(corners)).reshape(-1, 2)


def paired(positions, truth):
    """Return the indices of pairs nearer than the gate."""
    if not (len(positions) and len(truth)):
        return []
    off = np.hypot(*(positions[:, None] - truth).transpose(2, 0, 1))
    pairs = zip(*linear_sum_assignment(np.minimum(off, 10 * GATE)), strict=True)
    return [(i, k) for i, k in pairs if off[i, k] < GATE]


@pytest.fixture(scope="module", params=[(361, 0.005), (1081, 0.01)], ids=str)
def rooms(request):
    """Return the corners found in 80 rooms, those in sight and those that any beam shows."""
    beams, sigma = request.param
    rng = np.random.default_rng(7)
    detector = KanadeTomasi(range_sigma=sigma)
    found = []
    for seed in range(80):
        world, pose = random_room(rng)
        view = {"beams": beams, "view": math.radians(270)}
        scan, hit = look(world, sigma=sigma, seed=seed, pose=pose, **view)
        in_sight = true_corners(world, pose, hit, 6)
        found.append((detector(scan), in_sight, true_corners(world, pose, hit, 1)))
    return found


@needs_compiler
def test_corners_are_found_and_what_is_found_is_a_corner(rooms):
    true = hits = answers = right = 0
    for corners, in_sight, any_beam in rooms:
        true += len(in_sight)
        hits += len(paired(corners.positions, in_sight))
        answers += len(corners)
        right += len(paired(corners.positions, any_beam))
    assert true > 200
    assert hits / true > 0.95
    assert right / answers > 0.95


@needs_compiler
def test_corners_are_where_they_are_and_their_ellipses_say_how_well_that_is_known(rooms):
    errors, inside = [], []
    for corners, in_sight, _ in rooms:
        for i, k in paired(corners.positions, in_sight):
            error = corners.positions[i] - in_sight[k]
            errors.append(math.hypot(*error))
            inside.append(error @ np.linalg.solve(corners.covariance[i], error) < CHI2_95)
    assert np.median(errors) < 0.012
    assert np.percentile(errors, 90) < 0.03
    assert 0.88 < np.mean(inside) < 0.99


@needs_recordings
@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda r: r.path)
def test_recordings_are_no_trouble(recording):
    extractor = get_extractor("kanade_tomasi")
    with open_source(DATA / recording.path) as scans:
        for scan, _ in zip(scans, range(3), strict=False):
            corners = extractor(scan).corners
            assert np.isfinite(corners.positions).all()
            assert (np.linalg.eigvalsh(corners.covariance) > 0).all()
