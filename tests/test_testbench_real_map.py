"""The truth of real scans that a map gives, held against worlds of which the truth is known."""

import math
from dataclasses import replace

import numpy as np
import pytest

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.evaluation import match_corners, oracle, truth_of
from laserfeatures.evaluation.true_lines import cross, lines_through
from laserfeatures.evaluation.truth import in_sensor_frame
from laserfeatures.simulation import Observation, Scanner, World
from laserfeatures.testbench.real.alignment import Locator
from laserfeatures.testbench.real.cloud import gather
from laserfeatures.testbench.real.plan import _is_copy, plan_of
from laserfeatures.testbench.real.survey import survey
from laserfeatures.testbench.real.view import judged
from laserfeatures.testbench.real.walls import grow

SCANNER = Scanner(beams=361, range_max=20.0, range_sigma=0.01)
OUTLINE = [
    (0, 0), (9, 0), (9, 4), (8, 4), (8, 5), (9, 5), (9, 9), (6, 9), (5, 8), (2, 8), (2, 6), (0, 6),
]  # fmt: skip
CUPBOARD = [(4.0, 3.0), (5.5, 3.0), (5.5, 4.0), (4.0, 4.0)]
WORLD = World.outline(OUTLINE, CUPBOARD)
ERRORS = (0.02, 0.02, math.radians(0.2))  # [m, m, rad], of the poses that a map is drawn from


def drive(count=60, outliers=0.0, world=WORLD):
    """Return observations along a loop, and their scans with poses as a SLAM program errs."""
    rng = np.random.default_rng(5)
    observations, scans = [], []
    for t in np.linspace(0, 2 * math.pi, count, endpoint=False):
        pose = Pose2D(4.7 + 3 * math.cos(t), 3.8 + 2.2 * math.sin(t), t + math.pi / 2)
        seen = SCANNER.observe(world, pose, rng)
        false = rng.random(len(seen.scan)) < outliers
        ranges = np.where(false, rng.uniform(0.3, 15.0, false.size), seen.scan.ranges)
        x, y, theta = rng.normal(0.0, ERRORS)
        given = Pose2D(pose.x + x, pose.y + y, pose.theta + theta)
        scan = replace(seen.scan, ranges=ranges, pose=given)
        observations.append(
            Observation(
                scan=scan, world=world, pose=pose, surface=np.where(false, -1, seen.surface)
            )
        )
        scans.append(scan)
    return observations, scans


def possible(observation):
    """Return the crossings of all walls of the world, seen or not, in the sensor's frame."""
    return cross(*lines_through(in_sensor_frame(observation.world.sides, observation.pose)))[0]


def nearest(points, others):
    return np.hypot(*(points[:, None] - others[None]).transpose(2, 0, 1)).min(
        axis=1, initial=np.inf
    )


@pytest.fixture(scope="module", params=[0.0, 0.1], ids=["clean", "outliers"])
def driven(request):
    observations, scans = drive(outliers=request.param)
    return observations, scans, survey(scans)


def test_the_map_has_the_true_corners_and_no_others(driven):
    observations, scans, drawn = driven
    assert len(drawn.views) == len(scans)
    found = known = 0
    gaps = []
    for observation, view in zip(observations, drawn.views, strict=True):
        real = view.truth.corners[view.truth.real]
        assert (nearest(real, possible(observation)) < 0.03).all()
        gaps.append(nearest(view.truth.corners, possible(observation)))
        truth = truth_of(observation)
        wanted = truth.corners[truth.real]
        known += len(wanted)
        found += int((nearest(wanted, real) < 0.03).sum())
    assert known > 3 * len(scans)
    assert found > 0.95 * known
    assert np.median(np.concatenate(gaps)) < 0.01
    assert np.concatenate(gaps).max() < 0.12


def test_beams_are_given_to_their_lines(driven):
    observations, _, drawn = driven
    right = told = seen = corners = 0
    for observation, view in zip(observations, drawn.views, strict=True):
        truth = truth_of(observation)
        best = oracle(view.scan, view.truth).corners.positions
        seen += len(match_corners(best, view.truth.corners)[0])
        corners += len(view.truth.corners)
        both = (view.truth.line >= 0) & (truth.line >= 0)
        mine, true = view.truth.line[both], truth.line[both]
        turn = abs(view.truth.theta[mine] - truth.theta[true])
        right += int((np.minimum(turn, math.pi - turn) < math.radians(2)).sum())
        told += both.sum()
        assert (view.truth.line >= 0).sum() > 0.8 * (truth.line >= 0).sum()
    assert right > 0.97 * told
    assert seen > 0.9 * corners


