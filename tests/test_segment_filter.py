import math
import time
from dataclasses import replace

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import needs_compiler, segments_of

from laserfeatures import Lines, LineSegments, SegmentFilter

seeds = st.integers(0, 10**6).map(np.random.default_rng)


def random_segments(rng):
    """Return segments on lines that are near to each other, so that many are copies."""
    lines = int(rng.integers(1, 6))
    theta = rng.choice([0.4, 0.45, 0.7, 2.0], lines) + rng.normal(0, 0.01, lines)
    d = 2.0 + rng.choice([0.0, 1.5], lines) + rng.normal(0, 0.05, lines)
    pieces = []
    for _ in range(rng.integers(0, 9)):
        low = rng.uniform(-2, 2)
        first, last = np.sort(rng.integers(0, 30, 2))
        pieces.append(
            (
                int(rng.integers(lines)),
                low,
                low + rng.uniform(0.1, 2.0),
                range(first, last + 1),
                rng.uniform(0, 0.2),
            )
        )
    return segments_of(theta, d, pieces, evidence=rng.exponential(9, lines))


@given(seeds, st.sampled_from([0.0, 5.0]))
def test_filter_keeps_what_its_twin_keeps(rng, min_evidence):
    segments = random_segments(rng)
    stage = SegmentFilter(copy_distance=0.1, min_evidence=min_evidence)
    stay = reference.reliable(segments, stage)
    kept = stage(segments)
    used = sorted(set(segments.line[stay].tolist()))
    np.testing.assert_array_equal(kept.points, segments.points[stay])
    np.testing.assert_array_equal(kept.endpoints, segments.endpoints[stay])
    np.testing.assert_array_equal(kept.support, segments.support[stay])
    np.testing.assert_array_equal(kept.rms, segments.rms[stay])
    np.testing.assert_array_equal(kept.lines.theta, segments.lines.theta[used])
    np.testing.assert_array_equal(kept.lines.d, segments.lines.d[used])
    np.testing.assert_array_equal(kept.lines.support, segments.lines.support[used])
    np.testing.assert_array_equal(kept.lines.covariance, segments.lines.covariance[used])
    np.testing.assert_array_equal(kept.lines.evidence, segments.lines.evidence[used])
    np.testing.assert_array_equal(
        kept.lines.theta[kept.line], segments.lines.theta[segments.line[stay]]
    )


@given(seeds)
def test_filter_of_the_filtered_changes_nothing(rng):
    once = SegmentFilter()(random_segments(rng))
    assert SegmentFilter()(once) is once


def two_walls(*, d=2.0, apart=0.05, turn=0.0, beams=(range(9), range(10, 18)), low=0.0):
    pieces = [(0, 0.0, 1.0, beams[0], 0.01), (1, low, low + 1.0, beams[1], 0.01)]
    return segments_of([1.0, 1.0 + turn], [d, d + apart], pieces)


def test_of_two_copies_the_one_with_fewer_points_goes():
    assert SegmentFilter()(two_walls()).support.tolist() == [9]
    swapped = two_walls(beams=(range(8), range(10, 19)))
    assert SegmentFilter()(swapped).lines.d.tolist() == [2.05]


def test_of_two_copies_with_as_many_points_the_one_of_larger_error_goes():
    even = two_walls(beams=(range(9), range(10, 19)))
    assert SegmentFilter()(even).lines.d.tolist() == [2.0]
    assert SegmentFilter()(replace(even, rms=[0.02, 0.01])).lines.d.tolist() == [2.05]


@pytest.mark.parametrize(
    "walls",
    [
        {"apart": 1.5},  # the walls of a corridor
        {"low": 0.6},  # ends that overlap by less than half
        {"turn": 0.4},  # walls that cross
    ],
)
def test_walls_that_are_not_copies_stay(walls):
    assert len(SegmentFilter()(two_walls(**walls))) == 2


def test_segments_that_share_half_of_their_points_are_copies_wherever_they_lie():
    shared = two_walls(apart=1.5, beams=(range(9), range(5, 13)))
    assert SegmentFilter()(shared).support.tolist() == [9]
    less = two_walls(apart=1.5, beams=(range(9), range(6, 13)))
    assert len(SegmentFilter()(less)) == 2


