"""Scans of an RPLIDAR out of bytes: sorted, one turn each, whatever happens on the line."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import DATA, needs_recordings
from rplidar_room import room_feed
from rplidar_talk import SCANS, decoder_for, scans_of

import laserfeatures as lf
from laserfeatures.drivers import Sweep
from laserfeatures.drivers.rplidar.capsules import pack_capsule
from laserfeatures.drivers.rplidar.decoder import Started
from laserfeatures.drivers.rplidar.nodes import DEGREE, TURN, Measurements, pack_nodes
from laserfeatures.drivers.rplidar.packets import (
    Answer,
    Command,
    Configuration,
    Info,
    Key,
    SampleRate,
    build_reply,
    descriptor,
    request,
)
from laserfeatures.drivers.rplidar.turns import scan_of
from laserfeatures.emulators.rplidar import RPLidarDevice

INFO = build_reply(Info(0x18, (1, 29), 7, "00" * 16))


def turns(*measured):
    """Return the bytes of a standard scan of whole turns, and of the beginning of one more."""
    measured = [*measured, *[Measurements(*(column[:3] for column in measured[0]))]]
    frames = []
    for one in measured:
        starts = np.zeros(len(one.angles), bool)
        starts[0] = True
        frames.append(pack_nodes(one, starts))
    return b"".join(frames)


def turn(degrees, millimetres, quality=20):
    angles = np.rint(np.array(degrees) * 64).astype(int) * (DEGREE // 64)
    return Measurements(angles % TURN, np.array(millimetres, float), np.full(angles.size, quality))


def hear(data, decoder=None, answer=Answer.NODES):
    """Return what a decoder makes of a stream."""
    decoder = decoder or decoder_for()
    heard = decoder.received(INFO + descriptor(answer) + data, 100.0)
    assert isinstance(heard[0], Info)
    assert heard[1] == Started(answer)
    return [event.scan for event in heard[2:]], decoder


def test_a_clockwise_turn_becomes_a_scan_counter_clockwise():
    degrees = np.array([359.5, *np.arange(0.5, 359.0, 1.0)])
    (scan,), _ = hear(turns(turn(degrees, 1000 + degrees)))
    assert (np.diff(scan.angles) > 0).all()
    assert scan.angles[0] > -math.pi
    assert scan.angles[-1] <= math.pi
    back = np.degrees(-scan.angles) % 360
    np.testing.assert_allclose(scan.ranges * 1000, 1000 + back, atol=0.2)
    assert (scan.range_min, scan.range_max) == (0.15, 12.0)  # of an A1


@pytest.mark.parametrize(
    ("degrees", "expected"), [(0, 0), (90, -90), (180, 180), (270, 90), (359, 1)]
)
def test_where_angles_go(degrees, expected):
    scan = scan_of(turn([degrees], [1000]), (0.1, 10.0), 0.0, 1)
    assert scan.angles[0] == pytest.approx(math.radians(expected))


def test_no_echo_and_a_weak_one_are_no_returns():
    degrees = np.arange(0.0, 360.0, 1.0)
    measured = turn(degrees, np.where(degrees == 10, 0, 1000))
    measured.quality[20] = 0
    (scan,), _ = hear(turns(measured))
    lost = np.degrees(-scan.angles[np.isnan(scan.ranges)])
    np.testing.assert_allclose(sorted(lost), [10, 20])
    (scan,), _ = hear(turns(measured), decoder_for(min_quality=0))
    assert np.isnan(scan.ranges).sum() == 1


def test_measurements_of_one_angle_are_kept_apart():
    degrees = np.repeat(np.arange(0.0, 360.0, 2.0), 3)
    (scan,), _ = hear(turns(turn(degrees, np.arange(degrees.size) + 100)))
    assert len(scan) == degrees.size
    assert sorted(np.rint(scan.ranges * 1000)) == list(np.arange(degrees.size) + 100)


def test_a_turn_with_a_part_missing():
    for missing, delivered in ((60, 1), (80, 0)):  # degrees
        degrees = np.arange(0.0, 360.0 - missing, 1.0)
        scans, decoder = hear(turns(turn(degrees, np.full(degrees.size, 1000))))
        assert len(scans) == delivered
        assert decoder.losses.missed == 1 - delivered
    degrees = np.arange(0.0, 280.0)
    scans, _ = hear(turns(turn(degrees, np.full(280, 1000))), decoder_for(coverage=0.7))
    assert len(scans) == 1


def test_a_lost_start_flag_leaves_two_turns():
    one = turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000))
    data = bytearray(turns(one, one, one))
    data[360 * 5] ^= 3  # no start flag any more
    scans, _ = hear(bytes(data))
    assert [len(scan) for scan in scans] == [360, 360, 360]


def test_a_false_start_flag_does_not_cut_a_turn():
    one = turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000))
    data = bytearray(turns(one, one))
    data[200 * 5] ^= 3
    scans, _ = hear(bytes(data))
    assert [len(scan) for scan in scans] == [360, 360]


def test_a_wrong_angle_is_taken_out():
    one = turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000))
    data = bytearray(turns(one, one))
    data[100 * 5 + 2] ^= 0x20  # 64 degrees off
    scans, decoder = hear(bytes(data))
    assert [len(scan) for scan in scans] == [359, 360]
    assert decoder.losses.damaged == 1


@pytest.mark.parametrize(("jump", "delivered", "missed"), [(60, [360], 1), (0, [360, 360], 0)])
def test_a_gap_of_a_turn_or_more_does_not_join_two_turns(jump, delivered, missed):
    one = turns(turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000)))[: 360 * 5]
    _, decoder = hear(one + one[: 120 * 5])
    after = one[(120 + jump) * 5 :] + one + one[:50]  # without a jump it only came late
    late = decoder.received(after, 101.0)
    assert [len(event.scan) for event in late] == delivered
    assert decoder.losses.missed == missed


def test_the_stamp_is_the_time_of_the_first_measurement():
    one = turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000))
    decoder = decoder_for()
    decoder.received(build_reply(SampleRate(0.0005, 0.00025)), 99.0)
    scans, _ = hear(turns(one), decoder)
    # 362 measurements before the last byte came, which took 5 bytes on the line.
    assert scans[0].stamp == pytest.approx(100.0 - 362 * 0.0005 - 50 / 115_200, abs=1e-5)


def test_limits_and_period_as_the_device_tells_them():
    decoder = decoder_for()
    told = [(Key.MAX_DISTANCE, 8), (Key.SAMPLE_TIME, 1000)]
    one = turns(turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000)))
    decoder.received(INFO, 99.0)
    for key, value in told:
        reply = Configuration(key, (value * 256).to_bytes(4, "little"))
        assert decoder.received(build_reply(reply), 99.0) == [reply]
    (scan,) = [e.scan for e in decoder.received(descriptor(Answer.NODES) + one, 100.0)[1:]]
    assert (scan.range_min, scan.range_max) == (0.15, 8.0)
    assert scan.stamp == pytest.approx(100 - 0.362, abs=0.001)


def capsules(starts, distance=1000.0):
    return [
        pack_capsule(round(s * DEGREE), np.zeros(32, int), np.full(32, distance), first=i == 0)
        for i, s in enumerate(starts)
    ]


def test_a_capsule_before_a_lost_one_is_lost_too():
    starts = np.arange(0, 1200, 15.0) % 360
    whole = capsules(starts)
    scans, _ = hear(b"".join(whole), answer=Answer.CAPSULES)
    assert [len(scan) for scan in scans] == [768, 768]  # the first turn began before
    del whole[30]
    scans, decoder = hear(b"".join(whole), answer=Answer.CAPSULES)
    assert [len(scan) for scan in scans] == [704, 768]
    assert decoder.losses.damaged == 1  # the span over the gap is no usual one


def test_turns_end_though_the_capsules_at_the_front_are_lost():
    starts = np.arange(0, 1200, 15.0) % 360
    whole = capsules(starts)
    del whole[47:50]  # 345, 0 and 15 degrees
    scans, _ = hear(b"".join(whole), answer=Answer.CAPSULES)
    assert [len(scan) for scan in scans] == [22 * 32, 22 * 32]


@pytest.mark.parametrize(("jump", "delivered", "missed"), [(3, [768, 768], 1), (0, [768] * 3, 0)])
def test_a_gap_does_not_join_two_turns_of_capsules(jump, delivered, missed):
    whole = capsules(np.arange(0, 1500, 15.0) % 360)
    _, decoder = hear(b"".join(whole[:36]), answer=Answer.CAPSULES)
    late = decoder.received(b"".join(whole[36 + jump :]), 101.0)
    assert [len(event.scan) for event in late] == delivered
    assert decoder.losses.missed == missed


@pytest.mark.parametrize("mode", SCANS)
@pytest.mark.parametrize("chunk", [1, 7, 84, 5000])
def test_scans_do_not_depend_on_pieces(mode, chunk):
    device = RPLidarDevice(room_feed())
    device.power_on(0.0)
    device.give(SCANS[mode], 0.0)
    data = b"".join(device.take(t) for t in np.arange(0, 1.0, 0.01))
    heard = [decoder_for().received(data, 5.0)]
    decoder = decoder_for()
    pieces = [data[i : i + chunk] for i in range(0, len(data), chunk)]
    heard.append([event for piece in pieces for event in decoder.received(piece, 5.0)])
    one, other = (scans_of(events) for events in heard)
    assert len(one) == len(other) >= 3
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.angles, b.angles)
        np.testing.assert_array_equal(a.ranges, b.ranges)


def test_the_rest_of_an_old_stream_and_a_banner_are_not_counted():
    decoder = decoder_for()
    decoder.sent(request(Command.STOP), 0.0)
    decoder.received(b"\xa5\x5a\x05" * 40 + b"RP LIDAR System.\r\n", 0.0)
    decoder.received(bytes(3000), 0.1)
    assert len(decoder._buffer) < 300
    decoder.sent(request(Command.INFO), 0.2)
    assert decoder.received(INFO, 0.3) == [Info(0x18, (1, 29), 7, "00" * 16)]
    assert str(decoder.losses) == "none"


def test_a_request_ends_a_stream_for_the_decoder():
    _, decoder = hear(turns(turn(np.arange(0.0, 360.0, 1.0), np.full(360, 1000))))
    decoder.sent(request(Command.MOTOR_PWM, bytes(2)), 100.1)  # goes to the accessory board
    assert decoder._stream is not None
    decoder.sent(request(Command.STOP), 100.1)
    assert decoder.received(INFO, 100.2) == [Info(0x18, (1, 29), 7, "00" * 16)]


@settings(max_examples=200)
@given(
    st.lists(st.one_of(st.binary(max_size=200), st.sampled_from([INFO, *map(descriptor, (
        Answer.NODES, Answer.CAPSULES, Answer.ULTRA_CAPSULES, Answer.DENSE_CAPSULES,
    ))])), max_size=20),
    st.sampled_from(["", *SCANS]),
)  # fmt: skip
def test_any_bytes_are_taken(pieces, mode):
    decoder = decoder_for()
    for i, piece in enumerate(pieces):
        if mode:
            decoder.sent(SCANS[mode], float(i))
        for event in decoder.received(piece, float(i)):
            assert isinstance(event, Sweep | Started) or type(event).__module__.endswith("packets")


@needs_recordings
@pytest.mark.parametrize("name", ["tdt4856_points_8k_1.txt", "tdt4856_points_dekk_8k_1.txt"])
def test_real_measurements_come_through(name):
    path = DATA / "rplidar" / name
    rows = np.loadtxt(path, comments="#")
    with lf.open_source(path) as source:
        expected = next(iter(source))
    # A turn starts at the front; the files leave out what had no echo, there and elsewhere.
    rows = np.vstack(([0, 0, 0], np.roll(rows, -int(np.argmin(rows[:, 0])), axis=0)))
    data = turns(turn(rows[:, 0], rows[:, 1]))
    (scan,), _ = hear(data, decoder_for(coverage=0.1))
    seen = ~np.isnan(scan.ranges)
    assert seen.sum() == len(expected)
    np.testing.assert_allclose(scan.angles[seen], expected.angles, atol=math.radians(1 / 64))
    assert sorted(scan.ranges[seen]) == sorted(expected.ranges)
    # Neighbours may change places within the resolution of the angle.
    np.testing.assert_allclose(scan.ranges[seen], expected.ranges, atol=0.02)
