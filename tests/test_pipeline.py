import dataclasses
import math

import numpy as np
import pytest
from laserfeatures_plugins.direct_hough import DirectHough
from scenes import chain, scan_of, segments_of

from laserfeatures import Intersections, Pipeline, PluginError, PointFeatures, SegmentFilter

WALLS = segments_of(
    [0.0, math.pi / 2, 0.0],
    [2.0, 1.0, 5.0],
    [
        (0, -1.0, 1.0, range(20), 0.01),
        (1, -2.0, 1.0, range(20, 40), 0.01),
        (2, 0.0, 1.0, range(40, 42), 0.01),
    ],
)
SCAN = scan_of(*chain((2, -1), (2, 1), (-1, 1)))


def test_a_scan_goes_through_the_detector_the_filter_and_the_intersections():
    seen = []

    def detector(scan):
        seen.append(scan)
        return WALLS

    features = Pipeline(name="fixed", detector=detector)(SCAN)
    assert seen == [SCAN]
    assert features.scan is SCAN
    assert features.lines.d.tolist() == [2.0, 1.0]  # the third had two points
    np.testing.assert_allclose(features.corners.positions, [[2.0, 1.0]])


def test_the_stages_that_are_passed_are_the_ones_that_run():
    pipeline = Pipeline(
        name="fixed",
        detector=lambda _: WALLS,
        segment_filter=SegmentFilter(min_points=1),
        intersections=Intersections(max_distance=5.0),
    )
    features = pipeline(SCAN)
    assert features.lines.d.tolist() == [2.0, 1.0, 5.0]
    assert len(features.corners) == 1  # (5, 1) is 5.1 m away


def test_corners_that_are_found_without_lines_are_the_result():
    corners = PointFeatures(
        positions=[[30.0, 1.0]],
        covariance=[np.eye(2)],
        lines=[[-1, -1]],
        angles=[1.5],
        real=[True],
    )
    features = Pipeline(name="points", detector=lambda _: corners)(SCAN)
    assert features.corners is corners
    assert len(features.lines) == len(features.segments) == 0
    assert features.segments.points.shape == (0, len(SCAN))


@pytest.mark.parametrize("returned", [None, [], WALLS.lines, "segments"])
def test_a_detector_that_returns_no_segments_is_named(returned):
    pipeline = Pipeline(name="odd", detector=lambda _: returned)
    message = (
        f"extractor 'odd' must return LineSegments or PointFeatures, got {type(returned).__name__}"
    )
    with pytest.raises(PluginError, match=message):
        pipeline(SCAN)


@pytest.mark.parametrize(
    ("value", "got"),
    [
        (np.ones(100), "ndarray of shape (100,)"),
        ([1.0, 2.0], "list"),
        (None, "NoneType"),
        (WALLS, "LineSegments"),
    ],
)
def test_what_is_no_scan_is_refused_with_how_to_make_one(value, got):
    pipeline = Pipeline(name="fixed", detector=DirectHough())
    for use in (pipeline, pipeline.detect):
        with pytest.raises(TypeError) as error:
            use(value)
        assert str(error.value).startswith(f"expected a LaserScan, got {got}; make one of ranges ")
        assert "LaserScan.uniform(ranges, angle_min, angle_increment)" in str(error.value)


@pytest.mark.parametrize("noise", [0.01, "1cm"])
def test_what_is_no_noise_is_refused(noise):
    with pytest.raises(TypeError, match=r"^noise must be a RangeNoise, .*, got "):
        Pipeline(name="fixed", detector=DirectHough())(SCAN, noise=noise)


def test_an_error_of_a_detector_is_not_hidden():
    def detector(_):
        raise ZeroDivisionError("of the plugin's own")

    with pytest.raises(ZeroDivisionError, match="of the plugin's own"):
        Pipeline(name="odd", detector=detector)(SCAN)


@pytest.mark.parametrize(
    ("stage", "value", "kind"),
    [
        ("segment_filter", Intersections(), "SegmentFilter"),
        ("segment_filter", {"min_points": 4}, "SegmentFilter"),
        ("intersections", None, "Intersections"),
    ],
)
def test_a_stage_of_another_kind_is_refused(stage, value, kind):
    with pytest.raises(TypeError, match=f"{stage} must be a {kind}, got "):
        Pipeline(name="x", detector=DirectHough(), **{stage: value})


def test_a_pipeline_tells_all_its_parameters():
    pipeline = Pipeline(name="x", detector=DirectHough(range_sigma=0.01))
    assert dataclasses.asdict(pipeline)["detector"]["range_sigma"] == 0.01
    assert "range_sigma=0.01" in repr(pipeline)
    assert "max_sigma=0.25" in repr(pipeline)
    with pytest.raises(dataclasses.FrozenInstanceError):
        pipeline.name = "y"
