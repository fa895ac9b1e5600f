import math
import pickle

import cv2
import numpy as np
import pytest
from laserfeatures_plugins.raster import RasterHough, hough
from laserfeatures_plugins.raster.drawing import draw
from recordings import DATA, RECORDINGS, needs_recordings
from scenes import (
    chain,
    found_lines,
    line_errors,
    look,
    nearest_line,
    needs_compiler,
    random_room,
    scan_of,
    true_lines,
    wall,
)

from laserfeatures import get_extractor, open_source

CHI2_95 = 5.991


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"resolution": 0.0}, "resolution must be in .0.0001, 10. m, got 0.0"),
        ({"max_range": 0.0}, "max_range must be > 0 m, got 0.0"),
        ({"max_range": math.nan}, "max_range must be > 0 m, got nan"),
        ({"min_incidence": 0.0}, "min_incidence must be in"),
        ({"theta_step": 0.0}, "theta_step must be in .0.001, pi/8. rad, got 0.0"),
        ({"min_votes": 0}, "min_votes must be >= 1, got 0"),
        ({"blur": 0.2}, "blur must be 0 or in .0.5, 20. pixels, got 0.2"),
        ({"blur": 1.0, "blur_growth": -0.1}, "blur_growth must be in .0, 1. m/m, got -0.1"),
        ({"blur_growth": 0.1}, "blur_growth 0.1 needs a blur to grow from, got 0"),
        ({"range_sigma": 0.0}, "range_sigma must be in"),
        ({"min_points": 2}, "min_points must be >= 3, got 2"),
        ({"resolution": 0.005}, "60 m x 60 m at a resolution of 0.005 m has 144000000 pixels"),
    ],
)
def test_parameters_are_checked(parameters, message):
    with pytest.raises(ValueError, match=message):
        RasterHough(**parameters)


def test_a_large_image_is_refused_at_the_scan_where_only_that_can_tell():
    detector = RasterHough(max_range=math.inf)
    corners = [(500, -500), (500, 500), (-500, 500), (-500, -500), (500, -500)]
    scan = scan_of(*chain(*corners), beams=1441, view=2 * math.pi, range_max=1000.0)
    with pytest.raises(ValueError, match=r"1000 m x 1000 m at a resolution of 0.02 m has"):
        detector(scan)
    near = scan_of([(2, -1), (2, 1)], sigma=0.003)
    assert len(detector(near)) == 1


def test_a_large_accumulator_is_refused(monkeypatch):
    monkeypatch.setattr(hough, "MAX_CELLS", 10**5)
    with pytest.raises(ValueError, match=r"the accumulator of 720 x 2[0-9]{2} cells is too large"):
        RasterHough(theta_step=math.pi / 720)(scan_of([(2, -1), (2, 1)], sigma=0.003))


def test_a_blur_needs_an_opencv_that_weighs_votes(monkeypatch):
    monkeypatch.setattr(cv2, "__version__", "4.10.0")
    RasterHough()
    with pytest.raises(ValueError, match=r"blur needs OpenCV 4\.11 or newer, this is 4\.10\.0"):
        RasterHough(blur=1.0)


def test_an_extractor_can_be_sent_to_another_process_after_use():
    extractor = get_extractor("raster_hough")
    scan = scan_of([(2, -1), (2, 1)], sigma=0.003)
    before = found_lines(extractor(scan))
    sent = pickle.loads(pickle.dumps(extractor))  # noqa: S301 - our own
    np.testing.assert_array_equal(found_lines(sent(scan)), before)


def test_bins_are_where_the_walls_are_without_half_a_pixel_of_bias():
    # Over all directions, sides and places in a pixel the errors of bins have no mean.
    rng = np.random.default_rng(0)
    extractor = get_extractor("raster_hough", refit=False, min_votes=15)
    off = []
    for _ in range(400):
        theta, d = rng.uniform(0, math.pi), rng.uniform(0.8, 2.5) * rng.choice([-1, 1])
        low = rng.uniform(-1.0, 0.0)
        scan = scan_of(wall(theta, d, low, low + 1.5), beams=721, view=2 * math.pi * 719 / 720)
        found = extractor(scan)
        assert len(found.lines) == 1
        # In the middle of the wall: where the angle of the bin does not matter.
        middle = np.mean(wall(theta, d, low, low + 1.5), axis=0)
        line = found_lines(found)[0]
        normal = np.array([math.cos(line[0]), math.sin(line[0])])
        ahead = np.sign(normal @ (math.cos(theta), math.sin(theta)))
        off.append((line[1] - middle @ normal) * ahead / 0.02)
    assert abs(np.mean(off)) < 0.06
    assert np.std(off) < 0.45


