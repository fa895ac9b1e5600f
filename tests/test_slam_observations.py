"""What of a scan's features becomes a measurement, and how uncertain it is."""

import math

import numpy as np
import pytest
from scenes import line_errors, scan_of, wall

from laserfeatures import Features, Lines, LineSegments, PointFeatures, get_extractor
from laserfeatures.slam.association import worth
from laserfeatures.slam.kinds import CORNER, WALL
from laserfeatures.slam.observations import LEAST_WORTH, TWICE, observations_of

ROUGH = 0.03


def features_of(*endpoints, corners=(), corner_deviation=0.01):
    """Return features of some walls along x = 2, each a list of pieces, and of some corners."""
    walls = len(endpoints)
    pieces = [(i, piece) for i, some in enumerate(endpoints) for piece in some]
    lines = Lines(
        theta=np.zeros(walls),
        d=np.full(walls, 2.0),
        support=np.full(walls, 10.0),
        covariance=np.tile(np.diag([1e-6, 1e-6]), (walls, 1, 1)),
    )
    segments = LineSegments(
        lines=lines,
        line=[i for i, _ in pieces],
        endpoints=np.array([[(2.0, y) for y in piece] for _, piece in pieces]).reshape(-1, 2, 2),
        support=np.full(len(pieces), 10.0),
        rms=np.zeros(len(pieces)),
        points=np.zeros((len(pieces), 3), dtype=bool),
    )
    count = len(corners)
    points = PointFeatures(
        positions=np.array(corners).reshape(-1, 2),
        covariance=np.tile(corner_deviation**2 * np.eye(2), (count, 1, 1)),
        lines=np.full((count, 2), -1),
        angles=np.full(count, 1.0),
        real=np.ones(count, dtype=bool),
    )
    scan = scan_of(wall(0.0, 2.0, -1.0, 1.0), beams=3)
    return Features(scan=scan, segments=segments, corners=points)


@pytest.mark.parametrize(
    ("corners", "walls", "kinds"),
    [(True, True, [CORNER, WALL]), (True, False, [CORNER]), (False, True, [WALL])],
)
def test_only_the_kinds_that_are_wanted_are_measured(corners, walls, kinds):
    features = features_of([(-1.0, 1.0)], corners=[(2.0, 1.0)])
    found = observations_of(features, corners=corners, walls=walls, roughness=ROUGH)
    assert [seen.kind for seen in found] == kinds
    assert [len(seen) for seen in found] == [1] * len(kinds)


def test_corners_have_the_extractors_covariance_and_the_roughness():
    features = features_of(corners=[(2.0, 1.0), (3.0, -1.0)])
    alone = observations_of(features, corners=True, walls=False, roughness=ROUGH)[0]
    np.testing.assert_array_equal(alone.values, [(2.0, 1.0), (3.0, -1.0)])
    np.testing.assert_allclose(alone.noise, np.tile((0.01**2 + ROUGH**2) * np.eye(2), (2, 1, 1)))
    np.testing.assert_array_equal(alone.extents[1], [(3.0, -1.0), (3.0, -1.0)])
    both = observations_of(features, corners=True, walls=True, roughness=ROUGH)[0]
    np.testing.assert_allclose(both.noise, TWICE * alone.noise)


@pytest.mark.parametrize(("low", "high"), [(-2.0, 2.0), (1.0, 4.0), (-4.0, -3.0)])
def test_a_wall_that_is_rough_at_either_end_tilts_about_its_middle(low, high):
    """Against many walls whose ends are off, and as a whole."""
    rng = np.random.default_rng(1)
    trials = 20_000
    ends = ROUGH * rng.normal(size=(trials, 2))
    theta = (ends[:, 0] - ends[:, 1]) / (high - low)  # of the normal, to first order
    middle = (low + high) / 2
    d = middle * theta + ROUGH * rng.normal(size=trials)
    wanted = np.cov(theta, d)
    features = features_of([(low, high)])
    seen = observations_of(features, corners=False, walls=True, roughness=ROUGH)[0]
    np.testing.assert_allclose(seen.noise[0] - 1e-6 * np.eye(2), wanted, rtol=0.05, atol=1e-5)


def test_a_wall_in_pieces_reaches_from_end_to_end():
    features = features_of([(0.0, -1.0), (2.0, 3.0), (1.0, 1.5)])
    seen = observations_of(features, corners=False, walls=True, roughness=0.0)[0]
    assert sorted(seen.extents[0, :, 1].tolist()) == [-1.0, 3.0]
    np.testing.assert_array_equal(seen.extents[0, :, 0], 2.0)


def test_what_is_too_vague_to_be_recognised_is_left_out():
    sharp = features_of(corners=[(2.0, 1.0)], corner_deviation=0.02)
    vague = features_of(corners=[(2.0, 1.0)], corner_deviation=0.5)
    assert worth(np.array([0.5**2 * np.eye(2)]))[0] < LEAST_WORTH
    counts = [
        len(observations_of(features, corners=True, walls=False, roughness=0.0)[0])
        for features in (sharp, vague)
    ]
    assert counts == [1, 0]


def test_an_empty_scan_has_nothing_to_measure():
    found = observations_of(features_of(), corners=True, walls=True, roughness=ROUGH)
    assert [seen.values.shape for seen in found] == [(0, 2), (0, 2)]
    assert [seen.extents.shape for seen in found] == [(0, 2, 2), (0, 2, 2)]


def test_a_scan_of_a_corner_gives_it_and_its_walls():
    scan = scan_of(wall(0.0, 3.0, -2.0, 2.0), wall(math.pi / 2, 2.0, -3.0, 1.0))
    seen = observations_of(
        get_extractor("direct_hough")(scan), corners=True, walls=True, roughness=ROUGH
    )
    np.testing.assert_allclose(seen[0].values, [(3.0, 2.0)], atol=0.01)
    wanted = np.array([(0.0, 3.0), (math.pi / 2, 2.0)])
    errors = abs(line_errors(seen[1].values[:, None], wanted[None])).max(axis=2)
    assert errors.argmin(axis=1).tolist() in ([0, 1], [1, 0])
    assert errors.min(axis=1).max() < 0.01
