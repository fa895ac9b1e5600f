"""The watch says when the filter is lost or inconsistent: once, and not without need."""

import numpy as np
import pytest

from laserfeatures.slam.consistency import LEAST, LOST, WINDOW, Watch


def notices(steps):
    watch = Watch()
    return [watch.notice(*step) for step in steps]


def test_a_consistent_filter_is_left_in_peace():
    rng = np.random.default_rng(1)
    counts = rng.integers(0, 8, 3000)
    steps = [(int(n), float(rng.chisquare(2 * n)) if n else 0.0, 0) for n in counts]
    assert set(notices(steps)) == {None}


@pytest.mark.parametrize("factor", [2.0, 4.0])
def test_innovations_that_are_too_large_are_told_once(factor):
    good, bad = (5, 10.0, 0), (5, 10.0 * factor**2, 0)
    told = notices([good] * WINDOW + [bad] * WINDOW + [good] * 2 * WINDOW + [bad] * WINDOW)
    (first, second) = [i for i, notice in enumerate(told) if notice]
    assert WINDOW <= first < 2 * WINDOW
    assert second >= 4 * WINDOW  # once it was well again
    assert told[first].startswith(f"inconsistent: over the last {WINDOW} scans, innovations were ")


def test_the_excess_is_told_as_it_is():
    (told,) = [t for t in notices([(10, 20.0 * 9, 0)]) if t]
    assert "over the last 1 scans" in told
    assert "3.0 times what the covariances allow" in told


def test_a_filter_that_recognises_nothing_is_lost_and_says_so_once():
    told = notices([(4, 8.0, 0)] * 5 + [(0, 0.0, LEAST)] * 30)
    assert [i for i, notice in enumerate(told) if notice] == [5 + LOST - 1]
    assert told[5 + LOST - 1].startswith(f"lost: for {LOST} scans none ")
    assert f"({LEAST} now)" in told[5 + LOST - 1]


def test_it_is_lost_again_if_it_found_itself_in_between():
    lost = [(0, 0.0, LEAST)] * LOST
    told = notices([*lost, (3, 6.0, LEAST), *lost])
    assert [i for i, notice in enumerate(told) if notice] == [LOST - 1, 2 * LOST]


def test_a_few_misses_or_an_empty_view_are_no_reason():
    assert set(notices([(0, 0.0, LEAST - 1)] * 50)) == {None}
    assert set(notices([(0, 0.0, 0)] * 50)) == {None}
