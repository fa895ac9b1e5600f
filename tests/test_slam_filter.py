"""The whole filter in small simulated rooms: right, consistent, and honest when it is not."""

import math
import tracemalloc
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from scenes import needs_compiler

from laserfeatures import Pose2D, get_extractor
from laserfeatures.data import Features, LaserScan, LineSegments, PointFeatures
from laserfeatures.poses import compose, relative
from laserfeatures.simulation import Scanner, World
from laserfeatures.slam import EkfSlam, Motion

SCANNER = Scanner(beams=271, field_of_view=math.radians(270), range_max=12.0, range_sigma=0.01)
MOTION = Motion(way=0.04, side=0.02, turn_by_way=0.02, turn=0.04)
ROOM = World(
    walls=World.outline([(0, 0), (8, 0), (8, 6), (5, 6), (5, 5), (0, 5)]).walls,
    boxes=[(6.5, 4.5, 1.0, 0.6, 0.3), (1.0, 4.3, 0.8, 0.5, 0.0)],
)
HALL = World.outline(  # a hall elsewhere, with a stair of corners that the room has not
    [(100, 0), (111, 2), (110, 6), (108.5, 5), (107.6, 7), (104, 6.2), (103, 8), (99.5, 4)]
)
SCANS = 100
EXTRACTOR = get_extractor("direct_hough")


@dataclass(frozen=True)
class Drive:
    """The true poses of a drive, its odometry, and what was seen."""

    truth: list[Pose2D]
    odometry: list[Pose2D]
    features: list[Features]

    def run(self, slam):
        """Return the filter's steps."""
        return [
            slam.step(odometry, features, self.truth[0])
            for odometry, features in zip(self.odometry, self.features, strict=True)
        ]


def round_and_round(scans):
    """Return poses on an ellipse in the room, two rounds in all."""
    angle = 4 * math.pi * np.arange(scans) / scans
    x, y = 4.0 + 2.2 * np.cos(angle), 2.6 + 1.2 * np.sin(angle)
    heading = np.arctan2(1.2 * np.cos(angle), -2.2 * np.sin(angle))
    return [Pose2D(*map(float, row)) for row in np.stack([x, y, heading], axis=1)]


def odometry_of(truth, rng):
    """Return the poses by odometry, each of its steps wrong as `MOTION` has it."""
    poses = [Pose2D(0.0, 0.0, 0.0)]
    for before, after in pairwise(truth):
        step = relative(before, after)
        error = rng.multivariate_normal(np.zeros(3), MOTION.covariance(step))
        wrong = Pose2D(step.x + error[0], step.y + error[1], step.theta + error[2])
        poses.append(compose(poses[-1], wrong))
    return poses


def drive(truth, worlds, seed, odometry=None):
    rng = np.random.default_rng(seed)
    odometry = odometry_of(truth, rng) if odometry is None else odometry
    scans = [SCANNER.scan(world, pose, rng) for world, pose in zip(worlds, truth, strict=True)]
    return Drive(truth, odometry, [EXTRACTOR(scan) for scan in scans])


def off(step, truth):
    """Return the error of a step's pose, (3,)."""
    pose = step.pose
    turn = math.remainder(pose.theta - truth.theta, math.tau)
    return np.array([pose.x - truth.x, pose.y - truth.y, turn])


def nees(steps, truth):
    """Return the normalised estimation error squared of each step; 3 is what to expect."""
    errors = [off(step, pose) for step, pose in zip(steps, truth, strict=True)][1:]
    return np.array(
        [e @ np.linalg.solve(s.covariance, e) for e, s in zip(errors, steps[1:], strict=True)]
    )


def nothing_seen(beams=5):
    """Return the features of a scan without a return."""
    scan = LaserScan(angles=np.arange(beams) * 0.1, ranges=np.full(beams, np.inf))
    no, none = np.empty(0), np.empty((0, 2))
    corners = PointFeatures(
        positions=none, covariance=np.empty((0, 2, 2)), lines=none, angles=no, real=no.astype(bool)
    )
    return Features(scan=scan, segments=LineSegments.none(beams), corners=corners)


@pytest.fixture(scope="module")
def rounds():
    truth = round_and_round(SCANS)
    return [drive(truth, [ROOM] * SCANS, seed) for seed in range(2)]


