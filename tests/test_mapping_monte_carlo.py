"""Simulated drives with SLAM: their scores, and many of them together."""

import math
import pickle
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from robots import PLAN_FILE
from scenes import needs_compiler

import laserfeatures as lf
from laserfeatures.mapping.drive_score import nees, score_drive
from laserfeatures.mapping.drive_summary import figures, summary
from laserfeatures.mapping.landmark_score import LandmarkScore
from laserfeatures.mapping.monte_carlo import Trial
from laserfeatures.mapping.robot_motion import CORRELATED, CORRELATED_TURN, motion_of
from laserfeatures.mapping.simulated_drive import SimulatedDrive
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.simulation.robot import Robot
from laserfeatures.simulation.robot.body import PATCH
from laserfeatures.slam import EkfSlam
from laserfeatures.sources.simulated import readings_of

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    path = tmp_path_factory.mktemp("plan") / "room.toml"
    path.write_text(PLAN_FILE)
    return str(path)


@pytest.fixture(scope="module")
def drive(plan):
    return SimulatedDrive.of(list(readings_of(plan, seed=3)))


@pytest.fixture(scope="module")
def run(drive):
    return drive.run(lf.get_extractor("direct_hough"), EkfSlam(motion=motion_of(Robot())))


def test_a_drive_starts_at_the_truth_and_goes_by_odometry(drive, run):
    first = drive.readings[0].observation.pose
    assert run.estimate.poses[0].tolist() == [first.x, first.y, first.theta]
    odometry = [reading.scan.pose for reading in drive.readings]
    assert run.odometry.poses.tolist() == [[p.x, p.y, p.theta] for p in odometry]
    assert len(run.estimate) == len(drive.truth) == len(drive.readings) > 50
    assert drive.way[-1] == pytest.approx(7.5, abs=0.5)


def test_the_errors_are_those_that_a_loop_finds(drive, run):
    found = score_drive(run, drive)
    truth = [reading.observation.pose for reading in drive.readings]
    off = [
        math.dist((x, y), (p.x, p.y))
        for (x, y, _), p in zip(run.estimate.poses.tolist(), truth, strict=True)
    ]
    assert found.final_error == pytest.approx(off[-1])
    assert found.ate_rmse == pytest.approx(math.sqrt(sum(e * e for e in off) / len(off)))
    last = run.odometry.poses[-1].tolist()
    assert found.odometry_final_error == pytest.approx(
        math.dist(last[:2], (truth[-1].x, truth[-1].y))
    )
    assert found.odometry_ate_rmse > 0
    assert found.length == pytest.approx(drive.way[-1])
    assert found.nis_per_degree == pytest.approx(run.nis.sum() / 2 / run.matched.sum())
    assert found.map.landmarks == len(run.map) > 3
    assert found.map.median_error < 0.1
    assert found.map.spurious == 0


def test_nees_turns_by_whole_turns_and_leaves_out_the_start(drive, run):
    expected = []
    for i in range(1, len(drive.truth)):
        error = run.estimate.poses[i] - drive.truth.poses[i]
        error[2] = math.remainder(error[2], math.tau)
        expected.append(error @ np.linalg.inv(run.covariances[i]) @ error)
    whole_turns = np.array([0, 0, 2 * math.tau])
    turned = Trajectory(stamps=drive.truth.stamps, poses=drive.truth.poses + whole_turns)
    assert nees(run, drive.truth) == pytest.approx(np.array(expected), rel=1e-6)
    assert nees(run, turned) == pytest.approx(np.array(expected), rel=1e-4)
    assert score_drive(run, drive).nees_mean == pytest.approx(np.mean(expected))
    for times in (0.1, 1, 10):
        sure = replace(run, covariances=run.covariances / times)
        inside = [(0.2158 <= times * value <= 9.3484) for value in expected]
        assert score_drive(sure, drive).nees_inside == pytest.approx(np.mean(inside))


def test_a_relative_error_does_not_see_where_a_path_lies_and_sees_its_scale(drive, run):
    x, y, theta = drive.truth.poses.T
    turned = np.stack([5 - y, x - 2, theta + math.pi / 2], axis=1)
    longer = drive.truth.poses * [1.02, 1.02, 1]

    def rpe(poses):
        estimate = Trajectory(stamps=drive.truth.stamps, poses=poses)
        return score_drive(replace(run, estimate=estimate), drive).rpe_rmse

    assert rpe(turned) == pytest.approx(0, abs=1e-9)
    assert rpe(longer) == pytest.approx(0.02, rel=0.1)


