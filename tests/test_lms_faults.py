"""Faults on the line of the LMS2xx: every undamaged scan comes, and none that was not sent."""

import pytest
from bounded import until
from hypothesis import given
from hypothesis import strategies as st
from lms_lines import Numbered, host, turn_of

from laserfeatures.drivers.lms import Lms, pack_request
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.lms import LmsDevice, Memory

FRAMES = 300
SPEED = 20


def device(**parameters):
    memory = Memory(baud=500_000, keeps_baud=True)
    return LmsDevice(Numbered(), memory=memory, byte_gap=1.0, **parameters)


@pytest.mark.parametrize(
    ("rates", "parameters"),
    [
        ({"garbage": 0.1}, {}),
        ({"lost_byte": 0.1}, {}),
        ({"doubled_byte": 0.1}, {}),
        ({"bit_flip": 0.1}, {}),
        ({"cut": 0.1}, {}),
        ({"garbage": 0.1, "lost_byte": 0.05, "bit_flip": 0.05, "cut": 0.05}, {"glued": True}),
        ({}, {"bad_crc": 0.1, "deaf": 0.1}),
    ],
    ids=str,
)
def test_every_undamaged_scan_comes_and_no_other(rates, parameters):
    scanner = device(faults=Faults({}, seed=5), **parameters)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port, baud=500_000, buffer=10_000) as driver,
    ):
        scanner.faults.rates.update(rates)
        found = [turn_of(next(driver)) for _ in range(FRAMES)]
        scanner.faults.rates.clear()
        assert driver.losses.overruns == driver.losses.silences == 0
        assert driver.losses.damaged + driver.losses.garbage > 0
    sent = [turn for turn, fault in scanner.frames if fault is None]
    assert found == [turn for turn in sent if found[0] <= turn <= found[-1]]


@pytest.mark.parametrize("fault", ["stuck", "restart"])
def test_scans_come_again_after_the_scanner_was_away(fault):
    scanner = device(faults=Faults({}, seed=5, stuck_time=25.0), start_up=2.0)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port, baud=500_000, buffer=10_000) as driver,
    ):
        found = [turn_of(next(driver))]
        scanner.faults.rates[fault] = 0.05
        until(lambda: any(kind == fault for _, kind in scanner.frames))
        scanner.faults.rates.clear()
        until(lambda: driver.losses.restarts, lambda: found.append(turn_of(next(driver))))
        found += [turn_of(next(driver)) for _ in range(20)]
    assert found == sorted(set(found))
    fault_of = dict(scanner.frames)
    assert all(fault_of[turn] is None for turn in found)


def test_requests_and_replies_may_be_damaged_too():
    rates = {"garbage": 0.1, "lost_byte": 0.05, "bit_flip": 0.05}
    scanner = device(faults=Faults(rates, seed=4), deaf=0.1)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port, baud=500_000) as driver,
    ):
        assert len(next(driver)) == 361
        scanner.faults.rates.clear()


BYTES = st.one_of(
    st.binary(max_size=80),
    st.builds(pack_request, st.integers(0, 0x7F), st.binary(max_size=40)),
    st.builds(pack_request, st.sampled_from([0x20, 0x30, 0x36, 0x37, 0x3B]), st.binary(max_size=5)),
)


@given(st.lists(st.tuples(BYTES, st.floats(0, 0.5)), max_size=12))
def test_a_host_may_send_the_emulator_anything(pieces):
    scanner = host(Numbered(), start_up=0.1)
    for data, pause in pieces:
        scanner.send(data)
        scanner.listen(pause)
        assert scanner.device.due(scanner.now) >= 0
    assert len(scanner.device._events) < 30