@needs_compiler
@pytest.mark.parametrize("association", ["joint", "nearest"])
@pytest.mark.parametrize(("corners", "walls"), [(True, True), (True, False), (False, True)])
def test_two_rounds_in_a_room_end_where_they_should(rounds, association, corners, walls):
    for each in rounds:
        slam = EkfSlam(motion=MOTION, association=association, corners=corners, walls=walls)
        steps = each.run(slam)
        errors = np.array([off(s, t) for s, t in zip(steps, each.truth, strict=True)])
        by_odometry = compose(each.truth[0], each.odometry[-1])
        astray = math.dist((by_odometry.x, by_odometry.y), (each.truth[-1].x, each.truth[-1].y))
        assert astray > 0.2
        assert np.hypot(*errors[:, :2].T).max() < 0.12
        assert abs(errors[:, 2]).max() < math.radians(2)
        assert np.median(nees(steps, each.truth)) < 7.8  # 0.95 of chi-square
        assert all(step.notice is None for step in steps)
        assert sum(step.matched for step in steps) > SCANS
        kinds = {landmark.kind for landmark in slam.map}
        assert kinds == {name for name, on in (("corner", corners), ("wall", walls)) if on}


@needs_compiler
def test_the_filter_is_deterministic(rounds):
    def run():
        slam = EkfSlam(motion=MOTION)
        steps = [slam.step(o, f) for o, f in zip(some.odometry[:40], some.features, strict=False)]
        return [(step.pose, step.nis, step.matched) for step in steps]

    some = rounds[0]
    assert run() == run()


@needs_compiler
def test_the_first_scan_makes_landmarks_and_new_ones_take_their_sightings(rounds):
    each = rounds[0]
    first = EkfSlam(motion=MOTION).step(each.odometry[0], each.features[0], each.truth[0])
    assert first.landmarks > 5
    assert first.pose == each.truth[0]
    np.testing.assert_array_equal(first.covariance, 0.0)
    # A filter that has seen nothing at first waits; that its features are many does not matter.
    late = EkfSlam(motion=MOTION, sightings=4)
    counts = [late.step(each.odometry[0], nothing_seen()).landmarks]
    counts += [late.step(each.odometry[0], each.features[0]).landmarks for _ in range(4)]
    assert counts[:4] == [0] * 4
    assert counts[4] > 5


def carried(here, speed, kinds):
    """Return the notices in the room, and after the robot was carried to the hall."""
    after = 15
    there = [Pose2D(105.0 + speed * i, 3.0, 0.3) for i in range(after)]
    odometry = odometry_of(here, np.random.default_rng(1))
    odometry += [odometry[-1]] * after  # it says nothing
    each = drive(here + there, [ROOM] * len(here) + [HALL] * after, 0, odometry)
    told = [step.notice or "" for step in each.run(EkfSlam(motion=MOTION, **kinds))]
    return told[: len(here)], told[len(here) :]


@needs_compiler
@pytest.mark.parametrize("speed", [0.0, 0.05], ids=["standing", "driving"])
@pytest.mark.parametrize(
    "kinds", [{}, {"walls": False}, {"corners": False}], ids=["both", "corners", "walls"]
)
def test_a_robot_that_is_carried_to_another_room_says_so(speed, kinds):
    before, after = carried(round_and_round(SCANS)[:40], speed, kinds)
    assert set(before) == {""}
    assert any("lost" in notice for notice in after[:8])


@needs_compiler
@pytest.mark.parametrize("speed", [0.0, 0.05], ids=["standing", "driving"])
def test_a_chance_match_does_not_hide_that_it_was_carried(speed):
    before, after = carried(round_and_round(120)[:15], speed, {})
    assert set(before) == {""}
    assert any(after)


@needs_compiler
def test_a_robot_that_stands_still_neither_forgets_nor_grows_over_sure():
    scans = 500
    truth = [round_and_round(SCANS)[5]] * scans
    each = drive(truth, [ROOM] * scans, 3, [Pose2D(0.0, 0.0, 0.0)] * scans)
    slam = EkfSlam(motion=MOTION)
    steps = each.run(slam)
    assert steps[-1].landmarks <= steps[20].landmarks + 3
    assert steps[-1].landmarks < 50
    assert all(step.notice is None for step in steps)
    assert np.abs(off(steps[-1], truth[0])[:2]).max() < 0.03
    values = np.linalg.eigvalsh(slam.state.covariance)
    assert values[0] > -1e-12 * values[-1]
    np.testing.assert_array_equal(slam.state.covariance, slam.state.covariance.T)
    assert nees(steps, truth)[-1] < 25


