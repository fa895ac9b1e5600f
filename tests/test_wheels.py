import math

import pytest

import laserfeatures as lf
from laserfeatures.wheels import WheelOdometry, Wheels, arc

WHEELS = Wheels(tick=0.001, track=0.3, ahead=0.0)


def close(pose, x, y, theta):
    assert (pose.x, pose.y, pose.theta) == pytest.approx((x, y, theta), abs=1e-9)


def test_an_arc_is_a_piece_of_a_circle():
    close(arc(0.5, 0.5, 0.3), 0.5, 0, 0)
    close(arc(-0.1, 0.1, 0.3), 0, 0, 2 / 3)
    # a quarter of a circle of 1 m to the left
    left, right = (math.pi / 2 * (1 + side * 0.15) for side in (-1, 1))
    close(arc(left, right, 0.3), 1, 1, math.pi / 2)
    close(arc(right, left, 0.3), 1, -1, -math.pi / 2)


def test_the_sensor_swings_ahead_of_the_axle():
    odometry = WheelOdometry(Wheels(tick=0.001, track=0.3, ahead=0.1), lf.Pose2D(2, 3, 0))
    odometry.add(0, 500, 500)
    close(odometry.at(0), 2, 3, 0)
    quarter = 0.15 * math.pi / 2 / 0.001
    odometry.add(1, 500 - quarter, 500 + quarter)
    close(odometry.at(1), 1.9, 3.1, math.pi / 2)


def test_between_counts_the_wheels_turn_evenly_and_outside_they_stand():
    odometry = WheelOdometry(WHEELS)
    odometry.add(10, 0, 0)
    odometry.add(11, 200, 200)
    odometry.add(12, 200, 200)
    odometry.add(12, 250, 250)  # counted twice in a moment
    for time, x in ((9, 0), (10, 0), (10.25, 0.05), (11, 0.2), (11.5, 0.2), (12, 0.25), (99, 0.25)):
        close(odometry.at(time), x, 0, 0)
    assert odometry.end == 12


def test_a_late_scan_is_at_where_the_wheels_were():
    odometry = WheelOdometry(Wheels(tick=0.001, track=0.3, ahead=0, latency=0.4))
    odometry.add(0, 0, 0)
    odometry.add(1, 100, 100)
    close(odometry.at(1), 0.06, 0, 0)


def test_a_jump_is_named_and_left_out_of_the_way():
    odometry = WheelOdometry(WHEELS)
    odometry.add(0, 65000, 0)
    odometry.add(1, 65100, 100)
    with pytest.raises(
        ValueError, match=r"left wheel, got -65090 \(from 65100 to 10\) within 1 s: .*has wrapped"
    ):
        odometry.add(2, 10, 200)
    odometry.add(3, 110, 300)
    close(odometry.at(1.5), 0.1, 0, 0)
    close(odometry.at(3), 0.2, 0, 0)
    with pytest.raises(ValueError, match="finite"):
        odometry.add(4, math.nan, 0)


def test_a_clock_set_back_does_not_move_the_robot():
    odometry = WheelOdometry(WHEELS)
    odometry.add(100, 0, 0)
    odometry.add(101, 100, 100)
    odometry.add(5, 150, 150)
    odometry.add(6, 250, 250)
    close(odometry.at(5), 0.15, 0, 0)
    close(odometry.at(6), 0.25, 0, 0)
    close(odometry.at(4.8), 0.15, 0, 0)
    odometry.add(1, -90000, 4)  # a robot that was started anew
    odometry.add(2, -89900, 104)
    close(odometry.at(1), 0.25, 0, 0)
    close(odometry.at(2), 0.35, 0, 0)


def test_what_is_too_old_is_forgotten():
    odometry = WheelOdometry(WHEELS, keep=2)
    for second in range(100):
        odometry.add(second, 100 * second, 100 * second)
    assert len(odometry._times) <= 4
    close(odometry.at(99), 9.9, 0, 0)
    close(odometry.at(97.25), 9.725, 0, 0)


def test_without_ticks_there_is_no_pose():
    odometry = WheelOdometry(WHEELS)
    assert odometry.end == -math.inf
    with pytest.raises(ValueError, match="got none"):
        odometry.at(0)