def test_two_segments_of_one_line_are_no_copies():
    segments = segments_of(
        [1.0], [2.0], [(0, 0.0, 1.0, range(9), 0.01), (0, 0.1, 0.9, range(9), 0.01)]
    )
    assert len(SegmentFilter()(segments)) == 2


def test_min_points_and_max_error_are_met_by_equality():
    segments = segments_of([1.0], [2.0], [(0, 0.0, 1.0, range(4), 0.15)])
    assert len(SegmentFilter(min_points=4, max_error=0.15)(segments)) == 1
    assert len(SegmentFilter(min_points=5)(segments)) == 0
    assert len(SegmentFilter(max_error=0.149)(segments)) == 0


def test_a_line_of_less_than_min_evidence_goes_with_all_its_segments():
    pieces = [(0, 0.0, 1.0, range(9), 0.01), (0, 3.0, 4.0, range(9, 18), 0.01)]
    pieces.append((1, 0.0, 1.0, range(18, 27), 0.01))
    segments = segments_of([1.0, 2.0], [2.0, 3.0], pieces, evidence=[5.0, 6.0])
    assert SegmentFilter(min_evidence=5.0)(segments) is segments
    kept = SegmentFilter(min_evidence=5.5)(segments)
    assert kept.lines.evidence.tolist() == [6.0]
    assert kept.line.tolist() == [0]
    assert len(SegmentFilter(min_evidence=math.inf)(segments)) == 0


def test_a_line_that_goes_for_its_evidence_takes_no_copy_with_it():
    walls = two_walls(beams=(range(9), range(10, 18)))
    doubtful = replace(walls, lines=replace(walls.lines, evidence=[1.0, 2.0]))
    assert SegmentFilter()(doubtful).lines.d.tolist() == [2.0]
    assert SegmentFilter(min_evidence=2)(doubtful).lines.d.tolist() == [2.05]


def test_lines_without_segments_go():
    segments = segments_of([0.5, 1.0, 2.0], [1.0, 2.0, 3.0], [(2, 0.0, 1.0, range(9), 0.01)])
    kept = SegmentFilter()(segments)
    assert kept.lines.d.tolist() == [3.0]
    assert kept.line.tolist() == [0]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"min_points": 0}, "min_points must be >= 1, got 0"),
        ({"max_error": 0.0}, r"max_error must be > 0 m, got 0\.0"),
        ({"max_error": math.nan}, "max_error must be > 0 m, got nan"),
        ({"min_angle": -0.1}, r"min_angle must be in \[0, pi/2\] rad, got -0\.1"),
        ({"min_angle": 1.6}, r"min_angle must be in \[0, pi/2\] rad, got 1\.6"),
        ({"copy_distance": -1.0}, r"copy_distance must be >= 0 m, got -1\.0"),
        ({"min_evidence": -1.0}, r"min_evidence must be >= 0, got -1\.0"),
        ({"min_evidence": math.nan}, "min_evidence must be >= 0, got nan"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        SegmentFilter(**parameters)


@needs_compiler
def test_walls_of_few_beams_each_are_compared_by_those_beams_alone():
    """Pairs of segments are many: to look at all beams for each took 25 s for 60,000 beams."""
    count, beams = 2000, 32_000
    away = 2.0 + np.arange(count)
    lines = Lines(
        theta=np.full(count, 1.0), d=away, support=np.full(count, 16),
        covariance=np.tile(np.eye(2), (count, 1, 1)), evidence=np.full(count, 9.0),
    )  # fmt: skip
    across, along = np.array([math.cos(1.0), math.sin(1.0)]), np.array([-math.sin(1.0), 1.0])
    foot = away[:, None] * across
    walls = LineSegments(
        lines=lines, line=np.arange(count), endpoints=np.stack([foot, foot + along], axis=1),
        support=np.full(count, 16), rms=np.full(count, 0.01),
        points=np.arange(count)[:, None] == np.arange(beams) // 16,
    )  # fmt: skip
    SegmentFilter()(two_walls())  # compiled
    start = time.process_time()
    assert SegmentFilter()(walls) is walls
    assert time.process_time() - start < 2.0
