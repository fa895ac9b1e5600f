"""The driver of the LMS2xx on a real pseudo-terminal: it opens in any state and leaves no trace."""

import itertools
import time
from contextlib import suppress

import numpy as np
import pytest
from bounded import until
from lms_lines import Numbered, turn_of, wall

from laserfeatures.drivers import Sweep
from laserfeatures.drivers.lms import Lms, dialog, requests
from laserfeatures.drivers.lms.status import write_status
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.line_ends import Pty
from laserfeatures.emulators.lms import LmsDevice, Memory
from laserfeatures.emulators.lms.memory import STATUS
from laserfeatures.errors import DeviceLostError, DriverError, DriverTimeoutError, ProtocolError

SPEED = 10.0
GAP = 0.3  # [s]; a fast device needs patience with the host's bytes


def device(feed=wall, baud=500_000, **parameters):
    return LmsDevice(feed, byte_gap=GAP, baud=baud, **parameters)


def run(scanner, count=3, baud=500_000, **parameters):
    """Return the first scans of a device, and the driver after it was left."""
    with Emulator(scanner, speed=SPEED, patient=True) as emulator:
        driver = Lms(port=emulator.port, baud=baud, **parameters)
        with driver:
            scans = list(itertools.islice(driver, count))
    return scans, driver


STATES = [
    {"baud": 9600},
    *({"baud": baud, "start": "streaming"} for baud in (9600, 38400, 500_000)),
    {"start": "half_telegram", "baud": 19200},
    {"start": "installation"},
    {"start": "booting", "start_up": 8.0, "baud": 9600},
    {"deaf": 0.2, "seed": 3},
    {"reply_address": 0x81, "glued": True, "status": 0x11},
    {"lookalike": True, "baud": 38400},
]


@pytest.mark.parametrize("state", STATES, ids=str)
def test_it_opens_in_any_state_and_leaves_the_scanner_quiet_at_its_rate(state):
    scanner = device(**state)
    before = scanner._first_baud
    begin = time.monotonic()
    scans, driver = run(scanner)
    assert time.monotonic() - begin < 8
    assert [len(scan) for scan in scans] == [361] * 3
    if "lookalike" not in state:
        assert all((scan.ranges == 3.0).all() for scan in scans)
    assert scanner.mode == requests.ON_REQUEST
    assert scanner.baud == before
    assert scanner.memory.writes == 0
    assert str(driver.losses) == "none"
    assert driver.device_type == "LMS200;S18063;V02.19"


@pytest.mark.parametrize(("found", "session"), [(9600, 38400), (500_000, 500_000)])
def test_without_a_rate_it_takes_38400_bd_or_more(found, session):
    scanner = device(baud=found)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port) as driver,
    ):
        next(driver)
        assert scanner.baud == session
    assert scanner.baud == found


def test_a_serial_line_behind_a_network_has_the_rate_that_the_scanner_names():
    emulator = Emulator(device(baud=9600), tcp=0, speed=SPEED)
    with emulator, Lms(port=emulator.port) as driver:
        assert len(next(driver)) == 361
        assert driver.period == pytest.approx(29 * 0.02664)


def test_it_writes_only_what_differs_and_only_once():
    scanner = device()
    wanted = {"angle": 100, "resolution": 0.25, "reach": 32, "unit": "mm", "indices": True}
    for _ in range(2):
        scans, driver = run(scanner, **wanted)
        assert scanner.memory.writes == 2  # one for the configuration, one for the variant
        assert [len(scan) for scan in scans] == [401] * 3
        assert np.degrees(scans[0].angles[[0, -1]]) == pytest.approx([-50, 50])
        assert scans[0].range_max == 32.759
        assert driver.losses.missed == 0
        assert driver.period == pytest.approx(0.05328)


def test_centimetres():
    scans, _ = run(device(), unit="cm", reach=8, resolution=1.0)
    assert (len(scans[0]), scans[0].range_max) == (181, 81.83)
    assert set(scans[0].ranges) == {3.0}


@pytest.mark.parametrize(
    ("parameters", "size", "duration"),
    [
        ({"mode": "on_request"}, 361, 2),
        ({"mode": "on_request", "first": 21, "last": 60}, 40, 2),
        ({"mean": 3}, 361, 6),
        ({"mean": 3, "first": 1, "last": 11}, 11, 6),
    ],
)
def test_ways_of_measuring(parameters, size, duration):
    scans, driver = run(device(), **parameters)
    assert [len(scan) for scan in scans] == [size] * 3
    assert driver.arrival - scans[-1].stamp == pytest.approx(duration * 0.01332, abs=1e-4)
    if "first" in parameters:
        first = (parameters["first"] - 1) / 2 - 90
        assert np.degrees(scans[0].angles[0]) == pytest.approx(first)


def test_interlaced_scans_are_turns_of_one_degree():
    scans, driver = run(device(), 8, mode="interlaced")
    assert {len(scan) for scan in scans} == {180, 181}
    firsts = [round(np.degrees(scan.angles[0]), 2) for scan in scans]
    assert set(firsts[::2]) == {-90.0}
    assert set(firsts[1::2]) == {-89.5}
    assert driver.period == pytest.approx(0.01332)


def test_scans_on_request_are_fresh():
    scanner = device(Numbered(), deaf=0.2, seed=1)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port, mode="on_request", baud=500_000) as driver,
    ):
        for _ in range(4):
            made = scanner.feed.turns
            assert turn_of(next(driver)) >= made


