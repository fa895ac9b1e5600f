import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import DATA, needs_recordings

import laserfeatures as lf
from laserfeatures.sources.no_return import RangeLimit

BEAMS = 361


def log_of(no_return, *, share=0.05, longest=30.0, scans=40, digits=2, seed=0):
    """Return scans of a corridor whose beams without return say `no_return`."""
    rng = np.random.default_rng(seed)
    ranges = np.round(longest * rng.beta(1, 3, (scans, BEAMS)) + 0.3, digits)
    silent = rng.random((scans, BEAMS)) < share
    ranges[silent] = rng.choice(np.atleast_1d(no_return), silent.sum())
    return ranges, silent


def dropped(ranges, limit):
    return ranges >= limit


@pytest.mark.parametrize(
    ("no_return", "digits"),
    [
        (50.0, 2),
        (80.0, 2),
        (79.99, 2),
        (31.7, 2),
        ([81.83, 81.87, 81.89, 81.91], 2),
        ([81.910004, 81.830002], 6),
        ([32.759, 32.763, 32.765, 32.767], 3),
    ],
)
def test_no_returns_are_found(no_return, digits):
    ranges, silent = log_of(no_return, digits=digits)
    limit = RangeLimit().update(list(ranges))
    assert np.array_equal(dropped(ranges, limit), silent)


def test_short_codes_are_found():
    ranges, silent = log_of([8.183, 8.187, 8.191], longest=7.0, digits=3)
    limit = RangeLimit().update(list(ranges))
    assert np.array_equal(dropped(ranges, limit), silent)


def test_both_a_code_and_a_software_maximum_are_dropped():
    ranges, silent = log_of([50.0, 81.91])
    limit = RangeLimit().update(list(ranges))
    assert limit == 50
    assert np.array_equal(dropped(ranges, limit), silent)


@pytest.mark.parametrize("scans", [1, 5])
def test_a_single_code_is_enough(scans):
    ranges, _ = log_of(81.91, share=0, scans=scans)
    ranges[0, 7] = 81.91
    assert np.argwhere(dropped(ranges, RangeLimit().update(list(ranges)))).tolist() == [[0, 7]]


def test_a_true_range_in_the_millimetre_codes_stays_in_a_log_in_centimetres():
    ranges, _ = log_of(0.0, share=0)
    ranges[0, 7] = 32.76
    assert RangeLimit().update(list(ranges)) == np.inf


@given(seed=st.integers(0, 10_000), digits=st.sampled_from([2, 3]), scans=st.integers(1, 40))
@settings(max_examples=40, deadline=None)
def test_true_returns_stay(seed, digits, scans):
    ranges, _ = log_of(0.0, share=0, digits=digits, scans=scans, seed=seed)
    assert RangeLimit().update(list(ranges)) == np.inf


def test_a_round_room_and_a_standing_robot_stay():
    circle = np.full((20, BEAMS), 5.0)
    assert RangeLimit().update(list(circle)) == np.inf
    angles = np.radians(np.arange(-90, 90.5, 0.5))
    room = np.minimum(
        7 / np.maximum(np.cos(angles), 0.01), 7 / np.maximum(np.abs(np.sin(angles)), 0.01)
    )
    assert RangeLimit().update([room] * 500) == np.inf


def test_the_limit_is_kept_for_blocks_that_do_not_show_it():
    ranges, _ = log_of(50.0)
    limit = RangeLimit()
    assert limit.update(list(ranges)) == 50
    few = ranges[:1].copy()
    few[few == 50] = 3.0
    few[0, 5] = 50.0
    assert limit.update(list(few)) == 50


def test_true_ranges_beyond_the_limit_end_it():
    limit = RangeLimit()
    limit.update(list(log_of(12.5, longest=11)[0]))
    assert limit.value == 12.5
    assert limit.update(list(log_of(0.0, share=0, longest=30)[0])) == np.inf


def test_scans_of_different_lengths_and_without_returns():
    assert RangeLimit().update([np.zeros(3), np.full(5, np.nan), np.array([])]) == np.inf


@needs_recordings
@pytest.mark.parametrize(
    "log",
    [
        "aces-corrected",
        "belgioioso-corrected",
        "csail-corrected",
        "freiburg-101-corrected",
        "orebro-corrected",
        "seattle-corrected",
    ],
)
@pytest.mark.parametrize("maximum", [79.99, 50.0, 29.99, 20.0, 10.0, 5.1])
def test_real_logs_cut_at_another_maximum(log, maximum):
    with lf.open_source(DATA / f"sick/{log}.log.gz") as source:
        scans = list(source)
    silent = np.array([~scan.valid | (scan.ranges >= maximum) for scan in scans])
    ranges = np.where(silent, maximum, [scan.ranges for scan in scans])
    assert np.array_equal(dropped(ranges, RangeLimit().update(list(ranges))), silent)


@needs_recordings
def test_range_max_overrides_what_was_found():
    with lf.open_source(DATA / "sick/aces-corrected.log.gz", range_max=8) as source:
        scans = list(source)
    assert {scan.range_max for scan in scans} == {8}
    assert max(scan.ranges[scan.valid].max() for scan in scans) < 8