@pytest.mark.parametrize("refit", [False, True])
def test_repeats_of_a_line_go_that_opencv_reports(refit):
    rng = np.random.default_rng(1)
    repeats = 0
    for seed in range(10):
        world, pose = random_room(rng)
        scan, _ = look(world, sigma=0.005, seed=seed, beams=361, view=6.2, pose=pose)
        extractor = get_extractor("raster_hough", refit=refit, min_votes=12)
        lines = found_lines(extractor(scan))
        for k, line in enumerate(lines):
            errors = abs(line_errors(np.delete(lines, k, axis=0), line))
            assert not ((errors[:, 0] < math.radians(2.5)) & (errors[:, 1] < 0.03)).any()
        detector = extractor.detector
        drawn = detector._outline(detector.prepared(scan))
        raw, (x, y), cos, sin = detector._lines(draw(drawn, 0.02, detector._blur))
        row = np.round(raw[:8, 1] * 180 / math.pi).astype(int)
        first = np.stack([row * math.pi / 180, raw[:8, 0] * 0.02 + x * cos[row] + y * sin[row]], 1)
        for k in range(1, 8):
            errors = abs(line_errors(first[:k], first[k]))
            repeats += ((errors[:, 0] < math.radians(2.5)) & (errors[:, 1] < 0.08)).any()
    assert repeats > 20  # of the 80 first lines


def test_a_wall_goes_on_beyond_what_is_drawn():
    scan = scan_of(wall(math.pi / 2, 1.5, -9, 1), sigma=0.003, beams=721)
    drawn = get_extractor("raster_hough", max_range=4.0)(scan)
    assert len(drawn.lines) == 1
    assert drawn.segments.lengths[0] > 8.8


@pytest.mark.skipif(
    tuple(map(int, cv2.__version__.split(".")[:2])) < hough.WEIGHTED,
    reason="this OpenCV cannot weigh votes",
)
@needs_compiler
def test_a_blurred_image_has_the_same_walls():
    rng = np.random.default_rng(3)
    plain = get_extractor("raster_hough")
    for growth in (0.0, 0.002):
        blurred = get_extractor("raster_hough", blur=1.0, blur_growth=growth)
        world, pose = random_room(rng)
        scan, hit = look(world, sigma=0.005, beams=720, view=6.2, pose=pose)
        for k, truth in enumerate(true_lines(world, pose)):
            if (hit == k).sum() >= 15:
                for extractor in (plain, blurred):
                    near = nearest_line(found_lines(extractor(scan)), truth, 0.02, 0.03)
                    assert len(near) == 1


@pytest.fixture(scope="module")
def rooms():
    """Return features and (true line, its beams) of 120 rooms seen by 181 beams."""
    rng = np.random.default_rng(5)
    extractor = get_extractor("raster_hough", range_sigma=0.005)
    found = []
    for seed in range(120):
        world, pose = random_room(rng)
        scan, hit = look(world, sigma=0.005, seed=seed, beams=181, pose=pose)
        truth = true_lines(world, pose)
        beams = np.bincount(hit[hit >= 0], minlength=len(truth))
        found.append((extractor(scan), list(zip(truth, beams, strict=True))))
    return found


@needs_compiler
def test_walls_are_found_and_what_is_found_is_a_wall(rooms):
    true = hits = lines = right = 0
    for features, walls in rooms:
        for truth, beams in walls:
            if beams >= 8:
                true += 1
                near = nearest_line(found_lines(features), truth, math.radians(3), 0.05)
                hits += len(near) == 1
        for line in found_lines(features):
            lines += 1
            errors = [abs(line_errors(truth, line)) for truth, beams in walls if beams]
            right += any(e[0] < math.radians(6) and e[1] < 0.1 for e in errors)
    assert hits / true > 0.98
    assert right / lines > 0.98


@needs_compiler
def test_walls_are_measured_as_well_as_their_noise_lets_them_be(rooms):
    errors, inside = [], []
    for features, walls in rooms:
        for truth, beams in walls:
            near = nearest_line(found_lines(features), truth, math.radians(3), 0.05)
            if beams < 8 or len(near) != 1:
                continue
            line = found_lines(features)[near[0]]
            error = line_errors(line, truth)
            flip = np.diag([1, -1 if abs(line[0] - truth[0]) > 1 else 1])
            covariance = flip @ features.lines.covariance[near[0]] @ flip
            errors.append(error)
            inside.append(error @ np.linalg.solve(covariance, error) < CHI2_95)
    median = np.median(np.abs(errors), axis=0)
    assert median[0] < math.radians(0.07)
    assert median[1] < 0.0015
    assert 0.9 < np.mean(inside) < 0.98


def test_bins_have_the_covariance_of_their_cells():
    features = get_extractor("raster_hough", refit=False)(scan_of([(2, -1), (2, 1)], sigma=0.003))
    step = math.radians(1)
    expected = np.diag([step**2 / 12, 0.02**2 / 12])
    np.testing.assert_allclose(features.lines.covariance[0], expected, rtol=0.1, atol=3e-6)
    assert (features.lines.theta / step) % 1 == pytest.approx(0, abs=1e-9)


def test_both_arms_of_a_corner_and_their_crossing_are_found_in_the_bins_too():
    features = get_extractor("raster_hough", refit=False)(
        scan_of(*chain((2, -1.5), (2, 1.2), (-0.5, 1.2)), sigma=0.003)
    )
    assert len(features.lines) == 2
    np.testing.assert_allclose(features.corners.positions, [[2.0, 1.2]], atol=0.04)


@needs_recordings
@pytest.mark.parametrize("recording", RECORDINGS, ids=lambda r: r.path)
def test_recordings_are_no_trouble(recording):
    extractor = get_extractor("raster_hough")
    with open_source(DATA / recording.path) as scans:
        found = [extractor(scan) for scan, _ in zip(scans, range(3), strict=False)]
    assert any(len(features.lines) for features in found)
