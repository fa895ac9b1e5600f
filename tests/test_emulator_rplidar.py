"""The emulated RPLIDAR by itself, in virtual time: its answers, states and timing."""

import numpy as np
import pytest
from rplidar_room import room_feed, true_ranges

from laserfeatures.drivers.rplidar import packets
from laserfeatures.drivers.rplidar.capsules import capsule_fits, start_of
from laserfeatures.drivers.rplidar.nodes import DEGREE, NODE, in_sync, unpack_nodes
from laserfeatures.drivers.rplidar.packets import U16, Answer, Command, Key, request
from laserfeatures.emulators.rplidar import MODELS, RPLidarDevice
from laserfeatures.emulators.rplidar.device import BOOT


def device_of(**parameters):
    device = RPLidarDevice(room_feed(), **parameters)
    device.power_on(0.0)
    return device


def ask(device, asked, now=1.0, seconds=0.05):
    """Return what a device says within some seconds after a request."""
    device.give(asked, now)
    return b"".join(device.take(t) for t in np.arange(now, now + seconds, 0.001))


@pytest.mark.parametrize(
    ("asked", "expected"),
    [
        (Command.INFO, "A5 5A 14 00 00 00 04 18 1D 01 07"),
        (Command.HEALTH, "A5 5A 03 00 00 00 06 00 00 00"),
        (Command.SAMPLE_RATE, "A5 5A 04 00 00 00 15 FC 01 FE 00"),  # 508 and 254 us
        (Command.SCAN, "A5 5A 05 00 00 40 81"),
        (Command.FORCE_SCAN, "A5 5A 05 00 00 40 81"),
    ],
)
def test_answers(asked, expected):
    assert ask(device_of(), request(asked)).startswith(bytes.fromhex(expected))


@pytest.mark.parametrize(
    "payload", ["70", "7C", "71 02", "74 00", "75 01", "7F 02", "01", "04", "05", "99"]
)
def test_configuration(payload):
    expected = {
        "70": "03 00", "7C": "02 00", "71 02": "00 7F 00 00", "74 00": "00 0C 00 00",
        "75 01": "82", "7F 02": "42 6F 6F 73 74 00", "01": "58 02 94 02", "99": "",
        "04": "C8 00", "05": "B0 04",
    }[payload]  # fmt: skip
    key, *mode = bytes.fromhex(payload)
    sent = packets.U32.pack(key) + b"".join(map(U16.pack, mode))
    for padding in (0, 30 if mode else 32):  # the vendor's library sends 36 bytes
        answer = ask(device_of(), request(Command.CONFIGURATION, sent + bytes(padding)))
        head = packets.parse_descriptor(answer)
        body = answer[packets.DESCRIPTOR :]
        assert len(body) == head.length
        assert body == packets.U32.pack(key) + bytes.fromhex(expected)


def test_what_is_not_known_is_ignored():
    device = device_of()
    for asked in (
        request(Command.BOARD_FLAGS, bytes(4)),  # an A1 has no accessory board
        b"\xa5\x77",
        b"\xa5\xb0\x01\x00\x14",
        request(Command.EXPRESS_SCAN, bytes(5))[:-1] + b"\x23",  # wrong checksum
        request(Command.EXPRESS_SCAN, bytes((9, 0, 0, 0, 0))),  # no such mode
        b"hello",
    ):
        assert not ask(device, asked)
    assert ask(device, request(Command.HEALTH), 2.0)
    old = device_of(troubles=["old_firmware"])
    assert not ask(old, packets.ask_configuration(Key.MODES))


def test_a_request_in_pieces():
    device = device_of()
    for byte in request(Command.INFO):
        device.give(bytes((byte,)), 1.0)
    assert len(ask(device, b"")) == 27


def test_a_standard_scan_in_the_devices_own_time():
    device = device_of()
    data = ask(device, request(Command.SCAN), seconds=2.0)[packets.DESCRIPTOR :]
    nodes = [data[i : i + NODE] for i in range(0, len(data) - 4, NODE)]
    assert all(map(in_sync, nodes))
    assert len(nodes) == pytest.approx(2.0 / 508e-6, rel=0.01)
    starts = [i for i, node in enumerate(nodes) if node[0] & 1]
    assert np.diff(starts) == pytest.approx(1 / 7 / 508e-6, rel=0.01)
    measured = unpack_nodes(b"".join(nodes))
    degrees = measured.angles / DEGREE
    assert abs((degrees[starts] + 180) % 360 - 180).max() < 5
    steps = (np.diff(degrees) + 180) % 360 - 180
    assert steps.std() > 0.3  # irregular
    assert (steps < 0).any()  # even backwards
    np.testing.assert_allclose(measured.distances, true_ranges(degrees), atol=0.2)


