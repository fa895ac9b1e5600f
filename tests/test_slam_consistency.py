"""The watch says when the filter is lost or inconsistent: once, and not without need."""

import numpy as np
import pytest

from laserfeatures.slam.consistency import EACH_SCAN, LOST, ODD, WINDOW, Watch


def notices(steps):
    watch = Watch()
    return [watch.notice(*step) for step in steps]


def test_a_consistent_filter_is_left_in_peace():
    rng = np.random.default_rng(1)
    counts = rng.integers(0, 8, 3000)
    steps = [(int(n), float(rng.chisquare(2 * n)) if n else 0.0, 0.0) for n in counts]
    assert set(notices(steps)) == {None}


@pytest.mark.parametrize("factor", [2.0, 4.0])
def test_innovations_that_are_too_large_are_told_once(factor):
    good, bad = (5, 10.0, 0.0), (5, 10.0 * factor**2, 0.0)
    told = notices([good] * WINDOW + [bad] * WINDOW + [good] * 2 * WINDOW + [bad] * WINDOW)
    (first, second) = [i for i, notice in enumerate(told) if notice]
    assert WINDOW <= first < 2 * WINDOW
    assert second >= 4 * WINDOW  # once it was well again
    assert told[first].startswith(f"inconsistent: over the last {WINDOW} scans, innovations were ")


def test_the_excess_is_told_as_it_is():
    (told,) = [t for t in notices([(10, 20.0 * 9, 0.0)]) if t]
    assert "over the last 1 scans" in told
    assert "3.0 times what the covariances allow" in told


def lost(odd):
    """Return in which of many scans a filter says that it is lost, if each is so odd."""
    told = notices([(4, 8.0, 0.0)] * 5 + [(0, 0.0, odd)] * 30)
    assert all(notice.startswith("lost: for ") for notice in told if notice)
    return [i - 4 for i, notice in enumerate(told) if notice]


def test_a_filter_that_recognises_nothing_is_lost_and_says_so_once():
    assert lost(ODD) == [LOST]
    less = EACH_SCAN + 1.01 * ODD / (2 * LOST)
    assert lost(less) == [2 * LOST]  # where it is less odd, it takes longer


def test_the_scans_are_counted():
    told = notices([(4, 8.0, 0.0)] + [(0, 0.0, EACH_SCAN + 1.01 * ODD / 10)] * 10)
    assert told[-1].startswith("lost: for 10 scans hardly any landmark")


def test_it_is_lost_again_if_it_found_itself_in_between():
    scans = [(0, 0.0, ODD)] * LOST
    told = notices([*scans, *[(5, 10.0, 0.0)] * 3, *scans])
    assert [i for i, notice in enumerate(told) if notice] == [LOST - 1, 2 * LOST + 2]


def test_an_empty_view_is_no_reason():
    assert lost(0.0) == []


def test_a_chance_match_is_outweighed_and_doubts_come_first():
    watch = Watch()
    assert not watch.doubts
    told = [watch.notice(1, 2.0, odd) for odd in (23, 18, 16)]
    assert told[:2] == [None, None]
    assert told[2].startswith("lost")
    watch = Watch()
    watch.notice(0, 0.0, 12.0)
    assert watch.doubts
    watch.notice(4, 8.0, 0.0)
    assert not watch.doubts
