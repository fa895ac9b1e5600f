"""The emulated LMS2xx, byte for byte and in virtual time."""

import re

import numpy as np
import pytest
from lms_lines import Numbered, host, playing, session, wall
from recordings import needs_recordings

from laserfeatures import LaserScan
from laserfeatures.drivers.lms import (
    Telegram,
    pack,
    pack_request,
    parse,
    parse_measurement,
    requests,
)
from laserfeatures.drivers.lms.ranges import to_ranges
from laserfeatures.drivers.lms.status import parse_status
from laserfeatures.emulators.lms import Memory

DONE = pack(Telegram(0xA0, b"\0"))
REFUSED = b"\x06" + pack(Telegram(0x92, b""))
CALIBRATION = slice(130, 146)  # in the data of a B1: measured anew each time


def telegrams(heard):
    """Return the telegrams in what was heard; nothing else may be in it."""
    found = []
    while heard:
        size = int.from_bytes(heard[2:4], "little") + 6
        found.append(parse(heard[:size]))
        heard = heard[size:]
    return found


def feed_of(lines):
    scans = []
    for _, _, data in lines:
        if data[4] == 0xB0:
            ranges = to_ranges(parse_measurement(parse(data)).words, 4, 1)
            scans.append(LaserScan.uniform(ranges, -np.pi / 2, np.radians(0.5)))
    return playing(scans)


@needs_recordings
def test_the_real_session_again():
    lines = session()
    scanner = host(feed_of(lines))
    asked = [i for i, line in enumerate(lines) if line[1] == "TX"]
    for i, end in zip(asked, [*asked[1:], len(lines)], strict=True):
        time, _, request = lines[i]
        replies = lines[i + 1 : end]
        scanner.send(request)
        heard = scanner.listen(replies[-1][0] - time + 0.01)
        assert heard[:1] == b"\x06"
        at = 1
        for _, _, reply in replies:
            check(reply, heard[at : at + len(reply)])
            at += len(reply)
        assert at == len(heard)
    assert scanner.device.baud == 9600


def check(real, emulated):
    """Compare telegrams but for what no emulator can know: why there was no return."""
    telegram = parse(real)
    if telegram.command == 0xB1:
        own = parse(emulated)
        cleared = [bytearray(t.data) for t in (telegram, own)]
        for data in cleared:
            data[CALIBRATION] = bytes(16)
        assert cleared[0] == cleared[1]
    elif telegram.command == 0xB0:
        words = parse_measurement(telegram).words.copy()
        words[words >= 0x3FF7] = 0x3FFF
        assert parse_measurement(parse(emulated)).words.tolist() == words.tolist()
        assert emulated[:7] == real[:7]
    else:
        assert emulated == real


def test_replies_of_the_listing():
    scanner = host(memory=Memory(device_type=b"LMS200;301063;V02.10 "))
    assert scanner.ask(0x32) == b"\x06" + bytes.fromhex("02 80 02 00 B2 10 3F 13")
    assert scanner.ask(0x3A) == b"\x06" + bytes.fromhex(
        "02 80 17 00 BA" + b"LMS200;301063;V02.10 ".hex() + "10 22 61"
    )
    assert scanner.ask(0x3B, bytes.fromhex("B4003200")) == b"\x06" + bytes.fromhex(
        "02 80 07 00 BB 01 B4 00 32 00 10 03 9D"
    )
    assert scanner.ask(0x3B, bytes.fromhex("B4001900")) == b"\x06" + bytes.fromhex(
        "02 80 07 00 BB 00 B4 00 32 00 10 23 8D"
    )
    assert scanner.ask(0x66, b"\1") == b"\x06" + bytes.fromhex("02 80 04 00 E6 01 01 10 CF FD")
    assert scanner.ask(0x66, b"\0") == b"\x06" + bytes.fromhex("02 80 04 00 E6 01 00 10 CD FC")
    reset = scanner.ask(0x10, seconds=2)
    assert reset[:9] == b"\x06" + bytes.fromhex("02 80 02 00 91 10 79 30")
    assert reset[9:] == bytes.fromhex(
        "02 80 17 00 90" + b"LMS200;301063;V02.10 ".hex() + "10 63 5E"
    )


def test_it_says_so_when_it_is_up_at_9600_bd():
    scanner = host(start="booting", start_up=30.0)
    scanner.send(pack_request(0x31))
    assert scanner.listen(30.0) == b""
    assert [t.command for t in telegrams(scanner.listen(0.1))] == [0x90]


