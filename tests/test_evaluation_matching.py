"""One-to-one matching of corners by distance, and of lines by their beams."""

import math
import re
import subprocess
import sys

import numpy as np
import pytest
import reference_evaluation as twins
from hypothesis import given
from hypothesis import strategies as st
from scenes import segments_of

from laserfeatures import LineSegments, MissingDependencyError
from laserfeatures.evaluation import Truth, match_corners, match_lines
from laserfeatures.optional import install_line

seeds = st.integers(0, 10**6).map(np.random.default_rng)
NOWHERE = np.empty((0, 2))


def some_points(rng):
    """Return points, of which many are as far from each other as others or as the gate."""
    points = rng.integers(0, 5, (rng.integers(0, 6), 2)) / 4
    return points + rng.choice([0.0, 1e-3]) * rng.normal(size=points.shape)


def total(found, true, pairs):
    return np.hypot(*(found[pairs[0]] - true[pairs[1]]).T).sum()


@given(seeds, st.sampled_from([0.25, 0.3, 0.5, 0.6, 2.0]))
def test_corners_are_paired_as_the_twin_that_tries_all_pairings_does(rng, gate):
    found, true = some_points(rng), some_points(rng)
    rows, columns = match_corners(found, true, gate)
    gaps = np.array([[math.dist(f, t) for t in true] for f in found]).reshape(len(found), len(true))
    pairs, least = twins.best_pairs(gaps, gaps <= gate)
    assert len(rows) == len(columns) == len(set(rows)) == len(set(columns)) == pairs
    assert total(found, true, (rows, columns)) == pytest.approx(least)
    assert (gaps[rows, columns] <= gate).all()


@given(seeds, st.sampled_from([0.25, 0.6]))
def test_matching_is_symmetric(rng, gate):
    found, true = some_points(rng), some_points(rng)
    there, back = match_corners(found, true, gate), match_corners(true, found, gate)
    assert len(there[0]) == len(back[0])
    assert total(found, true, there) == pytest.approx(total(true, found, back))


def test_more_pairs_come_before_nearer_pairs():
    # The nearest pair, 0 with 0, would leave the others without: they are 0.38 m apart.
    found, true = np.array([(0.0, 0), (-0.19, 0)]), np.array([(0.0, 0), (0.19, 0)])
    assert [p.tolist() for p in match_corners(found, true)] == [[0, 1], [1, 0]]


@pytest.mark.parametrize(("gap", "pairs"), [(0.25, 1), (np.nextafter(0.25, 1), 0), (0.0, 1)])
def test_the_gate_is_the_largest_distance_of_a_pair(gap, pairs):
    found = np.array([(gap, 0.0)])
    assert len(match_corners(found, np.zeros((1, 2)), 0.25)[0]) == pairs


@pytest.mark.parametrize(("gap", "pairs"), [(0.199, 1), (0.201, 0)])
def test_the_gate_is_twenty_centimetres_unless_told(gap, pairs):
    assert len(match_corners(np.array([(1, 2 + gap)]), np.array([(1.0, 2)]))[0]) == pairs


@pytest.mark.parametrize(("found", "true"), [(0, 0), (0, 3), (3, 0)])
def test_without_corners_there_are_no_pairs(found, true):
    pairs = match_corners(np.zeros((found, 2)), np.zeros((true, 2)))
    assert [p.size for p in pairs] == [0, 0]


def test_a_corner_that_is_nowhere_matches_nothing():
    found = np.array([(math.nan, 0), (math.inf, 0), (0, 0)])
    assert [p.tolist() for p in match_corners(found, np.zeros((2, 2)))] in ([[2], [0]], [[2], [1]])


@pytest.mark.parametrize("gate", [0.0, -0.2, math.inf, math.nan])
def test_a_gate_that_is_no_distance_is_refused(gate):
    with pytest.raises(ValueError, match=rf"^gate must be > 0 m and finite, got {gate!r}$"):
        match_corners(NOWHERE, NOWHERE, gate)


def truth_on(line, count=None):
    """Return a truth of which only the beams of each line matter."""
    count = 1 + max(line) if count is None else count
    return Truth(
        theta=np.linspace(0, 3, count),
        d=np.ones(count),
        line=line,
        corners=NOWHERE,
        pairs=NOWHERE,
        real=np.empty(0, bool),
    )


def segments_with(points, line=None):
    """Return segments that hold these beams (S, N), each on its own line if not told."""
    points = np.asarray(points, bool)
    line = np.arange(len(points)) if line is None else line
    lines = 1 + max(line, default=-1)
    made = segments_of(np.zeros(lines), np.ones(lines), [(k, 0, 1, [], 0.0) for k in line])
    return LineSegments(
        lines=made.lines,
        line=made.line,
        endpoints=made.endpoints,
        support=points.sum(axis=1),
        rms=made.rms,
        points=points,
    )


