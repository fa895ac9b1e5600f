"""Writing CARMEN logs, as `carmen` reads them.

A scan whose directions follow from the number of its beams (as of a SICK LMS: 180, 181, 360 or 361
beams) is a record FLASER, any other a record ROBOTLASER1, which states them and the sensor's range.
No return is 81.91 m, a code of the SICK LMS that no reading can have. Numbers are written with all
their digits: what is read back is the same to the last bit (directions to 1e-12 rad).
"""

import itertools
import math
from collections.abc import Iterable
from typing import IO

import numpy as np

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.poses import relative
from laserfeatures.simulation.robot import Reading
from laserfeatures.sources.carmen import flaser_angles
from laserfeatures.sources.no_return import CENTIMETRE_BAND

NO_RETURN = 81.91  # [m]
FARTHEST = CENTIMETRE_BAND[0]  # [m]; the reader takes what is farther for no return
HOST = "simulation"
TOLERANCE = 1e-9  # [rad] of directions
HEADER = """\
# CARMEN log written by laserfeatures; m, rad, s
# ODOM x y theta tv rv accel t host logger_t
# FLASER n r1..rn x y theta odom_x odom_y odom_theta t host logger_t
"""
TRUE_POSES = """\
# x y theta is the true pose of the laser, odom that of the robot by its wheels.
# NEFF tells readers that x y theta is not odometry.
"""


def write_carmen(file: IO[str], readings: Iterable[Reading | LaserScan]) -> None:
    """Write readings of a simulated robot, or scans with poses, as a CARMEN log.

    A reading is written with the true pose of the laser, in the place of the corrected pose of a
    recorded log, and the odometry of the robot; where the laser sits on it is the ``PARAM
    robot_frontlaser_offset``. A scan is written with its pose in both places.

    Parameters
    ----------
    file : text file
        Open for writing.
    readings : iterable of Reading or LaserScan
        What to write, in order; written one by one.

    Raises
    ------
    ValueError
        If a scan has no pose, directions that are not evenly spaced, or a return at or beyond
        81.825 m.
    """
    items = iter(readings)
    first = next(items, None)  # before anything is written: a plan that cannot be read shows here
    file.write(HEADER)
    if isinstance(first, Reading):
        file.write(TRUE_POSES)
        offset = relative(first.truth, first.observation.pose).x
        file.write(f"PARAM robot_frontlaser_offset {offset:.6g}\nNEFF 1 0 {HOST} 0\n")
    before: tuple[Pose2D, float] | None = None
    for item in itertools.chain([] if first is None else [first], items):
        scan = item.scan if isinstance(item, Reading) else item
        if scan.pose is None:
            raise ValueError(f"a CARMEN log needs scans with poses, got none at {scan.stamp} s")
        if isinstance(item, Reading):
            laser, odometry = item.observation.pose, item.odometry
        else:
            laser = odometry = scan.pose
        now = odometry, scan.stamp
        file.write(_odom(now, before or now))
        file.write(_scan(scan, laser, odometry))
        before = now


def _odom(now: tuple[Pose2D, float], before: tuple[Pose2D, float]) -> str:
    step = relative(before[0], now[0])
    seconds = now[1] - before[1]
    # Without two times there is no speed.
    speed, turn_rate = (step.x / seconds, step.theta / seconds) if seconds > 0 else (0.0, 0.0)
    return f"ODOM {_pose(now[0])} {speed:.6g} {turn_rate:.6g} 0 {_time(now[1])}\n"


def _scan(scan: LaserScan, laser: Pose2D, odometry: Pose2D) -> str:
    ranges = np.where(scan.valid, scan.ranges, NO_RETURN)
    far = ranges[scan.beams].max(initial=0.0)
    if far >= FARTHEST:
        raise ValueError(f"a CARMEN log holds ranges below {FARTHEST} m, got {far} m")
    count = len(scan)
    values = " ".join([str(count), *map(repr, ranges.tolist())])
    poses = f"{_pose(laser)} {_pose(odometry)}"
    if np.allclose(scan.angles, flaser_angles(count), rtol=0, atol=TOLERANCE):
        return f"FLASER {values} {poses} {_time(scan.stamp)}\n"
    start, view, step = _directions(scan)
    limit = scan.range_max if math.isfinite(scan.range_max) else 0.0
    sensor = f"0 {start!r} {view!r} {step!r} {limit!r} 0 0"
    return f"ROBOTLASER1 {sensor} {values} 0 {poses} 0 0 0 0 0 {_time(scan.stamp)}\n"


def _directions(scan: LaserScan) -> tuple[float, float, float]:
    """Return the first direction, the field of view and the step [rad].

    Raises
    ------
    ValueError
        If there is not one step.
    """
    first, last = float(scan.angles[0]), float(scan.angles[-1])
    step = (last - first) / max(len(scan) - 1, 1) or 1.0
    even = first + step * np.arange(len(scan))
    if not np.allclose(scan.angles, even, rtol=0, atol=TOLERANCE):
        raise ValueError(
            f"a CARMEN log holds evenly spaced directions, got steps of "
            f"{np.diff(scan.angles).min():.6g} to {np.diff(scan.angles).max():.6g} rad"
        )
    return first, last - first, step


def _pose(pose: Pose2D) -> str:
    return f"{pose.x!r} {pose.y!r} {pose.theta!r}"


def _time(stamp: float) -> str:
    """Return a time, the host and the logger's time; all zeros stand for no times."""
    time = repr(stamp) if math.isfinite(stamp) else "0"
    return f"{time} {HOST} {time}"