def test_no_byte_comes_faster_than_the_line():
    device = device_of()
    device.give(request(Command.EXPRESS_SCAN, bytes((2, 0, 0, 0, 0))), 0.0)
    sizes = [len(device.take(t)) for t in np.arange(0.0, 1.0, 0.01)]
    assert max(sizes) <= 0.0101 * 11_520 + 1
    assert sum(sizes) == pytest.approx(132 / 96 / 127e-6, rel=0.05)


@pytest.mark.parametrize(("mode", "kind"), [(0, Answer.CAPSULES), (1, Answer.CAPSULES)])
def test_the_first_capsule_of_a_stream_is_marked(mode, kind):
    device = device_of()
    data = ask(device, request(Command.EXPRESS_SCAN, bytes((mode, 0, 0, 0, 0))), seconds=0.5)
    assert packets.parse_descriptor(data).kind is kind
    data = data[packets.DESCRIPTOR :]
    capsules = [data[i : i + 84] for i in range(0, len(data) - 83, 84)]
    assert all(map(capsule_fits, capsules))
    assert [start_of(capsule)[1] for capsule in capsules] == [True] + [False] * (len(capsules) - 1)
    starts = np.array([start_of(capsule)[0] for capsule in capsules]) / DEGREE
    assert np.diff(starts) % 360 == pytest.approx(32 * 254e-6 * 7 * 360, rel=0.01)
    thetas = [capsule[i] & 3 for capsule in capsules for i in range(4, 84, 5)]
    assert max(thetas) <= 1  # the bit that readers take differently is never set


def test_stop_and_any_request_end_a_scan():
    for asked, answer in ((Command.STOP, b""), (Command.HEALTH, b"\xa5\x5a\x03")):
        device = device_of()
        assert len(ask(device, request(Command.SCAN), 1.0, 0.5)) > 4000
        ask(device, request(asked), 1.5, 0.1)
        assert not ask(device, b"", 1.7, 0.3)
        assert device._stream is None
        device = device_of()
        ask(device, request(Command.SCAN), 1.0, 0.5)
        assert answer in ask(device, request(asked), 1.5, 0.1)


def test_a_reset_ends_in_a_banner():
    device = device_of(start="protection")
    assert ask(device, request(Command.HEALTH))[7:] == bytes((2, 0x02, 0x80))
    assert not ask(device, request(Command.SCAN))
    assert not ask(device, request(Command.RESET), 2.0, BOOT - 0.01)
    assert not ask(device, request(Command.INFO), 2.0 + BOOT / 2, 0.01)  # deaf
    assert ask(device, b"", 2.0 + BOOT, 0.1).startswith(b"RP LIDAR System.")
    assert ask(device, request(Command.HEALTH), 3.0)[7:] == bytes(3)
    assert ask(device, request(Command.SCAN), 3.1)


def test_a_motor_that_stands_refuses_a_scan_without_a_word():
    device = device_of(model="A2")
    assert not ask(device, request(Command.SCAN))
    assert ask(device, request(Command.BOARD_FLAGS, bytes(4)))[7:] == bytes((1, 0, 0, 0))
    assert not ask(device, request(Command.MOTOR_PWM, U16.pack(660)))
    assert ask(device, request(Command.SCAN), 2.0, 0.2)
    assert len(ask(device, request(Command.MOTOR_PWM, U16.pack(660)), 2.2, 0.1)) > 500  # goes on
    ask(device, request(Command.MOTOR_PWM, U16.pack(0)), 2.4)
    assert not ask(device, b"", 2.5)


@pytest.mark.parametrize("start", ["streaming", "express"])
def test_a_stream_left_by_a_crashed_host_begins_in_mid_frame(start):
    device = device_of(start=start)
    data = ask(device, b"", 0.0, 0.1)
    assert len(data) > 500
    assert not (in_sync(data) and in_sync(data[5:]) and in_sync(data[10:]))
    assert packets.ANSWER not in data[:7]


def test_the_hosts_rate_matters():
    device = device_of()
    device.give(request(Command.INFO), 1.0, 9600)
    assert not device.take(1.1)
    device.give(request(Command.INFO), 1.2, 115_200)
    garbled = device.take(1.3, 9600)
    assert len(garbled) == 27
    assert packets.ANSWER not in garbled


@pytest.mark.parametrize("model", MODELS)
def test_every_mode_fits_through_the_line(model):
    chosen = MODELS[model]
    for mode in chosen.modes:
        samples = {Answer.NODES: 1, Answer.CAPSULES: 32, Answer.ULTRA_CAPSULES: 96}.get(
            mode.answer, 40
        )
        assert packets.LENGTHS[mode.answer] / samples / mode.period * 10 < chosen.baud


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"model": "A4"}, "no model 'A4'"),
        ({"start": "asleep"}, "no start state 'asleep'"),
        ({"troubles": ["rain"]}, "no trouble 'rain'"),
    ],
)
def test_what_cannot_be_emulated(parameters, problem):
    with pytest.raises(ValueError, match=problem):
        RPLidarDevice(room_feed(), **parameters)
