import math
import time
from dataclasses import replace

import numpy as np
import pytest
import reference
from hypothesis import given
from hypothesis import strategies as st
from scenes import needs_compiler, segments_of

from laserfeatures import Intersections, Lines, LineSegments
from laserfeatures.intersections import MOST_LINES

seeds = st.integers(0, 10**6).map(np.random.default_rng)


def random_segments(rng):
    lines = int(rng.integers(0, 6))
    theta = rng.uniform(0, math.pi, lines)
    root = rng.normal(0, 0.02, (lines, 2, 2))
    pieces = []
    for k in rng.integers(0, max(lines, 1), rng.integers(0, 9) * (lines > 0)):
        low = rng.uniform(-4, 4)
        pieces.append((int(k), low, low + rng.uniform(0, 5), range(rng.integers(1, 9)), 0.01))
    d = rng.uniform(0.3, 4, lines) * rng.choice([-1, 1], lines)
    covariance = root @ root.swapaxes(1, 2)
    return segments_of(theta, d, pieces, covariance=covariance, evidence=rng.exponential(9, lines))


@given(
    seeds,
    st.sampled_from([0.0, 0.3, 1.0]),
    st.sampled_from([0.1, math.inf]),
    st.sampled_from([None, 5.0]),
)
def test_corners_are_those_of_the_twin(rng, min_angle, max_sigma, max_distance):
    segments = random_segments(rng)
    stage = Intersections(min_angle=min_angle, max_sigma=max_sigma, max_distance=max_distance)
    found = stage(segments)
    expected = reference.corners(segments, stage)
    assert [tuple(pair) for pair in found.lines.tolist()] == [e[2] for e in expected]
    for i, (position, spread, _, angle, real, evidence) in enumerate(expected):
        np.testing.assert_allclose(found.positions[i], position, atol=1e-9)
        scale = np.abs(spread).max()
        np.testing.assert_allclose(found.covariance[i], spread, rtol=1e-4, atol=1e-4 * scale)
        assert found.angles[i] == pytest.approx(angle, abs=1e-7)
        assert found.real[i] == real
        assert found.evidence[i] == pytest.approx(evidence, abs=1e-3)


def right_angle(first=(-1.0, 1.0), second=(-1.0, 1.0), spread=1e-6):
    """Return the walls x = 2 and y = 1, which cross at (2, 1); pieces are measured from there."""
    pieces = [
        (0, 1 + first[0], 1 + first[1], range(20), 0.01),
        (1, -2 + second[0], -2 + second[1], range(20, 40), 0.01),
    ]
    covariance = np.tile(np.diag([spread, spread]), (2, 1, 1))
    return segments_of([0.0, math.pi / 2], [2.0, 1.0], pieces, covariance=covariance)


def test_a_corner_is_where_two_lines_cross():
    corners = Intersections()(right_angle())
    np.testing.assert_allclose(corners.positions, [[2.0, 1.0]], atol=1e-12)
    np.testing.assert_allclose(corners.angles, [math.pi / 2])
    assert corners.lines.tolist() == [[0, 1]]


@pytest.mark.parametrize(
    ("first", "second", "real"),
    [
        ((-1.0, 1.0), (-1.0, 1.0), True),  # both hold it
        ((-1.0, 0.0), (-1.0, 0.0), True),  # both end there
        ((-1.0, -0.04), (-1.0, 0.0), True),  # ends within reach
        ((-1.0, -0.9), (-1.0, 0.0), False),  # one wall ends before it
        ((-1.0, 0.0), (-3.0, -2.5), False),
        ((0.9, 1.5), (0.9, 1.5), False),
    ],
)
def test_a_corner_is_real_where_both_lines_have_a_segment_that_reaches_it(first, second, real):
    assert Intersections()(right_angle(first, second)).real.tolist() == [real]


def test_a_wall_of_few_beams_reaches_as_far_as_its_beams_are_apart():
    # Three beams on a metre of wall: the next would hit the wall 0.57 m on.
    walls = segments_of(
        [0.0, math.pi / 2], [2.0, 1.0], [(0, -0.5, 0.5, range(3), 0.01), (1, -2.5, -2, range(9), 0)]
    )
    assert Intersections().reach < 0.5
    assert Intersections()(walls).real.tolist() == [True]