def test_a_scan_goes_back_to_where_it_was_taken(driven):
    observations, scans, drawn = driven
    gaps = [
        math.dist((fit.pose.x, fit.pose.y), (seen.pose.x, seen.pose.y))
        for fit, seen in zip(drawn.fits, observations, strict=True)
    ]
    given = [
        math.dist((scan.pose.x, scan.pose.y), (seen.pose.x, seen.pose.y))
        for scan, seen in zip(scans, observations, strict=True)
    ]
    assert np.median(gaps) < 0.5 * np.median(given)


def test_all_is_the_same_the_second_time():
    _, scans = drive(20)
    one, two = survey(scans), survey(scans)
    assert np.array_equal(one.plan.ends, two.plan.ends)
    assert one.fits == two.fits


def test_an_arc_is_no_wall():
    arc = [(4.7 + 4 * math.cos(t), 3.8 + 4 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 90)]
    world = World.outline(arc[:-1])
    _, scans = drive(world=world)
    plan = plan_of(scans, [scan.pose for scan in scans])
    lengths = np.hypot(*(plan.ends[:, 1] - plan.ends[:, 0]).T)
    assert lengths.max(initial=0) < 1.0
    assert lengths.sum() < 0.25 * 2 * math.pi * 4


def test_who_is_there_in_one_scan_only_is_no_wall():
    _, scans = drive(20)
    points = np.stack([np.linspace(2.0, 3.0, 200), np.full(200, 2.0)], axis=1)
    x, y = (points - (1.0, 0.5)).T
    order = np.argsort(np.arctan2(y, x))
    alone = LaserScan(angles=np.arctan2(y, x)[order], ranges=np.hypot(x, y)[order])
    poses = [Pose2D(1.0, 0.5, 0.0), *(scan.pose for scan in scans)]
    plan = plan_of([alone, *scans], poses)
    middles = plan.ends.mean(axis=1)
    assert not (nearest(middles, points) < 0.2).any()
    cloud = gather([alone] * 5, [poses[0]] * 5)
    assert len(grow(cloud)) == 1  # five scans of it are one


def test_a_scan_of_another_place_is_left_out():
    _, scans = drive(20)
    locator = Locator(plan_of(scans, [scan.pose for scan in scans]))
    pose = scans[0].pose
    assert locator.locate(scans[0], pose) is not None
    assert locator.locate(scans[0], Pose2D(pose.x + 0.6, pose.y + 0.6, pose.theta + 0.2)) is None
    assert locator.locate(LaserScan(angles=[0.0], ranges=[1.0]), pose) is None


def test_no_walls_no_truth():
    empty = LaserScan(angles=[0.0, 0.1], ranges=[np.inf, np.inf], pose=Pose2D(0.0, 0.0, 0.0))
    drawn = survey([empty] * 3)
    assert drawn.views == []
    assert drawn.plan.ends.shape == (0, 2, 2)


def test_a_scan_without_a_pose_is_an_error():
    with pytest.raises(ValueError, match="every scan of a survey needs its pose"):
        survey([drive(1)[1][0], LaserScan(angles=[0.0], ranges=[1.0])])


def test_only_what_the_map_knows_is_judged():
    observations, scans = drive(30)
    drawn = survey(scans)
    view = drawn.views[3]
    features = oracle(scans[3], truth_of(observations[3]))
    every = judged(features, replace(view, known=view.scan.valid, unsure=np.empty((0, 2), int)))
    assert np.array_equal(every.corners.positions, features.corners.positions)
    nothing = judged(features, replace(view, known=np.zeros(len(view.scan), bool)))
    assert len(nothing.corners) == 0
    pair = view.truth.pairs[:1]
    less = judged(features, replace(view, known=view.scan.valid, unsure=pair)).corners.positions
    assert len(less) == len(features.corners) - 1
    gone = nearest(features.corners.positions, less) > 0
    assert nearest(features.corners.positions[gone], view.truth.corners[:1]) < 0.1


def test_walls_reach_into_their_corners(driven):
    ends = driven[2].plan.ends
    long = ends[np.hypot(*(ends[:, 1] - ends[:, 0]).T) > 1.5].reshape(-1, 2)
    assert len(long) >= 14
    assert np.median(nearest(long, np.array(OUTLINE + CUPBOARD, dtype=float))) < 0.09


def test_a_wall_that_is_mapped_twice_is_one():
    wall = np.array([[(0.0, 0.0), (4.0, 0.0)]])
    assert _is_copy(np.array([(1.0, 0.05), (2.0, 0.06)]), wall)
    assert _is_copy(np.array([(5.0, 0.05), (2.0, 0.06)]), wall)
    assert not _is_copy(np.array([(1.0, 0.05), (2.0, 0.16)]), wall)
    assert not _is_copy(np.array([(3.8, 0.05), (5.0, 0.05)]), wall)
    assert not _is_copy(np.array([(1.0, 0.05), (2.0, 0.06)]), np.empty((0, 2, 2)))