def test_what_was_recorded_gives_the_same_scans():
    taped = []
    scanner = device(Numbered(), start="streaming", baud=38400)
    scans, driver = run(scanner, 4, tap=lambda *entry: taped.append(entry))
    decoder, again = driver.decoder(), []
    for direction, data, at in taped:
        if direction == "tx":
            decoder.sent(data, at)
        elif direction == "rx":
            again += [m.scan for m in decoder.received(data, at) if isinstance(m, Sweep)]
    for scan, replayed in zip(scans, again, strict=False):
        assert np.array_equal(scan.ranges, replayed.ranges)
        assert scan.stamp == replayed.stamp


def test_an_error_in_the_loop_stops_the_stream():
    scanner = device()
    with Emulator(scanner, speed=SPEED, patient=True) as emulator:
        with suppress(KeyboardInterrupt), Lms(port=emulator.port, baud=500_000) as driver:
            next(driver)
            assert scanner.mode == requests.STREAM
            raise KeyboardInterrupt
        assert scanner.mode == requests.ON_REQUEST


def test_a_scanner_that_restarts_at_another_rate_is_waited_for(monkeypatch):
    monkeypatch.setattr(dialog, "ROUNDS", (0.0, 0.0))
    scanner = device(faults=Faults({}, seed=9), start_up=30.0)
    with (
        Emulator(scanner, speed=SPEED, patient=True) as emulator,
        Lms(port=emulator.port) as driver,
    ):
        next(driver)
        scanner.faults.rates["restart"] = 1.0
        until(lambda: scanner._lives != 1)
        scanner.faults.rates.clear()
        until(lambda: driver.losses.restarts, lambda: next(driver))
        assert len(next(driver)) == 361
        assert (driver.losses.silences, driver.losses.restarts) == (1, 1)


def test_a_reset_on_purpose():
    scanner = device(start_up=1.0)
    with Emulator(scanner, speed=10) as emulator, Lms(port=emulator.port) as driver:
        next(driver)
        driver.restart()
        assert len(next(driver)) == 361
        assert scanner._lives == 2


def test_a_scanner_that_hangs_is_started_again():
    scanner = device(hangs_after=2, baud=38400)
    scans, driver = run(scanner, 6, baud=38400)
    assert len(scans) == 6
    assert (driver.losses.silences, driver.losses.restarts) == (1, 1)


def test_lost_scans_are_missed_by_the_indices():
    scanner = device(Numbered(), bad_crc=0.3, seed=2)
    scanner.memory.configuration = b"\0\0\0\0\2\4\1" + bytes(27)
    scans, driver = run(scanner, 30)
    turns = [turn_of(scan) for scan in scans]
    skipped = turns[-1] - turns[0] + 1 - len(turns)
    assert skipped > 0
    assert driver.losses.missed == pytest.approx(skipped, abs=3)
    assert driver.losses.damaged == pytest.approx(skipped, abs=3)


def test_unplugging(tmp_path):
    link = tmp_path / "scanner"
    faults = Faults({}, unplugged_time=0.3)
    with Emulator(device(faults=faults), link=link, speed=SPEED, patient=True) as emulator:
        with Lms(port=emulator.port, baud=500_000, reconnect=True) as driver:
            next(driver)
            faults.unplugged = True
            until(lambda: driver.losses.reconnects, lambda: next(driver))
            assert len(next(driver)) == 361
        with Lms(port=emulator.port, baud=500_000) as driver:
            faults.unplugged = True
            with pytest.raises(DeviceLostError, match="gone"):
                list(driver)


def test_silence_and_other_devices(monkeypatch):
    monkeypatch.setattr(dialog, "ROUNDS", (0.0,))
    line = Pty()
    try:
        with pytest.raises(DriverTimeoutError, match=r"SICK LMS2xx at 9600, .*got silence"):
            Lms(port=line.name).open()
        line.read(0)
        driver = Lms(port=line.name, tap=lambda *_: line.write(b"$GPGGA,123519,4807.038,N\r\n"))
        with pytest.raises(ProtocolError, match="a GPS receiver"):
            driver.open()
    finally:
        line.close()


def test_what_the_scanner_refuses_is_said():
    memory = Memory(device_type=b"LMS291;S14   ;V02.20 ", angle=90)
    with pytest.raises(DriverError, match=r"refuses 100 degrees in steps of 0\.5"):
        run(device(memory=memory), angle=100)
    scans, _ = run(device(memory=memory))
    assert np.degrees(scans[0].angles[[0, -1]]) == pytest.approx([-45, 45])
    with pytest.raises(DriverError, match="refuses the stream"):
        run(device(), first=1, last=400)
    reflecting = Memory(configuration=b"\0\0\0\0\0\x3f\1" + bytes(27))
    with pytest.raises(DriverError, match="mode 3F, which has no ranges: set one with reach=8"):
        run(device(memory=reflecting))
    assert run(device(memory=reflecting), reach=16)[0][0].range_max == 16.375


def test_a_status_that_makes_no_sense_is_said():
    scanner = device(memory=Memory(angle=270))
    with pytest.raises(ProtocolError, match=r"^/dev/\S+: variant: expected 90, 100 or 180 degrees"):
        run(scanner)
    assert scanner.mode == requests.ON_REQUEST


def test_a_defective_scanner_says_what_is_wrong(caplog):
    errors = bytes.fromhex("841684310131")
    memory = Memory(errors=errors, status=write_status(STATUS, defective=1))
    with caplog.at_level("WARNING", "laserfeatures.drivers"):
        run(device(memory=memory))
    assert "old fatal error 22 (window polluted)" in caplog.text