def test_a_kept_baud_rate_survives_and_a_session_one_does_not():
    scanner = host(start_up=0.1)
    scanner.ask(0x20, b"\x48")
    assert scanner.device.baud == 500_000
    scanner.ask(0x10, seconds=0.5)
    assert scanner.device.baud == 9600
    scanner.ask(0x20, b"\x40")
    scanner.ask(0x66, b"\1")
    scanner.ask(0x10, seconds=0.5)
    assert scanner.device.baud == 38400
    status = parse_status(telegrams(scanner.ask(0x31)[1:])[0].data)
    assert (status.baud, status.keeps_baud) == (38400, 1)


def test_the_reply_comes_at_the_old_rate():
    scanner = host()
    scanner.send(requests.session_baud(500_000))
    heard = bytearray()
    while scanner.device.baud == 9600:
        heard += scanner.device.take(scanner.now, 9600)
        scanner.now += 0.001
    assert bytes(heard) == b"\x06" + DONE
    assert 0.06 < scanner.now < 0.12  # a real one took 82 ms


@pytest.mark.parametrize("address", [0x00, 0x01])
def test_wrong_checksums_and_other_addresses(address):
    scanner = host()
    request = pack_request(0x31, address=address)
    scanner.send(request[:-1] + b"\0")
    assert scanner.listen(1.0) == b"\x15"
    scanner.send(pack_request(0x31, address=5))
    assert scanner.listen(1.0) == b""
    scanner.send(request)
    assert len(scanner.listen(1.0)) == 161


@pytest.mark.parametrize(("pause", "answers"), [(0.005, True), (0.008, False)])
def test_bytes_must_not_be_more_than_6_ms_apart(pause, answers):
    scanner = host()
    for byte in pack_request(0x3A):
        scanner.send(bytes([byte]))
        scanner.listen(pause)
    assert bool(scanner.listen(1.0)) == answers


def test_half_a_request_does_not_spoil_the_next():
    scanner = host()
    scanner.send(pack_request(0x31)[:4])
    scanner.listen(0.01)
    assert scanner.ask(0x32)[:1] == b"\x06"


def test_writing_needs_the_installation_mode_and_the_right_length():
    scanner = host()
    read = scanner.device.memory.configuration
    changed = read[:5] + b"\6" + read[6:]
    assert scanner.ask(0x77, changed) == REFUSED
    assert scanner.ask(0x20, b"\0SICK_LMX")[1:] == pack(Telegram(0xA0, b"\1"))
    assert scanner.ask(0x20, b"\0SICK_LMS")[1:] == DONE
    assert scanner.ask(0x77, changed[:32]) == REFUSED
    assert scanner.ask(0x77, read[:6] + b"\7" + read[7:])[1:] == pack(Telegram(0xF7, b"\0" + read))
    assert scanner.device.memory.writes == 0
    assert scanner.ask(0x77, changed)[1:] == pack(Telegram(0xF7, b"\1" + changed))
    assert scanner.ask(0x74)[1:] == pack(Telegram(0xF4, changed))
    assert scanner.device.memory.writes == 1


def test_the_fast_type_refuses_other_fields_of_view():
    memory = Memory(device_type=b"LMS291;S14   ;V02.20 ", angle=90)
    scanner = host(memory=memory)
    assert scanner.ask(0x3B, bytes.fromhex("64003200")) == REFUSED
    scanner.ask(0x20, b"\x24", seconds=0.1)
    scanner.listen(5.0)
    assert scanner.device._measuring.scan_time == 0.01332


@pytest.mark.parametrize("request_", ["35", "7B", "2099", "20", "3701", "360100", "00", "3100"])
def test_unknown_requests_are_refused(request_):
    data = bytes.fromhex(request_)
    assert host().ask(data[0], data[1:]) == REFUSED


@pytest.mark.parametrize("baud", [9600, 38400, 500_000])
@pytest.mark.parametrize(
    ("angle", "resolution", "size"), [(180, 100, 372), (180, 50, 732), (100, 25, 812)]
)
def test_the_stream_keeps_to_whole_scans(baud, angle, resolution, size):
    memory = Memory(angle=angle, resolution=resolution)
    scanner = host(Numbered(), memory=memory, baud=baud, start="streaming")
    scan_time = 1.332 / resolution
    period = np.ceil(size * 10 / baud / scan_time) * scan_time
    scanner.listen(2.0)
    before = len(scanner.device.frames)
    assert all(t.command == 0xB0 for t in telegrams_in(scanner, 10 * period, size))
    assert len(scanner.device.frames) - before == pytest.approx(10, abs=1)


