"""The decoder of the LMS2xx: a real session, damage, and bytes in pieces of any size."""

import logging
import random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lms_lines import session
from recordings import DATA, needs_recordings

from laserfeatures.drivers import Halt, Losses, Sweep
from laserfeatures.drivers.lms import (
    LmsDecoder,
    Measurement,
    Telegram,
    pack,
    pack_request,
    requests,
)
from laserfeatures.drivers.lms.measurements import measurement_telegram
from laserfeatures.drivers.lms.status import write_status
from laserfeatures.drivers.lms.telegrams import Answer
from laserfeatures.emulators.lms.memory import STATUS

ACK = b"\x06"
DONE = pack(Telegram(0xA0, b"\0"))


def scan_bytes(number=0, count=361, status=0x10, indices=None, command=0xB0, **more):
    values = np.full(count, 3000, dtype=np.uint16)
    values[0] = number
    made = Measurement(words=values, unit=1, indices=indices, **more)
    return pack(measurement_telegram(command, made, status))


def live(**more):
    return LmsDecoder(Losses(), live=True, **more)


def numbers(messages):
    return [round(m.scan.ranges[0] * 1000) for m in messages if isinstance(m, Sweep)]


@needs_recordings
def test_the_real_session():
    decoder = LmsDecoder(Losses())
    scans = []
    for time, direction, data in session():
        if direction == "TX":
            decoder.sent(data, time)
            continue
        answer = ACK if data[4] != 0xB0 else b""
        messages = decoder.received(answer + data, time)
        scans += [m.scan for m in messages if isinstance(m, Sweep)]
        if answer:
            assert messages[0] == Answer(good=True)
            assert messages[1].command == data[4]
    assert [len(scan) for scan in scans] == [361] * 5
    assert [scan.valid.sum() for scan in scans] == [358, 357, 357, 357, 357]
    for scan in scans:
        assert scan.range_max == 16.375  # measuring mode 04, from the configuration
        assert np.nanmin(scan.ranges) == pytest.approx(0.364, abs=0.002)
        assert 9.5 < np.nanmax(scan.ranges) < 9.7
        assert np.degrees(scan.angles[[0, 360]]) == pytest.approx([-90, 90])
    steps = np.diff([scan.stamp for scan in scans])
    assert steps == pytest.approx(8 * 2 * 0.01332, abs=0.002)
    assert scans[0].stamp == pytest.approx(23 * 3600 + 25 * 60 + 30.885 - 0.02664)
    assert str(decoder.losses) == "none"
    assert decoder.losses.frames == 5


@needs_recordings
def test_the_captured_telegram():
    data = (DATA / "serial/lms200_scan361_usick.bin").read_bytes()
    (sweep,) = live().received(data, 100.0)
    assert (sweep.scan.ranges.min(), sweep.scan.ranges.max()) == (0.407, 4.769)
    assert sweep.arrival == 100.0
    assert sweep.scan.stamp == pytest.approx(100.0 - 0.02664)


@given(st.integers(0, 2**32), st.integers(1, 900))
def test_pieces_of_any_size_give_the_same_scans(seed, largest):
    rng = random.Random(seed)  # noqa: S311 - for tests, not for secrets
    stream = b"".join(rng.randbytes(rng.choice([0, 0, 3])) + scan_bytes(i) for i in range(6))
    whole = numbers(live().received(stream, 0.0))
    decoder, found = live(), []
    while stream:
        size = rng.randint(1, largest)
        found += decoder.received(stream[:size], 0.0)
        stream = stream[size:]
    assert numbers(found) == whole == list(range(6))