def test_scans_without_a_return_leave_odometry_alone():
    slam = EkfSlam(motion=MOTION)
    for i in range(20):
        step = slam.step(Pose2D(0.1 * i, 0.0, 0.0), nothing_seen(), Pose2D(1.0, 2.0, 0.0))
        assert (step.landmarks, step.matched, step.nis, step.notice) == (0, 0, 0.0, None)
    assert (step.pose.x, step.pose.y) == pytest.approx((1.0 + 1.9, 2.0))
    assert step.covariance[0, 0] == pytest.approx(MOTION.way**2 * 1.9, rel=0.01)
    assert slam.map == ()


def test_a_step_in_a_room_without_the_compilers_help():
    """Small enough for the run without compiled kernels."""
    truth = [Pose2D(2.0 + 0.1 * i, 2.0, 0.0) for i in range(3)]
    scanner = Scanner(beams=91, field_of_view=math.pi, range_max=12.0, range_sigma=0.005)
    rng = np.random.default_rng(1)
    slam = EkfSlam(motion=MOTION)
    for pose in truth:
        step = slam.step(
            Pose2D(pose.x * 1.03, 2.0, 0.0), EXTRACTOR(scanner.scan(ROOM, pose, rng)), truth[0]
        )
    assert step.matched > 4
    assert np.hypot(*off(step, truth[-1])[:2]) < 0.02


def test_the_pose_and_the_covariance_of_a_step_are_its_own():
    slam = EkfSlam(motion=MOTION)
    steps = [slam.step(Pose2D(float(i), 0.0, 0.0), nothing_seen()) for i in range(3)]
    assert [step.pose.x for step in steps] == pytest.approx([0.0, 1.0, 2.0])
    variances = [step.covariance[0, 0] for step in steps]
    assert 0.0 == variances[0] < variances[1] < variances[2]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"corners": False, "walls": False}, "corners or walls must be landmarks, got neither"),
        ({"association": "best"}, "association must be joint or nearest, got 'best'"),
        ({"roughness": -0.1}, "roughness must be >= 0 m and finite, got -0.1"),
        ({"roughness": math.inf}, "roughness must be >= 0 m and finite, got inf"),
        ({"probability": 1.0}, "probability must be in .0, 1., got 1.0"),
        ({"probability": math.nan}, "probability must be in .0, 1., got nan"),
        ({"sightings": 0}, "sightings must be >= 1, got 0"),
        ({"patience": 0}, "patience must be >= 1, got 0"),
    ],
)
def test_parameters_that_make_no_sense_are_refused(parameters, message):
    with pytest.raises(ValueError, match=message):
        EkfSlam(**parameters)


@needs_compiler
def test_a_full_map_takes_nothing_new_and_says_so_once(rounds):
    slam = EkfSlam(motion=MOTION, most=5)
    steps = rounds[0].run(slam)
    assert {step.landmarks for step in steps} == {5}
    told = [step.notice for step in steps if step.notice and "full" in step.notice]
    assert told == ["the map is full: it has 5 landmarks, and nothing new is added"]


@pytest.mark.parametrize("pose", [(math.nan, 0, 0), (1e308, 0, 0), (0, 0, math.inf), (0, 2e7, 0)])
def test_odometry_that_cannot_be_is_refused_and_changes_nothing(pose):
    slam = EkfSlam(motion=MOTION)
    features = EXTRACTOR(SCANNER.scan(ROOM, Pose2D(4.0, 2.6, 0.0), np.random.default_rng(1)))
    slam.step(Pose2D(0.0, 0.0, 0.0), features)
    before = slam.map
    with pytest.raises(ValueError, match="odometry must be finite and within 1e"):
        slam.step(Pose2D(*map(float, pose)), features)
    step = slam.step(Pose2D(0.01, 0.0, 0.0), features)
    assert np.isfinite(step.covariance).all()
    assert len(slam.map) == len(before)
    with pytest.raises(ValueError, match="start must be finite"):
        EkfSlam().step(Pose2D(0.0, 0.0, 0.0), features, Pose2D(*map(float, pose)))


def test_odometry_that_jumps_is_told_and_needs_no_memory():
    slam = EkfSlam(motion=MOTION)
    features = EXTRACTOR(SCANNER.scan(ROOM, Pose2D(4.0, 2.6, 0.0), np.random.default_rng(1)))
    slam.step(Pose2D(0.0, 0.0, 0.0), features)
    tracemalloc.start()
    step = slam.step(Pose2D(10_000.0, 0.0, 1.0), features)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert most < 50e6
    assert step.notice == "odometry jumps by 10000 m since the scan before"
    assert math.hypot(step.pose.x, step.pose.y) == pytest.approx(10_000, rel=0.01)
    assert np.isfinite(step.covariance).all()