def test_a_trial_is_the_same_again_and_in_another_process_and_draws_one_seed(plan):
    names = ("direct_hough", "split_and_merge")
    trial = Trial(
        plan=plan,
        extractors={name: lf.get_extractor(name) for name in names},
        slam=partial(EkfSlam, corners=False, walls=True),
        drawn=2,
    )
    first, again = trial(2), pickle.loads(pickle.dumps(trial))(2)  # noqa: S301 - our own
    assert list(first.scores) == list(first.pictures) == list(names)
    for name in names:
        was, now = figures(first.scores[name]), figures(again.scores[name])
        assert was.pop("step_ms") > 0 < now.pop("step_ms")
        assert was == now
        for png in first.pictures[name].values():
            assert png.startswith(b"\x89PNG")
    assert not trial(3).pictures


def test_an_extractor_that_fails_is_named_with_the_scan(drive):
    calls = []

    def faulty(scan):
        calls.append(scan)
        if len(calls) == 3:
            raise ZeroDivisionError("oh")
        return lf.get_extractor("direct_hough")(scan)

    with pytest.raises(lf.PluginError, match=r"failed at scan 2: ZeroDivisionError: oh"):
        drive.run(faulty, EkfSlam())


def test_a_reading_without_odometry_is_refused(drive):
    blind = [replace(r, scan=replace(r.scan, pose=None)) for r in drive.readings[:2]]
    with pytest.raises(ValueError, match="reading 0 has no pose"):
        SimulatedDrive.of(blind).run(lf.get_extractor("direct_hough"), EkfSlam())


def test_a_summary_takes_medians_and_the_worst_and_shares_of_all(drive, run):
    one = score_drive(run, drive)
    parts = [
        (0.01, 2.0, 1.0, 101, 10, 1, 0),
        (0.04, 1.0, 0.5, 301, 30, 0, 3),
        (0.02, 4.0, 1.0, 101, 10, 0, 0),
    ]
    scores = [
        replace(
            one, final_error=final, odometry_final_error=odometry, nees_inside=inside, scans=scans,
            map=LandmarkScore(
                landmarks=landmarks, virtual=0, spurious=spurious, doubled=doubled, median_error=0.1
            ),
        )
        for final, odometry, inside, scans, landmarks, spurious, doubled in parts
    ]  # fmt: skip
    found = summary(scores)
    assert found["drives"] == 3
    assert (found["final_error"], found["worst_final_error"]) == (0.02, 0.04)
    assert found["ratio"] == pytest.approx(0.01)
    assert found["worst_ratio"] == pytest.approx(0.04)
    assert found["nees_inside"] == pytest.approx((100 + 150 + 100) / 500)
    assert found["spurious"] == pytest.approx(1 / 50)
    assert found["doubled"] == pytest.approx(3 / 50)
    with pytest.raises(ValueError, match="at least one drive"):
        summary([])


def test_a_summary_of_what_is_not_known_is_nan(drive, run):
    nothing = LandmarkScore(landmarks=0, virtual=0, spurious=0, doubled=0, median_error=math.nan)
    found = summary([replace(score_drive(run, drive), map=nothing, nis_per_degree=math.nan)])
    for name in ("spurious", "doubled", "landmark_error", "nis_per_degree"):
        assert math.isnan(found[name])


def wheels(rng, robot, left, right, patches):
    """Return what wheels truly roll, (drives,), where they are taken to roll so far [m] each."""
    drives = 20_000
    ways = []
    for way in (left, right):
        bumps = rng.normal(0, robot.unevenness, (drives, patches)).mean(axis=1)
        ways.append(way * (1 + rng.normal(0, robot.radius_error, drives) + bumps))
    return ways


def test_the_motion_noise_is_what_wheels_make_that_are_drawn_as_the_robots():
    robot, rng = Robot(), np.random.default_rng(0)
    motion = motion_of(robot)
    left, right = wheels(rng, robot, CORRELATED, CORRELATED, round(CORRELATED / PATCH))
    heading = np.std((right - left) / robot.track)
    assert motion.turn_by_way * math.sqrt(CORRELATED) == pytest.approx(heading, rel=0.02)
    rolled = CORRELATED_TURN * robot.track / 2
    left, right = wheels(rng, robot, -rolled, rolled, round(rolled / PATCH))
    track = robot.track * (1 + rng.normal(0, robot.track_error, left.size))
    turned = np.std((right - left) / track)
    assert motion.turn * math.sqrt(CORRELATED_TURN) == pytest.approx(turned, rel=0.02)


def test_a_better_robot_has_less_noise_and_a_perfect_one_none():
    worse, better = motion_of(Robot()), motion_of(Robot(unevenness=0.001))
    assert better.way < worse.way
    assert better.turn_by_way < worse.turn_by_way
    none = motion_of(Robot(radius_error=0, track_error=0, unevenness=0))
    assert (none.way, none.side, none.turn_by_way, none.turn) == (0, 0, 0, 0)