def corridor(length=14.3, beams=87):
    """Return a wall 1 m aside, seen up to `length` by so many beams, and one across at 18 m."""
    pieces = [(0, -length, 0.0, range(beams), 0.01), (1, -0.94, 0.94, range(beams, beams + 7), 0)]
    return segments_of([math.pi / 2, 0.0], [1.0, 18.0], pieces)


def test_the_corner_at_the_end_of_a_corridor_is_real_as_no_beam_passes_before_it():
    # The last beam on the wall aside meets it at 14.3 m, the next would at 19.1 m.
    assert Intersections()(corridor()).real.tolist() == [True]


@pytest.mark.parametrize(
    ("walls", "why"),
    [
        (corridor(12.0, 86), "the next beam would have met the wall at 15.2 m"),
        (corridor(14.3, 174), "with a beam each half a degree the next would have at 16.3 m"),
    ],
)
def test_a_wall_that_a_beam_would_have_met_ends_before_the_corner(walls, why):
    assert Intersections()(walls).real.tolist() == [False], why


def test_a_grazing_wall_goes_on_for_at_most_half_of_what_was_seen_of_it():
    # Two beams meet it at 8 m and 10 m, a decimetre aside; the next would at 13.3 m.
    for at, real in ((10.9, True), (11.1, False)):
        pieces = [(0, -10.0, -8.0, range(2), 0.01), (1, -1.0, 1.0, range(2, 20), 0.01)]
        walls = segments_of([math.pi / 2, 0.0], [0.1, at], pieces)
        assert Intersections(reach=0.0)(walls).real.tolist() == [real]


@pytest.mark.parametrize(("sigma", "real"), [(0.0, False), (0.09, False), (0.11, True)])
def test_two_standard_deviations_of_a_corner_along_a_wall_make_it_reach(sigma, real):
    # The wall y = 1 ends 0.2 m before x = 2, whose distance is unsure; its beams are close.
    pieces = [(0, 0.0, 2.0, range(20), 0.01), (1, -1.8, 0.2, range(20, 2020), 0.01)]
    covariance = np.zeros((2, 2, 2))
    covariance[0, 1, 1] = sigma**2
    walls = segments_of([0.0, math.pi / 2], [2.0, 1.0], pieces, covariance=covariance)
    assert Intersections(reach=0.0)(walls).real.tolist() == [real]


@pytest.mark.parametrize("unknown", [math.nan, math.inf])
def test_a_covariance_that_tells_nothing_makes_no_corner_real(unknown):
    for first, real in (((-1.0, 0.0), True), ((-1.0, -0.4), False)):
        walls = right_angle(first, (-1.0, 0.0), spread=unknown)
        with np.errstate(invalid="ignore"):  # Python tells, where nothing is compiled
            corners = Intersections(max_sigma=math.inf)(walls)
        assert corners.real.tolist() == [real]


@given(seeds, st.sampled_from([0.1, 10.0]))
def test_what_is_scaled_with_all_limits_has_the_same_corners_scaled(rng, factor):
    segments = random_segments(rng)
    stage = Intersections(max_distance=5.0, max_sigma=0.5)
    scaled = Intersections(max_distance=5 * factor, max_sigma=0.5 * factor, reach=0.05 * factor)
    corners, others = stage(segments), scaled(times(segments, factor))
    assert others.lines.tolist() == corners.lines.tolist()
    assert others.real.tolist() == corners.real.tolist()
    np.testing.assert_allclose(others.positions, factor * corners.positions, atol=1e-9)
    spread = factor**2 * corners.covariance
    np.testing.assert_allclose(others.covariance, spread, atol=1e-9 * factor**2)


def times(segments, factor):
    """Return segments with all lengths times a factor."""
    lines = segments.lines
    unit = np.array([1.0, factor])  # theta stays
    lines = replace(lines, d=factor * lines.d, covariance=lines.covariance * np.outer(unit, unit))
    return replace(
        segments, lines=lines, endpoints=factor * segments.endpoints, rms=factor * segments.rms
    )


