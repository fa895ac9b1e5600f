import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from robots import PERFECT, room

from laserfeatures.data import Pose2D
from laserfeatures.poses import compose
from laserfeatures.simulation import Drive, Plan, Scanner, World
from laserfeatures.simulation.robot import DriveError, Robot, drive

HALL = World.outline([(0, 0), (30, 0), (30, 20), (0, 20)])
LOOP = [(2, 2), (28, 2), (28, 10), (2, 10), (2, 2)]


def errors(readings):
    """Return how far odometry is off [m], reading by reading."""
    return np.array(
        [math.dist((r.odometry.x, r.odometry.y), (r.truth.x, r.truth.y)) for r in readings]
    )


def off_path(readings, waypoints):
    """Return the largest distance [m] of a true position from the way-points' polyline."""
    points = np.array([(r.truth.x, r.truth.y) for r in readings])
    start, end = np.array(waypoints[:-1], float), np.array(waypoints[1:], float)
    along = end - start
    share = ((points[:, None] - start) * along).sum(axis=2) / (along**2).sum(axis=1)
    feet = start + np.clip(share, 0, 1)[..., None] * along
    return np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1).max()


def test_the_robot_passes_its_waypoints_on_straight_lines():
    plan = room(speed=0.6)
    readings = list(drive(plan))
    assert off_path(readings, plan.drive.waypoints) < 0.1
    last = readings[-1].truth
    assert math.dist((last.x, last.y), plan.drive.waypoints[-1]) < 0.2  # one scan before its end


def test_readings_come_at_the_scan_rate_from_a_start_at_rest():
    readings = list(drive(room(scan_rate=4.0)))
    stamps = [r.scan.stamp for r in readings]
    assert stamps[0] == 0
    np.testing.assert_allclose(stamps, np.arange(len(stamps)) / 4, atol=0.02)
    first = readings[0]
    assert first.ticks == (0, 0)
    assert first.odometry == first.truth
    assert math.dist((first.truth.x, first.truth.y), (1, 1)) < 0.01
    assert abs(first.truth.theta) < 0.01


def test_odometry_ends_metres_off_after_a_long_way_and_gets_worse_on_it():
    readings = list(drive(Plan(world=HALL, drive=Drive(waypoints=LOOP, speed=0.8, seed=2))))
    error = errors(readings)
    thirds = [part.max() for part in np.array_split(error, 3)]
    assert 0.01 < thirds[0] < thirds[1] < thirds[2]
    assert 0.5 < error.max() < 20


def test_odometry_of_perfect_wheels_on_a_straight_line_is_nearly_true():
    plan = Plan(world=HALL, drive=Drive(waypoints=[(2, 2), (22, 2)], speed=0.8))
    last = list(drive(plan, PERFECT))[-1]
    assert last.truth.x > 21
    assert errors([last]) < 0.02
    assert abs(last.odometry.theta - last.truth.theta) < 1e-3


def test_wheels_slip_where_the_floor_is_slick():
    """The wheels themselves are perfect: what odometry misses is their slip on turns."""
    turns = [(2, 2), (4, 2), (4, 4), (2, 4)] * 2
    plan = Plan(world=HALL, drive=Drive(waypoints=turns, speed=0.4))
    slick = replace(PERFECT, friction=(0.05, 0.1))
    wrong = {}
    for robot in (PERFECT, slick):
        last = list(drive(plan, robot))[-1]
        wrong[robot] = abs(math.remainder(last.odometry.theta - last.truth.theta, math.tau))
    assert wrong[slick] > 5 * wrong[PERFECT] > 0