@given(st.integers(0, 2**32))
def test_damage_costs_only_the_damaged_telegram(seed):
    rng = random.Random(seed)  # noqa: S311 - for tests, not for secrets
    stream, whole = bytearray(), []
    for number in range(10):
        data = bytearray(scan_bytes(number, rng.choice([101, 181, 361, 401])))
        kind = rng.choice(["none", "none", "flip", "lost", "cut"])
        place = rng.randrange(len(data))
        if kind == "flip":
            data[place] ^= 1 << rng.randrange(8)
        elif kind == "lost":
            del data[place]
        elif kind == "cut":
            del data[place:]
        else:
            whole.append(number)
        stream += data
    stream += scan_bytes(10) + bytes(1000)
    found, decoder = [], live()
    for i in range(0, len(stream), 61):
        found += decoder.received(bytes(stream[i : i + 61]), 0.0)
    assert numbers(found) == [*whole, 10]
    assert all(np.nanmax(m.scan.ranges[1:]) == 3.0 for m in found)


@given(st.binary(max_size=3000), st.integers(1, 400))
def test_any_bytes_do_no_harm_and_are_not_kept(data, size):
    decoder = live()
    for i in range(0, len(data), size):
        decoder.sent(pack_request(0x31), 0.0)
        decoder.received(data[i : i + size], 0.0)
    assert len(decoder._framer._buffer) < 814
    assert decoder.losses.garbage <= len(data)


def test_bad_starts_one_after_another_take_no_long_time_and_hide_nothing():
    decoder = live()
    nasty = b"\x02\x80\x28\x03\xf5" * 2000
    messages = decoder.received(nasty + scan_bytes(7) + bytes(814), 0.0)
    assert numbers(messages) == [7]
    assert decoder.losses.damaged > 0


def test_the_start_of_a_telegram_among_the_values_is_no_start():
    values = np.frombuffer(b"\x01" + DONE + b"\x06" + DONE, dtype="<u2")
    data = pack(measurement_telegram(0xB0, Measurement(words=np.tile(values, 20)[:181], unit=1), 0))
    decoder = live()
    found = [m for i in range(len(data)) for m in decoder.received(data[i : i + 1], float(i))]
    assert [type(m) for m in found] == [Sweep]
    assert found[0].arrival == 0.0


def test_a_reply_that_cuts_off_a_scan_is_found_at_once():
    decoder = live()
    assert not decoder.received(scan_bytes()[:400], 0.0)
    decoder.sent(requests.operating_mode(requests.ON_REQUEST), 0.1)
    assert decoder.received(ACK + DONE, 0.2) == [Answer(good=True), Telegram(0xA0, b"\0")]
    assert str(decoder.losses) == "none"


def test_a_reply_that_cuts_off_a_scan_hides_nothing_behind_it():
    decoder = live()
    decoder.sent(pack_request(0x31), 0.0)
    reply = pack(Telegram(0xB1, STATUS))
    messages = decoder.received(scan_bytes()[:10] + ACK + reply + scan_bytes(5), 0.2)
    assert [type(m) for m in messages] == [Telegram, Sweep]
    assert not decoder.received(ACK, 1.0)  # nothing was asked


def test_a_refused_checksum():
    decoder = live()
    decoder.sent(pack_request(0x31), 0.0)
    assert decoder.received(b"\x15", 0.0) == [Answer(good=False)]


def test_what_an_earlier_host_left_streaming_is_no_scan():
    decoder = LmsDecoder(Losses())
    assert decoder.received(scan_bytes() + b"garbage", 0.0) == []
    decoder.sent(requests.stream(), 0.0)
    assert numbers(decoder.received(ACK + DONE + scan_bytes(9), 0.1)) == [9]
    decoder.sent(requests.operating_mode(requests.ON_REQUEST), 0.2)
    assert numbers(decoder.received(scan_bytes(8) + ACK + DONE + scan_bytes(9), 0.3)) == []
    decoder.sent(requests.one_scan(), 0.4)
    assert numbers(decoder.received(ACK + scan_bytes(10), 0.5)) == [10]
    assert str(decoder.losses) == "none"


def test_a_refused_stream_brings_no_scans():
    decoder = LmsDecoder(Losses())
    decoder.sent(requests.stream(), 0.0)
    decoder.received(ACK + pack(Telegram(0xA0, b"\1")) + scan_bytes(), 0.1)
    assert decoder.losses.frames == 0


