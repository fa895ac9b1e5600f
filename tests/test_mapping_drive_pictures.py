"""What the pictures of simulated drives show."""

import math

import numpy as np
import pytest

from laserfeatures import figures
from laserfeatures.data import Pose2D
from laserfeatures.mapping.drive_pictures import drive_figure, error_figure
from laserfeatures.mapping.landmark_truth import TrueMap
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.simulated_drive import SimulatedDrive
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.simulation import Observation, Scanner, World
from laserfeatures.simulation.robot import Reading
from laserfeatures.slam import Landmark

STAMPS = np.array([10.0, 11.0, 12.0])
TRUE = np.array([(1.0, 1.0, 0.0), (2.0, 1.0, 0.0), (3.0, 1.0, 0.0)])
BY_ODOMETRY = TRUE + np.array([(0, 0, 0), (0, 0.5, 0), (0, 3.0, 0)])
ESTIMATED = TRUE + np.array([(0, 0, 0), (0.03, 0.04, 0), (0, 0.02, 0)])
DEVIATIONS = np.array([0.0, 0.01, 0.02])  # in the direction that is least certain


@pytest.fixture
def drive():
    room = [((0, 0), (6, 0)), ((6, 0), (6, 4)), ((6, 4), (0, 4)), ((0, 4), (0, 0))]
    world = World(walls=np.array(room, dtype=float), poles=[(5, 3, 0.2)])
    rng = np.random.default_rng(0)
    readings = []
    for x, y, theta in TRUE.tolist():
        pose = Pose2D(x, y, theta)
        seen: Observation = Scanner().observe(world, pose, rng)
        readings.append(
            Reading(scan=seen.scan, odometry=pose, truth=pose, ticks=(0, 0), observation=seen)
        )
    nothing = TrueMap(corners=np.empty((0, 2)), real=[], walls=np.empty((0, 2, 2)))
    return SimulatedDrive(
        readings=readings, truth=Trajectory(stamps=STAMPS, poses=TRUE), map=nothing
    )


@pytest.fixture
def run():
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    covariances = np.zeros((3, 3, 3))
    for covariance, deviation in zip(covariances, DEVIATIONS, strict=True):
        covariance[:2, :2] = turn @ np.diag([deviation**2 / 4, deviation**2]) @ turn.T
    corner = Landmark(
        kind="corner", values=np.array([6.0, 4.0]), covariance=1e-4 * np.eye(2),
        ends=np.array([(6.0, 4.0)] * 2), sightings=3,
    )  # fmt: skip
    wall = Landmark(
        kind="wall", values=np.array([math.pi / 2, 4.0]), covariance=1e-4 * np.eye(2),
        ends=np.array([(0.5, 4.0), (5.5, 4.0)]), sightings=3,
    )  # fmt: skip
    return Run(
        estimate=Trajectory(stamps=STAMPS, poses=ESTIMATED),
        odometry=Trajectory(stamps=STAMPS, poses=BY_ODOMETRY),
        covariances=covariances,
        matched=np.zeros(3, dtype=np.int64), landmarks=np.zeros(3, dtype=np.int64),
        nis=np.zeros(3), seconds=np.zeros(3), map=(corner, wall), points=[], notices=[],
    )  # fmt: skip


def lines(axes):
    return {line.get_label(): line for line in axes.lines}


def test_figure_8_has_the_papers_colours(run, drive):
    (axes,) = drive_figure(run, drive, "a title").axes
    drawn = lines(axes)
    for label, poses, colour, style in (
        ("true path", TRUE, "k", "--"),
        ("odometry", BY_ODOMETRY, "k", "-"),
        ("EKF-SLAM", ESTIMATED, figures.BLUE, "-"),
    ):
        assert np.array_equal(drawn[label].get_xydata(), poses[:, :2])
        assert (drawn[label].get_color(), drawn[label].get_linestyle()) == (colour, style)
    marked = [line for line in axes.lines if line.get_color() == figures.RED]
    assert any(np.array_equal(line.get_xydata(), [(6, 4)]) for line in marked)
    assert axes.get_title() == "a title"
    assert len(axes.patches) == 1  # the pole


def test_figure_8_shows_world_and_paths_whole(run, drive):
    (axes,) = drive_figure(run, drive).axes
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    assert max(left, bottom) < 0
    assert right > 6
    assert top > 4


def test_figure_9_has_both_errors_in_metres_and_the_filters_with_its_bound_in_mm(run, drive):
    above, below = error_figure(run, drive).axes
    drawn = lines(above)
    assert np.allclose(drawn["odometry"].get_xydata(), [(0, 0), (1, 0.5), (2, 3)])
    assert np.allclose(drawn["EKF-SLAM"].get_xydata(), [(0, 0), (1, 0.05), (2, 0.02)])
    assert (drawn["odometry"].get_color(), drawn["EKF-SLAM"].get_color()) == ("k", figures.BLUE)
    error, bound = (line.get_ydata() for line in below.lines)
    assert np.allclose(error, [0, 50, 20])
    assert np.allclose(bound, 3e3 * DEVIATIONS)
    assert "[mm]" in below.get_ylabel()