def test_a_larger_wheel_takes_the_robot_farther_than_odometry_knows():
    """Odometry is short or long in proportion to the true radius of both wheels."""
    plan = Plan(world=HALL, drive=Drive(waypoints=[(2, 2), (22, 2)], speed=0.8))
    ratios = []
    for seed in range(6):
        rough = replace(PERFECT, radius_error=0.005)
        seeded = replace(plan, drive=replace(plan.drive, seed=seed))
        last = list(drive(seeded, rough))[-1]
        turned = sum(last.ticks) / 2 / rough.ticks_per_turn * math.tau * rough.wheel_radius
        ratios.append((last.truth.x - 2) / turned)
    assert 0.001 < np.std(ratios) < 0.01  # 0.005 / sqrt(2) for the mean of two wheels


def test_the_same_seed_gives_the_same_drive_bit_for_bit():
    def bits(seed):
        return [
            (r.odometry, r.truth, r.ticks, r.scan.stamp, r.scan.ranges.tobytes())
            for r in islice(drive(room(seed=seed)), 30)
        ]

    assert bits(3) == bits(3)
    assert bits(3)[-1][2] != bits(4)[-1][2]


def test_the_scanner_does_not_change_the_drive():
    small = Scanner(beams=5, range_sigma=0.1)
    one, other = (list(drive(room(scanner=s))) for s in (Scanner(), small))
    assert [r.truth for r in one] == [r.truth for r in other]
    assert len(other[0].scan) == 5


def test_the_scan_is_made_from_where_the_laser_truly_is():
    plan = room(scanner=Scanner(range_sigma=0.0))
    robot = Robot(laser=Pose2D(0.1, 0.05, 0.3))
    for reading in islice(drive(plan, robot), 0, 60, 20):
        seen = reading.observation
        assert seen.pose == compose(reading.truth, robot.laser)
        assert reading.scan.pose == compose(reading.odometry, robot.laser)
        np.testing.assert_array_equal(
            reading.scan.ranges, plan.drive.scanner.cast(plan.world, seen.pose)[0]
        )
        walls = seen.pose.transform(reading.scan.points)
        inside = np.minimum(walls, (5.0, 4.0) - walls).min(axis=1)
        np.testing.assert_allclose(inside, 0, atol=1e-9)


def test_a_robot_that_runs_into_a_wall_says_where_it_is_stuck():
    world = World.outline([(0, 0), (5, 0), (5, 4), (0, 4)])
    blocked = replace(world, walls=[*world.walls, [(2.5, 0), (2.5, 4)]], reflectivity=None)
    plan = Plan(world=blocked, drive=Drive(waypoints=[(1, 2), (4, 2)]))
    readings = drive(plan)
    truth = []
    with pytest.raises(
        DriveError,
        match=r"stuck at \(2\.3., [12]\.\d\d\) on .* way-point 1 \(4, 2\) against wall 4",
    ):
        truth.extend(reading.truth.x for reading in readings)
    assert max(truth) < 2.5 - 0.15  # the front is 16 cm ahead of the axle


def test_a_robot_that_does_not_fit_where_it_starts_is_refused():
    plan = room(waypoints=[(0.1, 1.0), (4.0, 1.0)])
    with pytest.raises(DriveError, match=r"does not fit at way-point 0 \(0\.1, 1\.0\): .*wall 0"):
        next(drive(plan))


def test_a_plan_must_have_a_drive_that_the_robot_can_make():
    with pytest.raises(ValueError, match="must have a drive"):
        drive(Plan(world=HALL))
    with pytest.raises(ValueError, match=r"at most 1.0 m/s, the robot's, got 2.0"):
        drive(room(speed=2.0))


@pytest.mark.parametrize(
    ("figures", "complaint"),
    [
        ({"mass": 0.0}, "mass must be > 0 kg, got 0.0"),
        ({"track": math.nan}, "track must be > 0 m"),
        ({"ticks_per_turn": -1}, "ticks_per_turn must be > 0 ticks"),
        ({"radius_error": 0.5}, "radius_error must be a share of 0 to 0.1, got 0.5"),
        ({"friction": (0.5, 0.1)}, "friction must be 0 < lowest <= highest"),
    ],
)
def test_figures_that_make_no_sense(figures, complaint):
    with pytest.raises(ValueError, match=complaint):
        Robot(**figures)