def test_corners_beyond_max_distance_are_dropped():
    distance = math.hypot(2, 1)
    assert len(Intersections(max_distance=distance + 0.01)(right_angle())) == 1
    assert len(Intersections(max_distance=distance - 0.01)(right_angle())) == 0


def test_without_max_distance_the_limit_of_the_scan_counts_if_it_is_given():
    distance = math.hypot(2, 1)  # twice the limit
    assert len(Intersections()(right_angle())) == 1
    assert len(Intersections()(right_angle(), limit=distance / 2 + 0.01)) == 1
    assert len(Intersections()(right_angle(), limit=distance / 2 - 0.01)) == 0
    assert len(Intersections(max_distance=3.0)(right_angle(), limit=0.1)) == 1
    assert len(Intersections(max_distance=math.inf)(right_angle(), limit=0.1)) == 1


@pytest.mark.parametrize("limit", [0.0, math.nan])
def test_a_limit_that_is_none_is_refused(limit):
    with pytest.raises(ValueError, match=f"limit must be > 0 m, got {limit}"):
        Intersections()(right_angle(), limit=limit)


def evidence_of(*evidence, spread=1e-6, **limits):
    """Return the evidence of the corner of two walls that have theirs."""
    walls = right_angle(spread=spread)
    evident = replace(walls, lines=replace(walls.lines, evidence=evidence))
    (found,) = Intersections(**limits)(evident).evidence
    return found


def test_a_corner_is_the_more_evident_the_more_its_lines_are_the_weaker_twice_as_much():
    assert evidence_of(9.0, 4.0) == evidence_of(4.0, 9.0)
    assert evidence_of(9.0, 4.0) - evidence_of(9.0, 1.0) == pytest.approx(math.log(4))
    assert evidence_of(9.0, 1.0) - evidence_of(4.0, 1.0) == pytest.approx(math.log(1.5))


def test_the_evidence_of_a_corner_is_its_formula():
    # Offsets at the corner (2, 1) have the variance spread (1 + along^2): 2 and 5 spreads.
    sigma = math.sqrt(5e-6)
    odds = 0.5 * 10.0**2 / sigma**2 * 4.0 * math.sqrt(9.0)
    assert evidence_of(9.0, 4.0, max_distance=10.0) == pytest.approx(math.log(odds))


@pytest.mark.parametrize(
    ("first", "second", "gap"),
    [
        ((-1.0, 1.0), (-3.0, -2.5), 0.0),  # one holds it
        ((-1.0, -0.4), (0.3, 1.3), 0.3),  # the nearer end counts
        ((0.7, 1.0), (-3.0, -2.5), 0.7),
    ],
)
def test_a_corner_that_no_wall_reaches_is_less_evident(first, second, gap):
    def found(*pieces):
        walls = right_angle(*pieces)
        evident = replace(walls, lines=replace(walls.lines, evidence=[9.0, 4.0]))
        return Intersections(max_distance=10.0)(evident).evidence[0]

    sigma = math.sqrt(5e-6)
    less = found((-1.0, 1.0), (-1.0, 1.0)) - found(first, second)
    assert less == pytest.approx(math.log((gap + sigma) / sigma), abs=1e-9)


def test_a_corner_of_lines_without_segments_has_no_evidence():
    covariance = np.tile(np.diag([1e-6, 1e-6]), (3, 1, 1))
    walls = segments_of(
        [0.0, math.pi / 2, 1.0],
        [2.0, 1.0, 5.0],
        [(2, -1.0, 1.0, range(9), 0.01)],
        covariance=covariance,
        evidence=[9.0, 9.0, 9.0],
    )
    corners = Intersections()(walls)
    assert corners.lines.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert corners.evidence[0] == 0.0
    assert (corners.evidence[1:] > 0.0).all()


@pytest.mark.parametrize("spread", [0.0, math.nan, math.inf])
def test_a_corner_whose_covariance_tells_nothing_is_as_evident_as_the_weaker_line(spread):
    with np.errstate(invalid="ignore"):  # Python tells, where nothing is compiled
        assert evidence_of(9.0, 4.0, spread=spread, max_sigma=math.inf) == 4.0