def match(points, true_line, line=None):
    wall, duplicates = match_lines(segments_with(points, line), truth_on(true_line))
    return wall.tolist(), duplicates


@given(seeds)
def test_lines_are_paired_as_the_twin_that_tries_all_pairings_does(rng):
    beams, walls = rng.integers(1, 9), rng.integers(0, 5)
    segment_line = np.sort(np.r_[np.arange(3), rng.integers(0, 3, 2)])[: rng.integers(0, 6)]
    lines = 1 + max(segment_line, default=-1)
    points = rng.random((len(segment_line), beams)) < 0.5
    truth = truth_on(rng.integers(-1, walls, beams), walls)
    wall, duplicates = match_lines(segments_with(points, segment_line), truth)
    held = [set(np.argwhere(points[segment_line == k])[:, 1]) for k in range(lines)]
    shared = np.array(
        [[sum(truth.line[b] == w for b in beams_of) for w in range(walls)] for beams_of in held]
    ).reshape(lines, walls)
    sizes = np.array([len(beams_of) for beams_of in held])
    allowed = (shared > 0) & (shared >= sizes[:, None] / 2)
    pairs, least = twins.best_pairs(-1.0 * shared, allowed)
    mine = np.flatnonzero(wall >= 0)
    assert len(set(wall[mine])) == len(mine) == pairs
    assert allowed[mine, wall[mine]].all()
    assert shared[mine, wall[mine]].sum() == -least
    assert duplicates == allowed.any(axis=1).sum() - pairs


def test_of_two_lines_on_one_wall_that_with_more_beams_has_it():
    line = [0] * 6
    assert match([[1, 1, 0, 0, 0, 0], [0, 0, 1, 1, 1, 1]], line) == ([-1, 0], 1)


def test_a_line_of_several_segments_counts_each_beam_of_all_once():
    true_line = [0, 0, 1, 1, 1]
    twice = [[1, 1, 0, 0, 0], [1, 1, 0, 0, 0], [0, 0, 1, 1, 1]]
    assert match(twice, true_line, line=[0, 0, 0]) == ([1], 0)
    assert match(twice, true_line, line=[0, 0, 1]) == ([0, 1], 0)


@pytest.mark.parametrize(("own", "strange", "wall"), [(3, 3, 0), (3, 4, -1), (1, 0, 0), (0, 4, -1)])
def test_half_of_a_lines_points_must_be_of_its_wall(own, strange, wall):
    # The others show nothing true.
    line = [0] * 4 + [-1] * 4
    points = [[1] * own + [0] * (4 - own) + [1] * strange + [0] * (4 - strange)]
    assert match(points, line) == ([wall], 0)


def test_a_line_across_two_walls_takes_that_which_no_other_has():
    line = [0, 0, 0, 1, 1, 1]
    assert match([[0, 1, 1, 1, 1, 0], [1, 1, 1, 0, 0, 0]], line) == ([1, 0], 0)
    assert match([[1, 1, 1, 0, 0, 0], [0, 1, 1, 1, 1, 0]], line) == ([0, 1], 0)


def test_a_line_without_points_is_on_no_wall_and_no_duplicate():
    assert match([[0, 0, 0, 0], [1, 1, 1, 1]], [0] * 4) == ([-1, 0], 0)


def test_without_lines_found_or_true_none_is_matched():
    assert match(np.empty((0, 4)), [0] * 4) == ([], 0)
    assert match([[1, 1, 1, 1]], [-1] * 4) == ([-1], 0)


def test_features_and_truth_of_scans_of_different_sizes_are_refused():
    with pytest.raises(ValueError, match=r"^features and truth must be of one scan, got 4 and 5 b"):
        match([[1, 1, 1, 1]], [0] * 5)


def test_without_scipy_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.optimize", None)  # makes its import fail
    hint = f"^{re.escape('scores need SciPy: ' + install_line('evaluation'))}$"
    with pytest.raises(MissingDependencyError, match=hint):
        match_corners(NOWHERE, NOWHERE)
    with pytest.raises(MissingDependencyError, match=hint):
        match_lines(LineSegments.none(4), truth_on([0] * 4))


def test_scipy_is_imported_only_to_match():
    code = "import sys, laserfeatures.evaluation; print('scipy' in sys.modules)"
    done = subprocess.run(  # noqa: S603 - our own interpreter and code
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout == "False\n"
