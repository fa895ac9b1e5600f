"""What the image of a scan shows."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from laserfeatures_plugins.raster import size
from laserfeatures_plugins.raster.drawing import INK, Blur, draw
from laserfeatures_plugins.raster.outline import outline
from scenes import chain, look, poles, scan_of, wall

from laserfeatures import LaserScan
from laserfeatures.data import Pose2D
from laserfeatures.engine import WallDetector

PLAIN = {
    "resolution": 0.02,
    "max_pole_radius": 0.4,
    "max_range": 30.0,
    "min_incidence": math.radians(5),
    "max_missed": 3,
}


SHARP = Blur()


def outlined(scan, **parameters):
    return outline(WallDetector().prepared(scan), **{**PLAIN, **parameters})


def drawn(scan, resolution=0.02, blur=SHARP, margin=0, **parameters):
    return draw(outlined(scan, **parameters), resolution, blur, margin=margin)


def brightest(picture, x, y, reach=1):
    """Return the largest brightness of the pixels around a place [m]."""
    column = round((x - picture.x) / picture.resolution)
    row = round((y - picture.y) / picture.resolution)
    near = picture.image[max(row - reach, 0) : row + reach + 1, max(column - reach, 0) :][
        :, : 2 * reach + 1
    ]
    return near.max(initial=0)


def chains_of(scan, **parameters):
    """Return the chains that are drawn, as arrays of points."""
    x, y, points, ends, _ = outlined(scan, **parameters)
    return np.split(np.stack([x, y], axis=1)[points], ends[1:-1])


def test_a_wall_is_a_line_one_pixel_wide_where_it_is():
    picture = drawn(scan_of([(2, -1), (2, 1)], beams=721), margin=3)
    ink = picture.image > 0
    assert set(np.unique(picture.image)) == {0, INK}
    assert (ink.sum(axis=1)[4:-4] == 1).all()
    assert not ink[:3].any()
    assert not ink[:, -3:].any()
    columns = np.nonzero(ink)[1]
    assert picture.x + columns.mean() * 0.02 == pytest.approx(2.0, abs=0.002)
    assert picture.y + 3 * 0.02 == pytest.approx(-1.0, abs=0.02)


def test_a_corner_is_joined_and_the_edge_of_an_object_is_not():
    room = chain((2, -1.5), (2, 1.2), (-0.5, 1.2))
    assert len(chains_of(scan_of(*room, beams=181))) == 1
    # Just as near to each other as in the corner, one behind the other.
    edges = [[(2, -1.5), (2, 0.5)], [(2.3, 0.4), (2.3, 2)]]
    assert len(chains_of(scan_of(*edges, beams=181))) == 2


@pytest.mark.parametrize("sigma", [0.0, 0.005, 0.01])
def test_surfaces_are_told_apart_in_a_room_with_a_pillar(sigma):
    walls = [
        *chain((-4, -3), (4, -3), (4, 3), (-4, 3), (-4, -3)),
        *chain((1.5, 0.6), (2.1, 0.6), (2.1, 1.2), (1.5, 1.2), (1.5, 0.6)),
    ]
    for seed in range(10):
        pose = Pose2D(-1.0, 0.1 * seed - 1.0, 0.3)
        scan, hit = look(walls, sigma=sigma, seed=seed, beams=361, view=2 * math.pi, pose=pose)
        points = np.full((361, 2), np.nan)
        points[scan.beams] = scan.points
        object_of = {tuple(point): hit[k] >= 4 for k, point in enumerate(points)}
        for joined in chains_of(scan):
            assert len({object_of[tuple(point)] for point in joined}) == 1


def test_a_grazing_wall_is_joined():
    scan = scan_of(wall(math.pi / 2, 0.4, -6, 0), sigma=0.003, beams=361)
    assert max(len(c) for c in chains_of(scan)) > 0.95 * len(scan.points)


def test_a_line_goes_past_an_outlier_which_is_not_drawn():
    scan = scan_of([(2, -1), (2, 1)], sigma=0.003, beams=181)
    ranges = scan.ranges.copy()
    ranges[85], ranges[95] = 1.2, 2.9
    scan = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
    (joined,) = chains_of(scan)
    assert len(joined) == len(scan.points) - 2
    assert drawn(scan).image.shape[1] < 10


def test_beams_without_a_return_end_a_line_when_there_are_too_many():
    scan = scan_of([(2, -1), (2, 1)], sigma=0.003, beams=181)
    for missed, chains in ((3, 1), (4, 2)):
        ranges = scan.ranges.copy()
        ranges[90 : 90 + missed] = np.inf
        holed = LaserScan(angles=scan.angles, ranges=ranges, range_max=30.0)
        assert len(chains_of(holed)) == chains
        assert len(chains_of(holed, max_missed=5)) == 1


def test_poles_are_drawn_only_if_wanted():
    scan = poles((1.5, 0.8), (1.8, -0.7))
    assert drawn(scan) is None
    assert drawn(scan, max_pole_radius=0.0).image.any()


def test_what_is_far_is_not_drawn():
    scan = scan_of([(2, -1.5), (2, 0)], [(9, 1), (9, 3)], beams=361)
    assert drawn(scan).image.shape[1] > 300
    assert drawn(scan, max_range=5.0).image.shape[1] < 10


def test_nothing_to_draw_is_no_picture():
    alone = LaserScan.uniform([2.0, math.inf, math.inf, math.inf, math.inf, 3.0], -0.3, 0.1)
    assert drawn(alone) is None


def test_an_image_too_large_is_refused_with_its_numbers():
    square = chain((90, -90), (90, 90), (-90, 90), (-90, -90), (90, -90))
    scan = scan_of(*square, beams=1441, view=2 * math.pi, range_max=200.0)
    with pytest.raises(ValueError, match=r"180 m x 180 m .* 0.01 m has 324072004 pixels, more"):
        drawn(scan, resolution=0.01, max_range=math.inf)
    size.check_size(8000, 8000, 0.02)
    with pytest.raises(ValueError, match="64008000 pixels, more than 64000000: take a coarser"):
        size.check_size(8001, 8000, 0.02)


def test_a_thread_draws_into_its_buffer_again_and_no_other_does():
    large, small = scan_of([(2, -1), (2, 1)]), scan_of([(3, -0.5), (3, 0.5)])
    fresh = drawn(small).image.copy()
    first = drawn(large)
    second = drawn(small)
    assert np.shares_memory(first.image, second.image)
    np.testing.assert_array_equal(second.image, fresh)
    with ThreadPoolExecutor(1) as pool:
        other = pool.submit(drawn, small).result()
    assert not np.shares_memory(second.image, other.image)
    np.testing.assert_array_equal(second.image, other.image)


FAR_AND_NEAR = scan_of([(2, -1.5), (2, 0)], [(9, 1), (9, 5)], beams=1081)


@pytest.mark.parametrize("blur", [Blur(1.0), Blur(2.5), Blur(1.0, 0.005)])
def test_a_blurred_line_is_equally_bright_near_and_far(blur):
    picture = drawn(FAR_AND_NEAR, blur=blur, margin=20)
    for x, y in ((2, -1), (2, -0.4), (9, 2), (9, 3), (9, 4)):
        assert brightest(picture, x, y) == pytest.approx(blur.ridge, rel=0.08)


def width_at(picture, y, x):
    """Return the standard deviation [pixels] of the brightness across a wall."""
    row = round((y - picture.y) / picture.resolution)
    columns = np.arange(picture.image.shape[1]) - round((x - picture.x) / picture.resolution)
    weight = np.where(abs(columns) < 15, picture.image[row], 0).astype(float)
    return math.sqrt((weight * columns**2).sum() / weight.sum())


def test_the_blur_grows_with_range():
    picture = drawn(FAR_AND_NEAR, blur=Blur(1.0, 0.005), margin=20)
    assert width_at(picture, -1, 2) == pytest.approx(1 + 0.005 * 2.2 / 0.02, rel=0.2)
    assert width_at(picture, 3, 9) == pytest.approx(1 + 0.005 * 9.5 / 0.02, rel=0.2)
    even = drawn(FAR_AND_NEAR, blur=Blur(1.5), margin=20)
    assert width_at(even, -1, 2) == pytest.approx(1.5, rel=0.15)
    assert width_at(even, 3, 9) == pytest.approx(1.5, rel=0.15)
