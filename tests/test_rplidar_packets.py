"""Requests, descriptors, replies and nodes of an RPLIDAR: the examples of its documents."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures.drivers.rplidar import packets
from laserfeatures.drivers.rplidar.nodes import (
    DEGREE,
    FINE,
    NODE,
    TURN,
    Measurements,
    in_sync,
    pack_nodes,
    unpack_nodes,
)
from laserfeatures.drivers.rplidar.packets import U16, Answer, Command, Key, request
from laserfeatures.errors import ProtocolError

REPLIES = [
    packets.Info(0x18, (1, 29), 7, "64E699F3C7E59AF0A2E69DF8F13735D0"),
    packets.Health(2, 0x8002),
    packets.SampleRate(508e-6, 254e-6),
    packets.BoardFlags(True),
    packets.Configuration(Key.NAME, b"Boost\0"),
]


@pytest.mark.parametrize(
    ("built", "expected"),
    [
        (request(Command.STOP), "A5 25"),
        (request(Command.RESET), "A5 40"),
        (request(Command.SCAN), "A5 20"),
        (request(Command.FORCE_SCAN), "A5 21"),
        (request(Command.EXPRESS_SCAN, bytes(5)), "A5 82 05 00 00 00 00 00 22"),
        (request(Command.EXPRESS_SCAN, bytes((3, 0, 0, 0, 0))), "A5 82 05 03 00 00 00 00 21"),
        (request(Command.INFO), "A5 50"),
        (request(Command.HEALTH), "A5 52"),
        (request(Command.SAMPLE_RATE), "A5 59"),
        (packets.ask_configuration(Key.MODES), "A5 84 04 70 00 00 00 55"),
        (packets.ask_configuration(Key.TYPICAL_MODE), "A5 84 04 7C 00 00 00 59"),
        (request(Command.MOTOR_PWM, U16.pack(660)), "A5 F0 02 94 02 C1"),
        (request(Command.MOTOR_PWM, U16.pack(0)), "A5 F0 02 00 00 57"),
        (request(Command.MOTOR_SPEED, U16.pack(600)), "A5 A8 02 58 02 55"),
        (request(Command.BOARD_FLAGS, bytes(4)), "A5 FF 04 00 00 00 00 5E"),
        (packets.descriptor(Answer.NODES), "A5 5A 05 00 00 40 81"),
        (packets.descriptor(Answer.CAPSULES), "A5 5A 54 00 00 40 82"),
        (packets.descriptor(Answer.INFO), "A5 5A 14 00 00 00 04"),
        (packets.descriptor(Answer.HEALTH), "A5 5A 03 00 00 00 06"),
        (packets.descriptor(Answer.SAMPLE_RATE), "A5 5A 04 00 00 00 15"),
    ],
)
def test_requests_and_descriptors_as_documented(built, expected):
    assert built == bytes.fromhex(expected)


def test_the_mode_of_a_configuration_request():
    asked = packets.ask_configuration(Key.SAMPLE_TIME, 0x0102)
    assert asked[:-1] == bytes.fromhex("A5 84 06 71 00 00 00 02 01")
    assert packets.next_request(asked) == (Command.CONFIGURATION, asked[3:-1], len(asked))


@pytest.mark.parametrize("reply", REPLIES, ids=lambda reply: type(reply).__name__)
def test_replies_come_back(reply):
    data = packets.build_reply(reply)
    head = packets.parse_descriptor(data)
    assert not head.stream
    assert head.length == len(data) - packets.DESCRIPTOR
    assert packets.parse_reply(head.kind, data[packets.DESCRIPTOR :]) == reply


def test_the_code_of_health_is_little_endian():
    assert packets.parse_reply(Answer.HEALTH, bytes((2, 0x01, 0x80))) == packets.Health(2, 0x8001)


@pytest.mark.parametrize(
    ("model", "series"), [(0x18, 1), (0x28, 2), (0x31, 3), (0x41, 4), (0x61, 6)]
)
def test_the_series_is_the_high_nibble_of_the_model(model, series):
    assert packets.Info(model, (1, 0), 0, "00" * 16).series == series


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "got nothing"),
        (b"\xa5\x5b\x05\0\0\x40\x81", "expected a descriptor"),
        (b"\xa5\x5a\x05\0\0\x40\x83", "0x83"),
        (b"\xa5\x5a\x06\0\0\x40\x81", "6 bytes"),
        (b"\xa5\x5a\x05\0\0\0\x81", "mode 0"),
    ],
)
def test_what_is_no_descriptor(data, problem):
    with pytest.raises(ProtocolError, match=problem):
        packets.parse_descriptor(data)


@given(st.binary(max_size=40), st.sampled_from(list(Answer)))
def test_parsers_raise_nothing_else(data, kind):
    for parse in (packets.parse_descriptor, lambda body: packets.parse_reply(kind, body)):
        try:
            parse(data)
        except ProtocolError:
            continue


@given(st.binary(max_size=60), st.sampled_from(list(Command)), st.binary(max_size=255))
def test_a_device_finds_requests(before, command, payload):
    before = before.replace(b"\xa5", b"")
    payload = payload if command & packets.HAS_PAYLOAD else b""
    asked = request(command, payload)
    for end in range(len(asked)):
        assert packets.next_request(before + asked[:end]) is None
    assert packets.next_request(before + asked + b"\xa5") == (
        command, payload, len(before) + len(asked)
    )  # fmt: skip


def test_a_request_with_a_wrong_checksum_has_no_payload():
    asked = request(Command.EXPRESS_SCAN, bytes(5))
    assert packets.next_request(asked[:-1] + b"\x23") == (Command.EXPRESS_SCAN, None, len(asked))


@pytest.mark.parametrize(
    ("start", "quality", "degrees", "millimetres", "expected"),
    [
        (True, 47, 90.0, 1234.5, "BD 01 2D 4A 13"),
        (False, 15, 359.5, 0.0, "3E C1 B3 00 00"),
    ],
)
def test_nodes_as_documented(start, quality, degrees, millimetres, expected):
    measured = Measurements(
        np.array([round(degrees * DEGREE)]), np.array([millimetres]), np.array([quality])
    )
    data = pack_nodes(measured, np.array([start]))
    assert data == bytes.fromhex(expected)
    assert in_sync(data)
    assert data[0] & 1 == start
    for got, put in zip(unpack_nodes(data), measured, strict=True):
        assert got == put


@given(
    st.lists(
        st.tuples(
            st.integers(0, TURN // FINE - 1),
            st.integers(0, 0xFFFF),
            st.integers(0, 63),
            st.booleans(),
        ),
        min_size=1,
        max_size=50,
    )
)
def test_nodes_come_back(values):
    angles, quarters, quality, starts = map(np.array, zip(*values, strict=True))
    measured = Measurements(angles * FINE, quarters / 4, quality)
    data = pack_nodes(measured, starts)
    assert all(in_sync(data[i : i + 2]) for i in range(0, len(data), NODE))
    for got, put in zip(unpack_nodes(data), measured, strict=True):
        np.testing.assert_array_equal(got, put)


def test_what_does_not_fit_a_node_is_no_return():
    far = Measurements(np.zeros(2, int), np.array([16384.0, -3.0]), np.zeros(2, int))
    assert not unpack_nodes(pack_nodes(far, np.zeros(2, bool))).distances.any()
    with pytest.raises(ProtocolError, match="7 bytes"):
        unpack_nodes(bytes(7))
