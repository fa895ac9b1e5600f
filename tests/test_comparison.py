import gc
import math
import time
from dataclasses import replace

import numpy as np
import pytest
from oracles import corners_at, extractor, oracle, tour

import laserfeatures as lf
from laserfeatures import LaserScan, Pose2D
from laserfeatures.comparison import Failure, Run, compare, growth
from laserfeatures.comparison.evidence import by_evidence
from laserfeatures.comparison.matching import agreement, repeatability
from laserfeatures.comparison.tables import cells, result_table

PERFECT = extractor(oracle())


def raising(at, error):
    """Return an extractor that raises from the scan of stamp `at` on."""

    def extract(scan):
        if scan.stamp >= at:
            raise error
        return PERFECT(scan)

    return extract


def scan_from(pose, ranges=20.0, **limits):
    angles = np.radians(np.arange(-90.0, 91.0))
    limits = {"range_max": 30.0} | limits
    return LaserScan(angles=angles, ranges=np.full(181, ranges), pose=pose, **limits)


def test_what_is_counted_is_what_the_extractors_return():
    scans = tour(6)
    extractors = {
        "ours": lf.get_extractor("direct_hough"),
        "half": extractor(oracle(keep=lambda _scan, k: k < 2)),
    }
    comparison = compare(extractors, scans)
    assert list(comparison.runs) == ["ours", "half"]
    for name, extract in extractors.items():
        run, found = comparison.runs[name], [extract(scan) for scan in scans]
        assert run.lines.tolist() == [len(features.lines) for features in found]
        assert run.corner_counts.tolist() == [len(features.corners) for features in found]
        assert run.real_counts.tolist() == [features.corners.real.sum() for features in found]
        for positions, features in zip(run.positions, found, strict=True):
            assert np.array_equal(positions, features.corners.positions)
    assert comparison.runs["ours"].lines.min() >= 2


