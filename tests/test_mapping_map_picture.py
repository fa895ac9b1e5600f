"""The picture of a map shows the scans, the ways and the landmarks where they are."""

import io
import math

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection

from laserfeatures import figures
from laserfeatures.mapping.map_picture import map_figure, odometry_way, placed_points
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.slam import Landmark

QUARTER = math.pi / 2
CORNER = Landmark(
    kind="corner", values=np.array([4.0, 3.0]), covariance=np.diag([0.04, 0.01]),
    ends=np.array([[4.0, 3.0], [4.0, 3.0]]), sightings=3,
)  # fmt: skip
WALL = Landmark(
    kind="wall", values=np.array([0.0, 4.0]), covariance=np.diag([1e-4, 1e-4]),
    ends=np.array([[4.0, -1.0], [4.0, 3.0]]), sightings=3,
)  # fmt: skip


def a_run(*, landmarks=(CORNER, WALL), points=None):
    """Return a run along x, whose odometry has another frame and turns a little."""
    stamps = np.arange(3.0)
    return Run(
        estimate=Trajectory(stamps=stamps, poses=[(1, 1, 0), (2, 1, 0), (3, 1, QUARTER)]),
        odometry=Trajectory(
            stamps=stamps, poses=[(50, 9, QUARTER), (50, 10, QUARTER), (49.9, 11, QUARTER)]
        ),
        covariances=np.tile(1e-4 * np.eye(3), (3, 1, 1)),
        matched=np.array([0, 1, 1]),
        landmarks=np.array([0, 1, 2]),
        nis=np.array([0.0, 1.0, 3.0]),
        seconds=np.array([3e-3, 1e-3, 2e-3]),
        map=tuple(landmarks),
        points=points or [np.array([(3.0, 2.0)]), np.array([(2.0, 2.0)]), np.array([(2.0, -1.0)])],
        notices=[],
    )


def lines_by_label(figure):
    return {line.get_label(): line.get_xydata() for line in figure.axes[0].lines}


def test_points_are_placed_by_the_poses_of_slam():
    np.testing.assert_allclose(placed_points(a_run()), [(4, 3)] * 3, atol=1e-12)


def test_points_are_thinned_evenly_over_the_scans():
    points = [np.tile([(float(i), 0.0)], (100 + i, 1)) for i in range(3)]
    run = a_run(points=points)
    placed = placed_points(run, most=31)
    assert len(placed) == math.ceil(303 / 10)
    assert len(placed_points(run, most=303)) == 303


def test_the_odometry_starts_where_slam_does_and_keeps_its_form():
    np.testing.assert_allclose(odometry_way(a_run()), [(1, 1), (2, 1), (3, 1.1)], atol=1e-12)


def test_ways_points_and_landmarks_are_drawn_in_metres():
    figure = map_figure(a_run(), np.array([(1, 1), (3, 0.9)]), "a title")
    (axes,) = figure.axes
    lines = lines_by_label(figure)
    np.testing.assert_allclose(lines["SLAM"], [(1, 1), (2, 1), (3, 1)])
    np.testing.assert_allclose(lines["odometry"], [(1, 1), (2, 1), (3, 1.1)], atol=1e-12)
    np.testing.assert_allclose(lines["reference"], [(1, 1), (3, 0.9)])
    (walls,) = [each for each in axes.collections if isinstance(each, LineCollection)]
    np.testing.assert_allclose(walls.get_segments(), [WALL.ends])
    (ellipses,) = [each for each in axes.collections if isinstance(each, EllipseCollection)]
    sides = sorted([ellipses.get_widths()[0], ellipses.get_heights()[0]])
    np.testing.assert_allclose(sides, [6 * 0.1, 6 * 0.2])
    np.testing.assert_allclose(ellipses.get_offsets(), [(4, 3)])
    along_x = ellipses.get_angles()[0] % 180 == pytest.approx(0, abs=1e-9)
    assert along_x == (ellipses.get_widths()[0] > ellipses.get_heights()[0])
    assert axes.get_aspect() == 1
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")
    assert axes.get_title(loc="left") == "a title"
    assert not axes.get_title(loc="right")
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    assert (low < [1, -1]).all()
    assert (high > [4, 3]).all()
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names[1:4] == ["odometry", "reference", "SLAM"]


def test_a_far_point_does_not_shrink_the_map():
    points = [
        np.tile([(3.0, 2.0)], (300, 1)),
        np.tile([(2.0, 2.0)], (300, 1)),
        np.array([(9e3, 0)]),
    ]
    (axes,) = map_figure(a_run(points=points)).axes
    assert max(axes.get_xlim()) < 10


def test_a_far_corner_does_not_shrink_the_map_and_is_told_of():
    far = Landmark(
        kind="corner", values=np.array([4.0, 80.0]), covariance=np.eye(2),
        ends=np.array([[4.0, 80.0], [4.0, 80.0]]), sightings=3,
    )  # fmt: skip
    (axes,) = map_figure(a_run(landmarks=[far, WALL])).axes
    assert max(axes.get_ylim()) < 10
    assert axes.get_title(loc="right") == "1 corner outside"


@pytest.mark.parametrize("landmarks", [(), (CORNER,), (WALL,)])
def test_it_can_be_saved_with_few_landmarks_and_no_points(landmarks):
    run = a_run(landmarks=landmarks, points=[np.empty((0, 2))] * 3)
    file = io.BytesIO()
    figures.save(map_figure(run), file, "png")
    assert file.getvalue().startswith(b"\x89PNG")