def telegrams_in(scanner, seconds, size):
    heard = scanner.listen(seconds)
    start = re.search(b"\x02\x80" + (size - 6).to_bytes(2, "little") + b"\xb0", heard).start()
    whole = (len(heard) - start) // size
    return [parse(heard[start + i * size :][:size]) for i in range(whole)]


def test_the_period_of_the_real_scanner():
    scanner = host(baud=38400, start="streaming")
    scanner.listen(213.12)
    assert len(scanner.device.frames) == pytest.approx(1000, abs=1)


def test_a_request_cuts_off_a_scan_and_the_stream_goes_on():
    scanner = host(Numbered(), baud=38400, start="streaming")
    scanner.listen(0.1)
    heard = scanner.ask(0x3A, seconds=0.6)
    cut, _, rest = heard.partition(b"\x06\x02\x80\x17\x00\xba")
    assert len(cut) < 100
    scans = telegrams(rest[24:][: 2 * 732])
    assert [t.command for t in scans] == [0xB0, 0xB0]
    assert [fault for _, fault in scanner.device.frames][:2] == ["cut off by a request", None]


def test_partial_scans_in_turn():
    scanner = host(baud=500_000, memory=Memory(angle=100, resolution=25))
    heard = scanner.ask(0x20, b"\x2a", seconds=0.2)
    found = [parse_measurement(t) for t in telegrams_whole(heard[10:])]
    assert [m.partial for m in found[:5]] == [0, 1, 2, 3, 0]
    assert [m.words.size for m in found[:5]] == [101, 100, 100, 100, 101]


def telegrams_whole(heard):
    found = []
    while len(heard) > 6 and len(heard) >= int.from_bytes(heard[2:4], "little") + 6:
        size = int.from_bytes(heard[2:4], "little") + 6
        found.append(parse(heard[:size]))
        heard = heard[size:]
    return found


@pytest.mark.parametrize(
    ("request_", "command", "count", "mean"),
    [
        (requests.one_scan(), 0xB0, 361, 1),
        (requests.one_scan(mean=3), 0xB6, 361, 3),
        (requests.one_scan(first=10, last=19), 0xB7, 10, 1),
        (pack_request(0x30, b"\x08"), 0xB0, 181, 1),
    ],
)
def test_scans_on_request(request_, command, count, mean):
    scanner = host()
    scanner.send(request_)
    (telegram,) = telegrams(scanner.listen(2.0)[1:])
    measurement = parse_measurement(telegram)
    assert (telegram.command, measurement.words.size, measurement.mean) == (command, count, mean)
    assert set(measurement.words) == {3000}


def test_index_bytes_and_status_byte():
    scanner = host(baud=500_000, start="streaming", status=0xD2)
    scanner.device.memory.configuration = b"\0\0\0\0\2\4\1" + bytes(27)
    found = telegrams_whole(scanner.listen(20.0))
    assert {t.status for t in found} == {0xD2}
    indices = np.array([parse_measurement(t).indices for t in found])
    assert set(np.diff(indices[:, 0]) % 256) == {2}
    assert set(np.diff(indices[:, 1]) % 256) == {1}


def test_protocol_faults_on_demand():
    scanner = host(bad_crc=0.5, lookalike=True, glued=True, reply_address=0x81, seed=1,
                   baud=500_000, start="streaming")  # fmt: skip
    heard = scanner.listen(3.0)
    assert heard.count(DONE) == pytest.approx(113, abs=3)  # among the values
    faults = [fault for _, fault in scanner.device.frames]
    good = heard.count(b"\x02\x81\xd6\x02\xb0")
    assert good == pytest.approx(len(faults), abs=2)
    assert 0.3 < faults.count("bad_crc") / len(faults) < 0.7
    deaf = host(deaf=1.0)
    assert deaf.ask(0x31) == b""
    hanging = host(wall, hangs_after=2, baud=38400, start="streaming")
    assert len(hanging.listen(5.0)) == 2 * 732 + 366
    assert hanging.ask(0x3A)[:2] == b"\x06\x02"