def test_exact_corners_are_found_again_and_dropped_ones_are_not():
    by_turns = extractor(oracle(keep=lambda scan, _k: int(scan.stamp) // 2 % 2 == 0))
    comparison = compare({"perfect": PERFECT, "by turns": by_turns}, tour(41))
    perfect = comparison.repeatability["perfect"]
    assert perfect.pairs == 40
    assert perfect.in_view.judged > 80
    assert perfect.in_view.value == 1.0
    assert perfect.in_sight == perfect.in_view  # nothing stands in an empty room
    assert comparison.repeatability["by turns"].in_view.value == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(("shift", "share"), [(0.3, 0.0), (0.1, 1.0)])
def test_agreement_is_within_the_tolerance(shift, share):
    shifted = extractor(oracle(shift=(shift, 0.0)))
    comparison = compare({"a": PERFECT, "b": shifted}, tour(5))
    assert comparison.agreement.tolist() == [[1.0, share], [share, 1.0]]


def test_agreement_is_the_share_of_the_row_that_the_column_has():
    one, four, none = ([corners_at(p).positions] for p in ([[0, 0]], np.eye(4, 2), []))
    shares = agreement([one, four, none], 0.2)
    assert np.array_equal(shares, [[1, 1, 0], [0.5, 1, 0], [np.nan] * 3], equal_nan=True)


@pytest.mark.parametrize(
    ("corner", "judged", "why"),
    [
        ((5.0, 2.0), True, "ahead"),
        ((-1.0, 3.0), False, "behind the last beam"),
        ((0.0, -31.0), False, "beyond the range"),
        ((0.0, 0.05), False, "nearer than the sensor measures"),
    ],
)
def test_only_corners_in_the_next_scans_view_are_judged(corner, judged, why):
    scans = [scan_from(Pose2D(0, 0, 0)), scan_from(Pose2D(0, 0, 0), range_min=0.1)]
    again = repeatability(scans, [corners_at(corner).positions, np.empty((0, 2))], 0.2)
    assert again.in_view.judged == judged, why
    assert again.in_view.found == 0


def test_a_view_may_run_over_the_angle_pi():
    angles = np.radians(np.arange(100.0, 261.0))
    scan = LaserScan(angles=angles, ranges=np.full(161, 8.0), pose=Pose2D(0, 0, 0))
    for corner, judged in (((-3.0, -0.1), 1), ((-3.0, 0.1), 1), ((3.0, 0.1), 0)):
        positions = corners_at(corner).positions
        again = repeatability([scan, scan], [positions, positions], 0.2)
        assert (again.in_view.found, again.in_view.judged) == (judged, judged)


def test_poses_move_a_corner_into_the_next_scan():
    before, after = scan_from(Pose2D(1, 0, 0)), scan_from(Pose2D(3, 1, math.pi / 2))
    there = corners_at([4.0, 3.0]).positions  # at (5, 3) of the plan
    for found, share in (([2.0, -2.0], 1.0), ([2.0, -1.5], 0.0)):
        again = repeatability([before, after], [there, corners_at(found).positions], 0.2)
        assert again.in_view.value == share


def test_a_hidden_corner_is_in_view_but_not_in_sight():
    scans = [scan_from(Pose2D(0, 0, 0), ranges) for ranges in (20.0, 4.0)]
    corners = [corners_at([[3.0, 0.0], [4.1, 0.0], [9.0, 0.0]]).positions, np.empty((0, 2))]
    again = repeatability(scans, corners, 0.2)
    assert (again.in_view.judged, again.in_sight.judged) == (3, 2)


def test_what_a_beam_sees_behind_the_sensor_shows_nothing_ahead():
    angles = np.radians(np.arange(-180.0, 180.0))
    ranges = np.where(abs(angles) < 1.0, 2.0, 20.0)
    scan = LaserScan(angles=angles, ranges=ranges, pose=Pose2D(0, 0, 0))
    ahead, behind = (corners_at([x, 0.1]).positions for x in (5.0, -5.0))
    assert repeatability([scan] * 2, [ahead] * 2, 0.2).in_sight.judged == 0
    assert repeatability([scan] * 2, [behind] * 2, 0.2).in_sight.judged == 1


@pytest.mark.parametrize("no_return", [0.0, math.inf, math.nan, 30.0])
def test_a_beam_without_a_return_shows_nothing(no_return):
    scans = [scan_from(Pose2D(0, 0, 0)), scan_from(Pose2D(0, 0, 0), no_return)]
    again = repeatability(scans, [corners_at([3.0, 0.0]).positions] * 2, 0.2)
    assert (again.in_view.found, again.in_sight.judged) == (1, 0)


def judged_at(share):
    """Return two scans with a corner at each metre ahead, of which the nearest are found again.

    The farther, the weaker; every second is virtual.
    """
    scans = [scan_from(Pose2D(0, 0, 0)), scan_from(Pose2D(0, 0, 0))]
    places = np.stack([np.arange(1.0, 21.0), np.zeros(20)], axis=1)
    corners = replace(corners_at(places, np.arange(20.0, 0.0, -1.0)), real=[True, False] * 10)
    again = corners_at(places[: round(20 * share)], np.full(round(20 * share), 20.0))
    return scans, [corners, again]


def test_corners_of_more_evidence_are_fewer_and_judged_alone():
    scans, corners = judged_at(0.5)
    curves = by_evidence(scans, corners, 0.2)
    assert list(curves) == ["real", "virtual"]
    virtual = curves["virtual"]
    assert virtual.thresholds.tolist() == [1, 5, 11, 15, 19]
    assert virtual.judged.tolist() == [10, 8, 5, 3, 1]
    assert virtual.found.tolist() == [5, 5, 5, 3, 1]
    assert virtual.corners.tolist() == [5, 4, 2.5, 1.5, 0.5]
    np.testing.assert_allclose(virtual.shares, [0.5, 5 / 8, 1, 1, 1])
    real = curves["real"]
    assert real.judged[0] == 10
    assert real.corners[0] == (10 + 10) / 2  # of both scans


def test_a_corner_is_found_again_whatever_its_evidence_is_then():
    scans, (corners, again) = judged_at(1.0)
    weak = replace(again, evidence=np.zeros(20))
    curve = by_evidence(scans, [corners, weak], 0.2)["virtual"]
    assert curve.found.tolist() == curve.judged.tolist() == [10, 8, 5, 3, 1]


def test_the_curve_of_all_corners_is_what_repeatability_counts():
    scans = tour(20)
    comparison = compare({"ours": lf.get_extractor("direct_hough")}, scans)
    curves, again = comparison.evidence["ours"].values(), comparison.repeatability["ours"].in_view
    assert sum(curve.judged[0] for curve in curves) == again.judged
    assert sum(curve.found[0] for curve in curves) == again.found


@pytest.mark.parametrize("evidence", [0.0, math.inf])
def test_corners_of_one_evidence_are_one_point(evidence):
    scans, (corners, _) = judged_at(1.0)
    alike = replace(corners, evidence=np.full(20, evidence))
    curve = by_evidence(scans, [alike, alike], 0.2)["real"]
    assert curve.thresholds.tolist() == [evidence] * 5
    assert curve.shares.tolist() == [1.0] * 5
    assert curve.corners.tolist() == [10.0] * 5


def test_where_no_corner_is_there_is_no_curve():
    scans = [scan_from(Pose2D(0, 0, 0))] * 2
    nothing = corners_at(np.empty((0, 2)))
    curve = by_evidence(scans, [nothing, nothing], 0.2)["real"]
    assert np.isnan(curve.thresholds).all()
    assert np.isnan(curve.shares).all()
    assert not curve.corners.any()


def test_without_poses_nothing_is_judged():
    angles = np.linspace(-1, 1, 20)
    scans = [LaserScan(angles=angles, ranges=np.ones(20))] * 3
    comparison = compare({"one": extractor(lambda _scan: corners_at([1.0, 0.0]))}, scans)
    assert not comparison.posed
    again = comparison.repeatability["one"]
    assert again.in_view.judged == 0
    assert math.isnan(again.in_view.value)
    shown = cells(comparison.runs["one"], again)
    assert [shown[column] for column in ("again", "judged", "in sight")] == ["-"] * 3


@pytest.mark.parametrize("at", [0, 7, 25, 39, 44])
def test_one_that_raises_is_a_failure_and_the_others_finish(at):
    extractors = {"fragile": raising(at, ZeroDivisionError("oh\nno")), "perfect": PERFECT}
    comparison = compare(extractors, tour(45), start=100)
    failure = comparison.outcomes["fragile"]
    assert isinstance(failure, Failure)
    assert str(failure) == f"failed at scan {100 + at}: ZeroDivisionError: oh no"
    assert len(comparison.runs["perfect"].seconds) == 45
    assert list(comparison.repeatability) == ["perfect"]
    assert comparison.agreement.tolist() == [[1.0]]
    table = result_table(comparison)
    assert [len(row) for row in table.rows] == [len(table.header)] * 2
    assert table.header[-1] == "error"
    assert table.rows[0] == ["fragile", *["-"] * 8, str(failure)]
    assert table.rows[1][-1] == ""


def test_one_that_raised_is_not_called_again():
    calls = []

    def extract(scan):
        calls.append(scan.stamp)
        raise ValueError

    comparison = compare({"broken": extract}, tour(30))
    assert calls == [0.0]
    assert str(comparison.failures["broken"]) == "failed at scan 0: ValueError"


def test_one_that_could_not_be_made_keeps_its_place():
    why = Failure(error=ImportError("no module named 'moon'"))
    comparison = compare({"a": PERFECT, "b": why, "c": PERFECT}, tour(2))
    assert list(comparison.outcomes) == ["a", "b", "c"]
    assert str(comparison.failures["b"]) == "no module named 'moon'"
    assert list(comparison.runs) == ["a", "c"]


def test_an_interrupt_is_no_failure():
    with pytest.raises(KeyboardInterrupt):
        compare({"slow": raising(3, KeyboardInterrupt())}, tour(5))


def test_times_are_in_seconds():
    def sleeping(scan):
        time.sleep(0.002)
        return PERFECT(scan)

    comparison = compare({"sleeping": sleeping, "quick": PERFECT}, tour(10))
    slow, quick = (comparison.runs[name].seconds for name in ("sleeping", "quick"))
    assert slow.shape == quick.shape == (10,)
    assert slow.min() >= 0.002
    assert np.median(slow) < 0.02
    assert 0 < np.median(quick) < 0.001
    shown = cells(comparison.runs["sleeping"], comparison.repeatability["sleeping"])
    assert 2000 <= float(shown["median"]) <= float(shown["p99"])


def test_they_take_turns_on_fresh_scans_and_what_warms_up_is_not_counted():
    calls = {"a": [], "b": []}
    order = []

    def watching(name):
        def extract(scan):
            assert "valid" not in vars(scan)
            assert "points" not in vars(scan)
            assert not gc.isenabled()
            assert scan.angles is shared[int(scan.stamp)]
            assert len(scan.points)  # now it is computed
            calls[name].append(int(scan.stamp))
            if order[-1:] != [name]:
                order.append(name)
            return PERFECT(scan)

        return extract

    scans = tour(45)
    shared = [scan.angles for scan in scans]
    comparison = compare({"a": watching("a"), "b": watching("b")}, scans)
    assert not comparison.failures
    first, second, third = (list(range(*turn)) for turn in ((20,), (20, 40), (40, 45)))
    assert calls["a"] == calls["b"] == [*first, *first, 19, *second, 39, *third]
    assert order == ["a", "b"] * 3
    assert len(comparison.runs["a"].seconds) == 45
    assert gc.isenabled()


def test_without_a_scan_there_is_nothing_to_compare():
    with pytest.raises(ValueError, match="expected at least one scan to compare on, got none"):
        compare({"a": PERFECT}, [])
    with pytest.raises(ValueError, match="expected at least one scan to time on, got none"):
        growth({"a": PERFECT}, [])
    with pytest.raises(ValueError, match=r"tolerance must be > 0 m, got 0\.0"):
        compare({"a": PERFECT}, tour(1), tolerance=0.0)


def test_one_scan_is_enough():
    comparison = compare({"a": PERFECT}, tour(1))
    assert isinstance(comparison.outcomes["a"], Run)
    assert not comparison.posed


def test_growth_is_timed_on_thinned_scans_that_share_their_angles():
    angles = {}

    def by_beams(scan):
        if len(scan) < 50:
            raise ValueError("too few")
        angles.setdefault(len(scan), set()).add(id(scan.angles))
        time.sleep(len(scan) * 1e-5)
        return PERFECT(scan)

    room = tour(100)
    scans = [replace(scan, angles=room[0].angles) for scan in room]
    found = growth({"by beams": by_beams}, scans)
    assert found.scans == 64
    assert found.beams.tolist() == [23, 46, 91, 181]
    seconds = found.seconds["by beams"]
    assert np.isnan(seconds).tolist() == [True, True, False, False]
    assert 0.0018 < seconds[3] < 0.02
    assert seconds[2] < seconds[3]
    assert {beams: len(ids) for beams, ids in angles.items()} == {91: 1, 181: 1}
