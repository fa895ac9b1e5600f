"""The sensor's clock against the host's: offset, wrap, drift."""

import itertools

import numpy as np
import pytest

from laserfeatures.drivers.urg.clock import WRAP, Clock

BEGIN = 1_700_000_000.0  # [s since the epoch]


def read(clock, ticks, at, delays):
    """Let a clock that shows `ticks` [ms] at `at` be read, with these delays to and fro [s]."""
    for i, (to, fro) in enumerate(delays):
        asked = at + 0.01 * i
        clock.ask(asked)
        clock.answer(int(ticks + (0.01 * i + to) * 1000) % WRAP, asked + to + fro)


def test_the_offset_is_the_median_of_the_readings():
    clock = Clock()
    delays = [(0.0005, 0.0005)] * 6 + [(0.0005, 0.3)] * 5
    read(clock, 5000.3, BEGIN, delays)
    assert clock.host_time(6000, BEGIN) == pytest.approx(BEGIN + 1.0, abs=0.001)


def test_an_answer_that_was_not_asked_for_is_nothing():
    clock = Clock()
    read(clock, 5000, BEGIN, [(0.0, 0.0)])
    clock.answer(9999, BEGIN + 50)
    assert clock.host_time(6000, BEGIN) == pytest.approx(BEGIN + 1.0, abs=0.001)


@pytest.mark.parametrize("start", [WRAP - 45, WRAP - 5, 0])  # of ten, five or one before it
def test_a_wrap_between_the_readings_is_nothing(start):
    clock = Clock()
    read(clock, start, BEGIN, [(0.0005, 0.0005)] * 10)
    assert clock.host_time((start + 1000) % WRAP, BEGIN + 1) == pytest.approx(
        BEGIN + 1.0, abs=0.001
    )


def test_days_later_the_nearest_turn_of_the_clock_counts():
    clock = Clock()
    read(clock, 100, BEGIN, [(0.0005, 0.0005)] * 3)
    later = 5 * WRAP / 1000 + 77.0
    time = clock.host_time(77_100, BEGIN + later + 0.07)
    assert time == pytest.approx(BEGIN + later, abs=0.001)


def test_an_unknown_offset_is_guessed_once():
    clock = Clock()
    clock.guess(1000, BEGIN)
    clock.guess(2000, BEGIN + 7)
    assert clock.host_time(1500, BEGIN) == pytest.approx(BEGIN + 0.5)


@pytest.mark.parametrize("drift", [0.0, 200e-6, -200e-6])
def test_drift_is_followed_and_times_increase(drift):
    rng = np.random.default_rng(1)
    clock = Clock()
    read(clock, 0, BEGIN, [(0.0005, 0.0005)] * 11)
    stamps, errors = [], []
    for i in range(36_000):  # an hour
        measured = BEGIN + 1 + 0.1 * i  # by the host
        ticks = int((measured - BEGIN) * (1 + drift) * 1000) % WRAP
        late = rng.exponential(0.003) + (rng.random() < 0.01) * 0.5
        arrival = measured + 0.068 + late
        stamp = clock.host_time(ticks, arrival)
        clock.follow(stamp, arrival)
        stamps.append(stamp)
        errors.append(stamp - measured)
    assert all(a < b for a, b in itertools.pairwise(stamps))
    assert np.abs(errors).max() < 0.008
    assert np.abs(np.diff(stamps) - 0.1).max() < 0.006
