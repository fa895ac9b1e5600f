import io
import math
import re
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from laserfeatures import (
    Features,
    LaserFeaturesError,
    LaserScan,
    Lines,
    LineSegments,
    MissingDependencyError,
    PointFeatures,
    Pose2D,
    figures,
)
from laserfeatures.optional import install_line


def lines(theta, d):
    n = len(theta)
    return Lines(theta=theta, d=d, support=[2.0] * n, covariance=np.zeros((n, 2, 2)))


def features(positions=((2.0, 1.0), (2.0, -1.0)), real=(True, False), covariance=None):
    """Two lines, one segment, and corners anywhere, in a scan of three points."""
    n = len(positions)
    scan = LaserScan(angles=[-0.4, 0.0, 0.4], ranges=[2.0, 2.0, 2.2])
    segments = LineSegments(
        lines=lines([0.0, 1.5], [2.0, 1.0]),
        line=[0],
        endpoints=[[[2.0, -1.0], [2.0, 1.0]]],
        support=[3],
        rms=[0.0],
        points=[[True] * 3],
    )
    corners = PointFeatures(
        positions=np.reshape(positions, (n, 2)),
        covariance=np.tile(np.diag([1e-4, 1e-4]), (n, 1, 1)) if covariance is None else covariance,
        lines=[[0, 1]] * n or np.empty((0, 2)),
        angles=[1.5] * n,
        real=real,
    )
    return Features(scan=scan, segments=segments, corners=corners)


def drawn(found, **rest):
    figure = figures.scan_figure(found, **rest)
    figure.draw_without_rendering()
    return figure


def by_label(axes):
    return {line.get_label(): line for line in axes.lines}


def test_points_corners_and_sensor_are_where_they_were_found():
    found = features()
    (axes,) = drawn(found).axes
    shown = by_label(axes)
    assert np.allclose(shown["measured points"].get_xydata(), found.scan.points)
    assert shown["real corners"].get_xydata().tolist() == [[2.0, 1.0]]
    assert shown["virtual corners"].get_xydata().tolist() == [[2.0, -1.0]]
    assert shown["sensor"].get_xydata().tolist() == [[0.0, 0.0]]
    assert shown["virtual corners"].get_markerfacecolor() != figures.BLUE
    assert axes.collections[0].get_segments()[0].tolist() == [[2.0, -1.0], [2.0, 1.0]]
    assert axes.get_aspect() == 1.0


def test_lines_go_through_the_points_they_are_made_of():
    (axes,) = drawn(features(), removed=np.array([[math.pi / 2, 0.5]])).axes
    shown = by_label(axes)
    x, y = shown["kept lines"].get_transform().transform(shown["kept lines"].get_xydata()).T
    x, y = axes.transData.inverted().transform(np.column_stack([x, y])).T
    assert np.allclose(x, 2.0)
    assert np.ptp(y) > 0.99 * np.ptp(axes.get_ylim())
    removed = shown["removed lines"]
    points = removed.get_transform().transform(removed.get_xydata())
    assert np.allclose(axes.transData.inverted().transform(points)[:, 1], 0.5)
    assert removed.get_color() == figures.REMOVED
    assert removed.get_linestyle() != shown["kept lines"].get_linestyle()


def test_a_far_corner_does_not_shrink_the_scene_and_is_counted():
    near, far = (drawn(features(positions=[(x, 0.0)], real=[False])).axes[0] for x in (2.0, 20.0))
    assert near.get_xlim() == far.get_xlim()
    assert not near.get_title(loc="right")
    assert far.get_title(loc="right") == "1 corner outside"


def test_an_ellipse_holds_95_percent_of_normal_draws():
    covariance = np.array([[4e-3, 1e-3], [1e-3, 1e-3]])
    found = features(positions=[(2.0, 1.0)], real=[True], covariance=covariance[None])
    (ellipse,) = drawn(found).axes[0].patches
    draws = np.random.default_rng(0).multivariate_normal([2.0, 1.0], covariance, 20_000)
    inside = ellipse.get_path().contains_points(draws, transform=ellipse.get_patch_transform())
    assert inside.mean() == pytest.approx(0.95, abs=0.01)


