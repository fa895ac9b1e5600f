import math
import re
import sys

import numpy as np
import pytest
from robots import PERFECT, room

import laserfeatures as lf
from laserfeatures.data import Pose2D
from laserfeatures.optional import install_line
from laserfeatures.poses import compose, relative
from laserfeatures.simulation import World
from laserfeatures.simulation.robot import DriveError, Robot, drive
from laserfeatures.simulation.robot.body import Body
from laserfeatures.simulation.robot.driving import Guard
from laserfeatures.simulation.robot.follower import Follower
from laserfeatures.simulation.robot.model import TIME_STEP, Wheels, make_model
from laserfeatures.simulation.robot.odometry import Odometry, encoder_ticks

SECOND = round(1 / TIME_STEP)
START = Pose2D(1.0, 2.0, 0.5)


def body(robot=PERFECT, world=None, start=START):
    return Body(robot, world or World(), start, np.random.default_rng(1))


def test_the_model_has_the_platforms_mass_and_size():
    model = make_model(Robot(), World(), START, Wheels(0.05, 0.05, 0.254))
    assert model.body_mass.sum() == pytest.approx(3.6)
    np.testing.assert_allclose(2 * model.geom("chassis").size[:2], (0.33, 0.279))


def test_a_robot_that_is_not_driven_stands_still():
    robot = body()
    robot.advance(0.0, 0.0, 5 * SECOND)
    pose = robot.pose
    assert math.dist((pose.x, pose.y), (1, 2)) < 0.005
    assert abs(pose.theta - 0.5) < 0.005
    assert abs(robot.height) < 0.001
    assert robot.tilt < math.radians(0.2)
    assert robot.touching is None


@pytest.mark.parametrize(("speed", "turn_rate"), [(0.5, 0.0), (0.0, 0.8), (0.3, 0.5), (-0.3, 0.0)])
def test_it_moves_as_commanded_and_stays_level(speed, turn_rate):
    robot = body(start=Pose2D(0.0, 0.0, 0.0))
    robot.advance(speed, turn_rate, 2 * SECOND)  # up to speed
    for _ in range(8):
        before = robot.pose
        robot.advance(speed, turn_rate, SECOND // 4)
        step = relative(before, robot.pose)
        assert step.theta * 4 == pytest.approx(turn_rate, rel=0.05, abs=0.01)
        assert math.hypot(step.x, step.y) * 4 == pytest.approx(abs(speed), rel=0.03, abs=0.01)
        assert abs(robot.height) < 0.001
        assert robot.tilt < math.radians(0.5)


def test_motors_have_limited_torque():
    """From rest, the wheels cannot gain speed faster than the torque lets them."""
    robot = body(Robot(max_torque=0.05, radius_error=0, track_error=0, unevenness=0))
    robot.advance(1.0, 0.0, SECOND // 2)
    # Two wheels push with 0.05 N m / 0.05 m each; rotors and wheels weigh along.
    assert robot.wheel_angles[0] * 0.05 < 0.5 * (2 * 1.0 / 3.6) * 0.5**2 * 1.01
    assert robot.wheel_angles[0] > 0


def test_encoders_count_whole_ticks_of_the_wheels_turns():
    robot = body()
    robot.advance(0.4, 0.3, SECOND)
    ticks = encoder_ticks(PERFECT, robot.wheel_angles)
    assert all(isinstance(tick, int) for tick in ticks)
    assert ticks[1] > ticks[0] > 1000
    for tick, angle in zip(ticks, robot.wheel_angles, strict=True):
        assert 0 <= angle / math.tau * 39_000 - tick < 1
    assert encoder_ticks(PERFECT, (-0.5 * math.tau / 39_000, math.tau)) == (-1, 39_000)


def test_a_readings_ticks_are_those_that_its_odometry_integrates():
    last = list(drive(room()))[-1]
    turned = (last.ticks[1] - last.ticks[0]) / 39_000 * math.tau * 0.05 / 0.254
    assert math.remainder(turned - last.odometry.theta, math.tau) == pytest.approx(0, abs=0.02)


def test_odometry_integrates_arcs_exactly():
    """A quarter circle of radius 1 m, in one step or in many."""
    robot = Robot(wheel_radius=0.05, track=0.2, ticks_per_turn=10_000_000)
    rolled = [math.pi / 2 * r / 0.05 for r in (0.9, 1.1)]
    for steps in (1, 7, 100):
        odometry = Odometry(robot, Pose2D(2.0, 3.0, math.pi / 2))
        for i in range(1, steps + 1):
            odometry.update(encoder_ticks(robot, tuple(angle * i / steps for angle in rolled)))
        pose = odometry.pose
        np.testing.assert_allclose((pose.x, pose.y), (1.0, 4.0), atol=1e-5)
        assert abs(pose.theta) == pytest.approx(math.pi, abs=1e-5)


def test_odometry_of_a_straight_way_and_of_none():
    robot = Robot()
    odometry = Odometry(robot, Pose2D(0.0, 0.0, math.pi / 6))
    odometry.update((39_000, 39_000))
    np.testing.assert_allclose(
        (odometry.pose.x, odometry.pose.y),
        np.array([math.cos(math.pi / 6), 0.5]) * math.tau * 0.05,
    )
    before = odometry.pose
    odometry.update((39_000, 39_000))
    assert odometry.pose == before


def test_poses_on_poses():
    a, b = Pose2D(1.0, 2.0, 3.0), Pose2D(-0.5, 0.25, 1.0)
    back = relative(a, compose(a, b))
    np.testing.assert_allclose((back.x, back.y, back.theta), (-0.5, 0.25, 1.0))
    assert abs(compose(a, b).theta) <= math.pi


def test_a_robot_that_tips_over_is_noticed():
    robot = body()
    follower = Follower(np.array([(1.0, 2.0), (5.0, 2.0)]), 0.4, 1.0)
    guard = Guard(robot, follower)
    guard.check(0.0)
    robot._data.qpos[3:7] = (math.cos(0.5), math.sin(0.5), 0.0, 0.0)  # rolled by 1 rad
    with pytest.raises(
        DriveError, match=r"tipped over at \(1.00, 2.00\) on its way to way-point 1 \(5, 2\)"
    ):
        guard.check(0.1)


def test_a_follower_slows_down_at_sharp_corners_only():
    """Speeds 10 cm before the middle way-point."""

    def speed_before(last):
        follower = Follower(np.array([(0.0, 0.0), (4.0, 0.0), last]), 0.8, 1.0)
        for x in np.arange(0, 3.9, 0.01):
            command = follower.steer(Pose2D(float(x), 0.0, 0.0), 0.02)
        return command[0]

    assert speed_before((8.0, 0.5)) == pytest.approx(0.8)
    assert speed_before((4.0, 4.0)) < 0.4


def test_a_follower_turns_on_the_spot_and_is_done_at_the_end():
    follower = Follower(np.array([(0.0, 0.0), (0.0, 1.0)]), 0.4, 1.0)
    for _ in range(100):
        speed, turn_rate = follower.steer(Pose2D(0.0, 0.0, 0.0), 0.02)
    assert speed == 0
    assert turn_rate == pytest.approx(1.0)
    assert not follower.done
    assert follower.steer(Pose2D(0.0, 0.98, 0.0), 0.02) == (0.0, 0.0)
    assert follower.done


def test_without_mujoco_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(lf.MissingDependencyError, match=re.escape(install_line("sim"))):
        next(drive(room()))
