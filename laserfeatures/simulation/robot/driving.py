"""Driving: from a plan to what the robot reads on its way."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from laserfeatures.data import Pose2D
from laserfeatures.errors import DriveError
from laserfeatures.poses import compose
from laserfeatures.simulation.plan import Drive, Plan
from laserfeatures.simulation.robot.body import Body
from laserfeatures.simulation.robot.follower import Follower
from laserfeatures.simulation.robot.model import TIME_STEP
from laserfeatures.simulation.robot.odometry import Odometry, encoder_ticks
from laserfeatures.simulation.robot.platform import Robot
from laserfeatures.simulation.robot.reading import Reading
from laserfeatures.simulation.world import World

STEPS = 5  # of the physics in one of the controller
PERIOD = STEPS * TIME_STEP  # [s]
SETTLING = 50  # periods, for the robot to come to rest on its wheels
PATIENCE = 4.0  # [s] without progress
PROGRESS = 0.02  # [m] or [rad]
TIPPED = math.radians(30)


def drive(plan: Plan, robot: Robot | None = None) -> Iterator[Reading]:
    """Drive a robot along the way-points of a plan, and yield what it reads.

    The controller is told the true pose, so that the way-points are passed whatever the odometry
    has come to: every extractor and filter that is tried on the readings gets the same drive. All
    randomness comes from the drive's seed, and the scanner's apart from that of wheels and floor.

    Parameters
    ----------
    plan : Plan
        The world and the drive.
    robot : Robot, optional
        What drives; ``Robot()`` if left out.

    Yields
    ------
    Reading
        The first at rest on the first way-point, the others at the plan's scan rate (at the first
        step of the controller, 20 ms, at or after each moment).

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    DriveError
        If the robot does not fit where it starts, makes no progress for 4 s, or tips over.
    ValueError
        If the plan has no drive, or one that is faster than the robot.
    """
    robot = robot or Robot()
    if plan.drive is None:
        raise ValueError("the plan must have a drive, got a world only")
    if plan.drive.speed > robot.max_speed:
        raise ValueError(
            f"speed must be at most {robot.max_speed} m/s, the robot's, got {plan.drive.speed}"
        )
    return _drive(plan.world, plan.drive, robot)


def _drive(world: World, drive: Drive, robot: Robot) -> Iterator[Reading]:
    noise, chance = (np.random.default_rng(s) for s in np.random.SeedSequence(drive.seed).spawn(2))
    (x, y), (to_x, to_y) = drive.waypoints[:2].tolist()
    start = Pose2D(x, y, math.atan2(to_y - y, to_x - x))
    body = Body(robot, world, start, chance)
    if body.touching:
        raise DriveError(f"the robot does not fit at way-point 0 ({x}, {y}): {body.touching}")
    for _ in range(SETTLING):
        body.advance(0.0, 0.0, STEPS)
    odometry = Odometry(robot, body.pose, encoder_ticks(robot, body.wheel_angles))
    zero = odometry.ticks
    follower = Follower(drive.waypoints, drive.speed, robot.max_turn_rate)
    guard = Guard(body, follower)
    period = scans = 0
    while not follower.done:
        odometry.update(encoder_ticks(robot, body.wheel_angles))
        time = period * PERIOD
        if time * drive.scan_rate >= scans - 1e-9:
            truth = body.pose
            seen = drive.scanner.observe(world, compose(truth, robot.laser), noise, stamp=time)
            left, right = (a - b for a, b in zip(odometry.ticks, zero, strict=True))
            yield Reading(
                scan=replace(seen.scan, pose=compose(odometry.pose, robot.laser)),
                odometry=odometry.pose,
                truth=truth,
                ticks=(left, right),
                observation=seen,
            )
            scans += 1
        body.advance(*follower.steer(body.pose, PERIOD), STEPS)
        guard.check(time)
        period += 1


class Guard:
    """Sees to it that the robot gets on.

    Parameters
    ----------
    body : Body
        The robot.
    follower : Follower
        Its controller.
    """

    def __init__(self, body: Body, follower: Follower) -> None:
        self._body = body
        self._follower = follower
        self._best = (0, math.inf)  # way-point ahead, left to do until there
        self._since = 0.0

    def check(self, time: float) -> None:
        """Check at a time [s] that the robot stands on its wheels and has come on lately.

        Raises
        ------
        DriveError
            If not; it names the way-point and the position.
        """
        target, least = self._best
        if self._follower.target > target or self._follower.left < least - PROGRESS:
            self._best = (self._follower.target, self._follower.left)
            self._since = time
        if self._body.tilt > TIPPED:
            raise DriveError(f"the robot has tipped over {self._place()}")
        if time - self._since > PATIENCE:
            raise DriveError(
                f"the robot is stuck {self._place()}: no progress for {PATIENCE:g} s; way-points "
                "and the straight lines between them must be at least 0.3 m clear of everything"
            )

    def _place(self) -> str:
        pose, touching = self._body.pose, self._body.touching
        target = min(self._follower.target, len(self._follower.waypoints) - 1)
        x, y = self._follower.waypoints[target]
        where = f"at ({pose.x:.2f}, {pose.y:.2f}) on its way to way-point {target} ({x:g}, {y:g})"
        return f"{where} against {touching}" if touching else where