def test_a_corner_is_the_more_evident_the_better_its_place_is_known():
    assert evidence_of(4.0, 4.0, spread=1e-6) - evidence_of(4.0, 4.0, spread=1e-4) == (
        pytest.approx(math.log(100), abs=1e-9)
    )
    near, far = (evidence_of(4.0, 4.0, max_distance=limit) for limit in (10.0, 20.0))
    assert far - near == pytest.approx(2 * math.log(2))


def test_a_corner_of_a_line_without_evidence_has_none():
    assert evidence_of(9.0, 0.0) == 0.0
    assert Intersections()(right_angle()).evidence.tolist() == [0.0]


@pytest.mark.parametrize(("turn", "corners"), [(14.9, 0), (15.1, 1), (164.9, 1), (165.1, 0)])
def test_lines_that_cross_at_less_than_min_angle_have_no_corner(turn, corners):
    pieces = [(0, -1.0, 1.0, range(9), 0.01), (1, -1.0, 1.0, range(9, 18), 0.01)]
    walls = segments_of([0.1, 0.1 + math.radians(turn)], [0.5, 0.6], pieces)
    assert len(Intersections()(walls)) == corners


def test_parallel_lines_have_no_corner_even_at_min_angle_0():
    pieces = [(0, -1.0, 1.0, range(9), 0.01), (1, -1.0, 1.0, range(9, 18), 0.01)]
    walls = segments_of([1.0, 1.0], [0.5, 1.6], pieces)
    assert len(Intersections(min_angle=0.0)(walls)) == 0


def test_uncertain_corners_are_withheld():
    # Each line's offset at the corner has the variance spread * (1 + along^2): 2 and 5.
    walls = right_angle(spread=0.01)
    assert len(Intersections(max_sigma=math.sqrt(0.051))(walls)) == 1
    assert len(Intersections(max_sigma=math.sqrt(0.049))(walls)) == 0


def fan(count):
    """Return lines that touch a circle of 5 m, with a segment each."""
    theta = np.linspace(0, math.pi, count, endpoint=False)
    across = np.stack([np.cos(theta), np.sin(theta)], axis=1)
    along = np.stack([-across[:, 1], across[:, 0]], axis=1)
    lines = Lines(
        theta=theta, d=np.full(count, 5.0), support=np.full(count, 9),
        covariance=np.tile(np.diag([1e-6, 1e-6]), (count, 1, 1)), evidence=np.full(count, 9.0),
    )  # fmt: skip
    ends = np.stack([5 * across - 0.1 * along, 5 * across + 0.1 * along], axis=1)
    numbers = np.arange(count)
    return LineSegments(
        lines=lines, line=numbers, endpoints=ends, support=np.full(count, 9),
        rms=np.full(count, 0.01), points=np.zeros((count, 1), bool),
    )  # fmt: skip


@needs_compiler
def test_each_pair_of_many_lines_is_looked_at_by_its_own_segments_alone():
    Intersections()(fan(3))  # compiled
    start = time.process_time()
    assert len(Intersections(min_angle=0.0)(fan(2400))) > 1_000_000
    assert time.process_time() - start < 2.5  # 7 s, were all segments looked at


def test_more_lines_than_memory_has_room_for_are_refused():
    count = MOST_LINES + 1
    with pytest.raises(ValueError, match=f"at most {MOST_LINES} lines to cross.*, got {count}"):
        Intersections()(fan(count))


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"max_distance": 0.0}, r"max_distance must be > 0 m, got 0\.0"),
        ({"max_sigma": -1.0}, r"max_sigma must be > 0 m, got -1\.0"),
        ({"min_angle": math.pi / 2}, r"min_angle must be in \[0, pi/2\) rad, got 1\.57"),
        ({"min_angle": -0.1}, r"min_angle must be in \[0, pi/2\) rad, got -0\.1"),
        ({"reach": -0.1}, r"reach must be >= 0 m, got -0\.1"),
    ],
)
def test_wrong_parameters_are_named_with_their_limits(parameters, message):
    with pytest.raises(ValueError, match=message):
        Intersections(**parameters)