def test_an_infinite_covariance_has_no_ellipse():
    found = features(positions=[(2.0, 1.0)], real=[True], covariance=np.full((1, 2, 2), np.inf))
    assert not drawn(found).axes[0].patches


def test_a_scan_without_returns_can_be_drawn():
    scan = LaserScan(angles=[0.0, 0.1], ranges=[math.inf, 0.0])
    found = features(positions=[], real=[])
    empty = Features(scan=scan, segments=found.segments, corners=found.corners)
    (axes,) = drawn(empty).axes
    assert np.ptp(axes.get_xlim()) > 0


def test_the_legend_names_each_thing_once():
    (legend,) = drawn(features(), removed=np.array([[1.0, 0.5], [1.1, 0.5]])).legends
    labels = [text.get_text() for text in legend.get_texts()]
    assert sorted(labels) == [
        "95 % ellipse",
        "kept lines",
        "measured points",
        "real corners",
        "removed lines",
        "segments",
        "sensor",
        "virtual corners",
    ]


def test_the_accumulator_shows_votes_and_circles_lines():
    votes = SimpleNamespace(
        votes=np.eye(4, 6), theta=np.arange(4) * math.pi / 4, d=np.linspace(-1, 1, 6)
    )
    figure = drawn(features(), removed=np.array([[1.0, 0.5]]), accumulator=votes)
    plane = figure.axes[1]
    assert plane.collections[0].get_array().reshape(6, 4).tolist() == votes.votes.T.tolist()
    removed, kept = plane.lines
    assert np.allclose(kept.get_xydata(), [[0.0, 2.0], [math.degrees(1.5), 1.0]])
    assert np.allclose(removed.get_xydata(), [[math.degrees(1.0), 0.5]])
    assert "deg" in plane.get_xlabel()
    assert figure.axes[2].get_ylabel() == "votes"


def test_removed_lines_are_those_that_do_not_survive():
    found = features()
    detected = SimpleNamespace(lines=lines([0.0, 0.7, 1.5], [2.0, 2.0, 1.0]))
    extractor = SimpleNamespace(detect=lambda *_, **__: detected)
    assert figures.removed_lines(extractor, found).tolist() == [[0.7, 2.0]]
    points_only = SimpleNamespace(detect=lambda *_, **__: found.corners)
    assert figures.removed_lines(points_only, found).shape == (0, 2)


def test_a_detector_without_accumulator_is_named():
    extractor = SimpleNamespace(name="plain", detector=object())
    with pytest.raises(LaserFeaturesError, match="extractor 'plain' has no accumulator"):
        figures.accumulator_of(extractor, features().scan)


def test_the_sensor_points_where_it_looks():
    axes = figures.new_figure().subplots()
    figures.draw_sensor(axes, Pose2D(1.0, 2.0, math.pi / 2))
    (marker,) = axes.lines
    assert marker.get_marker() == (3, 0, 0)  # matplotlib's own triangle points up, along y
    assert marker.get_xydata().tolist() == [[1.0, 2.0]]


def test_corners_can_be_drawn_from_a_pose():
    axes = figures.new_figure().subplots()
    figures.draw_corners(axes, features().corners, pose=Pose2D(1.0, 1.0, math.pi / 2))
    assert np.allclose(by_label(axes)["real corners"].get_xydata(), [[0.0, 3.0]])


def test_a_picture_is_written_in_the_format_of_its_ending():
    file = io.BytesIO()
    figures.save(drawn(features()), file, figures.picture_format("a.b/scan.PDF"))
    assert file.getvalue().startswith(b"%PDF")


@pytest.mark.parametrize("name", ["scan", "scan.xyz", ".png"])
def test_an_unknown_ending_names_the_known_ones(name):
    with pytest.raises(ValueError, match=r"must end in one of .*\.png") as error:
        figures.picture_format(name)
    assert repr(name) in str(error.value)


def test_without_matplotlib_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(MissingDependencyError, match=re.escape(install_line("plots"))):
        figures.new_figure()