def test_a_restart_is_told_once():
    decoder = live()
    powered_on = pack(Telegram(0x90, b"LMS200;301063;V02.06 ", 0x13, 0x81))
    assert decoder.received(powered_on, 0.0) == [Halt("the scanner has restarted")]
    assert isinstance(decoder.received(powered_on, 0.0)[0], Telegram)


def test_gaps_in_the_indices_are_missed_scans():
    decoder = live()
    for turn, index in [(10, 250), (12, 251), (20, 255), (22, 0), (24, 1), (40, 9)]:
        decoder.received(scan_bytes(indices=(turn, index)), 0.0)
    assert decoder.losses.missed == 3 + 7
    assert decoder.losses.frames == 6


def test_faults_in_the_status_byte_are_counted_and_the_scan_kept(caplog):
    decoder = live()
    for status in (0x10, 0x11, 0x12, 0x13, 0x50):
        assert len(decoder.received(scan_bytes(status=status), 0.0)) == 1
    assert decoder.losses.refusals == 3
    assert "implausible" in decoder.losses.problem
    with caplog.at_level(logging.WARNING, "laserfeatures.drivers"):
        for _ in range(3):
            decoder.received(scan_bytes(status=0x91), 0.0)
    assert [record.message for record in caplog.records] == [
        "the scanner reports that its front window is dirty: clean it"
    ]


@pytest.mark.parametrize(("index", "flag"), [(False, 0x80), (True, 0x80)])
def test_it_learns_the_measuring_mode_and_the_field_of_view(index, flag):
    decoder = live()
    status = write_status(STATUS, measuring_mode=6, angle=90, resolution=50)
    decoder.received(pack(Telegram(0xB1, status)), 0.0)
    values = Measurement(
        words=np.full(181, flag << 8 | 0x7000, dtype=np.uint16), unit=1,
        indices=(1, 1) if index else None,
    )  # fmt: skip
    (sweep,) = decoder.received(pack(measurement_telegram(0xB0, values, 0x10)), 50.0)
    assert np.degrees(sweep.scan.angles[[0, -1]]) == pytest.approx([-45, 45])
    assert set(sweep.scan.ranges) == {0x7000 / 1000}
    assert sweep.scan.stamp == pytest.approx(50 - 0.01332)  # the fast type takes one turn


@pytest.mark.parametrize("variant", ["0A28 6400", "B400 0000", "0000 3200"])
def test_a_field_of_view_that_no_scanner_has_is_not_believed(variant):
    decoder = live()
    decoder.received(pack(Telegram(0xBB, b"\1" + bytes.fromhex(variant))), 0.0)
    (sweep,) = decoder.received(scan_bytes(), 0.0)
    assert np.degrees(sweep.scan.angles[[0, -1]]) == pytest.approx([-90, 90])


def test_values_that_cannot_be_read_are_damage():
    decoder = live()
    assert decoder.received(scan_bytes(count=77) + scan_bytes(3), 0.0)
    assert (decoder.losses.damaged, decoder.losses.frames) == (1, 1)
    assert "cannot be read" in decoder.losses.problem


@pytest.mark.parametrize(
    ("more", "duration"),
    [
        ({"count": 181}, 1),
        ({"count": 401}, 4),
        ({"count": 181, "partial": 0}, 1),
        ({"count": 361, "mean": 5, "command": 0xB6}, 10),
    ],
)
def test_stamps(more, duration):
    (sweep,) = live().received(scan_bytes(**more), 10.0)
    assert sweep.scan.stamp == pytest.approx(10.0 - duration * 0.01332)


def test_the_arrival_is_that_of_the_first_byte():
    decoder, data = live(), scan_bytes()
    assert not decoder.received(b"xyz" + data[:2], 1.0)
    assert not decoder.received(data[2:500], 2.0)
    (one, two) = decoder.received(data[500:] + data, 3.0)
    assert (one.arrival, two.arrival) == (1.0, 3.0)


def test_reset_forgets():
    decoder = LmsDecoder(Losses())
    decoder.sent(requests.stream(), 0.0)
    decoder.received(ACK + DONE + scan_bytes()[:50], 0.0)
    decoder.reset()
    assert decoder.received(scan_bytes()[50:] + scan_bytes(), 0.0) == []
