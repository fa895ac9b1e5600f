"""From bytes to scans: the decoder, whatever happens to the bytes."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import needs_recordings
from urg_lines import Piece, conversation, decoded, number_of, numbered, real_session

from laserfeatures.drivers import Halt, Losses, Sweep
from laserfeatures.drivers.urg.commands import Measurement
from laserfeatures.drivers.urg.decoder import UrgDecoder
from laserfeatures.drivers.urg.ranges import encode_block, encode_time
from laserfeatures.drivers.urg.scip import encode_reply, with_key_sum
from laserfeatures.emulators.urg import UrgDevice

STREAM = b"MD0044072501000"
FIELDS = {b"DMIN": 20, b"DMAX": 5600, b"ARES": 1024, b"AMIN": 44, b"AMAX": 725}
FIELDS |= {b"AFRT": 384, b"SCAN": 600}
PP = encode_reply(b"PP", b"00", b"".join(with_key_sum(b"%s:%d" % item) for item in FIELDS.items()))


def frame(time, value=1000, command=STREAM, count=682):
    body = encode_time(time % (1 << 24)) + encode_block(np.full(count, value), 3)
    return encode_reply(command, b"99", body)


def streaming(command=STREAM):
    """Return a decoder of a stream that has just been accepted."""
    decoder = UrgDecoder(Losses())
    decoder.sent(b"PP\n", 0.0)
    decoder.received(PP, 0.0)
    decoder.sent(command + b"\n", 0.0)
    decoder.received(encode_reply(command, b"00"), 0.0)
    decoder.losses.frames = 0
    return decoder


def scans_of(found):
    return [message.scan for message in found if isinstance(message, Sweep)]


@needs_recordings
def test_the_real_session_gives_its_scan():
    found, losses = decoded(real_session())
    (scan,) = scans_of(found)
    assert losses.counts() == Losses().counts()
    assert len(scan) == 682
    assert (scan.range_min, scan.range_max) == (0.02, 5.6)
    assert int(np.isnan(scan.ranges).sum()) == 94 + 6 + 1
    assert (scan.ranges[scan.valid].min(), scan.ranges[scan.valid].max()) == (0.076, 4.166)
    assert np.degrees(scan.angles[[0, 340, -1]]) == pytest.approx([-119.53, 0, 119.88], abs=0.01)


def test_a_stream_of_the_emulator():
    found, losses = decoded(conversation(UrgDevice(numbered()), 1.05))
    scans = scans_of(found)
    assert [number_of(scan) for scan in scans] == list(range(len(scans)))
    assert len(scans) == 12
    assert np.diff([scan.stamp for scan in scans]) == pytest.approx(0.1)
    assert all(np.isnan(scan.ranges[300:350]).all() for scan in scans)
    assert losses.counts() == Losses().counts()


SESSION = conversation(UrgDevice(numbered()), 0.5)
BYTES = b"".join(piece.data for piece in SESSION if piece.direction == "RX")


def heard(cuts):
    """Return the scans of the whole session, received at one time in pieces."""
    decoder = UrgDecoder(Losses())
    decoder.sent(b"PP\n" + STREAM + b"\n", 0.0)
    places = [0, *sorted(cuts), len(BYTES)]
    pieces = [BYTES[a:b] for a, b in pairwise(places)]
    scans = scans_of([message for piece in pieces for message in decoder.received(piece, 5.0)])
    return [(scan.stamp, scan.ranges.tobytes()) for scan in scans], decoder.losses


@settings(max_examples=50, deadline=None)
@given(st.lists(st.integers(0, len(BYTES)), max_size=60))
def test_pieces_of_any_size_give_the_same_scans(cuts):
    assert heard(cuts) == heard([])


def test_byte_by_byte_gives_the_same_scans():
    assert heard(range(len(BYTES))) == heard([])
    assert len(heard([])[0]) == 7


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2140), st.binary(max_size=30), st.sampled_from([0, 1, 2137]))
def test_a_damaged_frame_costs_no_other(place, noise, lost):
    decoder = streaming()
    damaged = frame(200)[:place] + noise + frame(200)[place + lost :]
    data = frame(100, 1001) + damaged + frame(300, 1003) + frame(400, 1004)
    scans = scans_of(decoder.received(data, 0.4))
    values = [round(float(scan.ranges[0]) * 1000) for scan in scans]
    assert values in ([1001, 1003, 1004], [1001, 1000, 1003, 1004])
    assert all(np.ptp(scan.ranges) == 0 for scan in scans)


def test_no_single_bit_slips_through_and_neither_does_a_lost_or_doubled_byte():
    whole = frame(200)
    variants = [
        whole[:i] + bytes([whole[i] ^ 1 << bit]) + whole[i + 1 :]
        for i in [*range(40), *range(41, len(whole), 7)]
        for bit in range(8)
    ]
    variants += [whole[:i] + whole[i + 1 :] for i in range(len(whole))]
    variants += [whole[: i + 1] + whole[i:] for i in range(1, len(whole) - 2)]
    decoder = streaming()
    for variant in variants:
        decoder.reset()
        decoder.sent(STREAM + b"\n", 0.0)
        decoder.received(PP, 0.0)
        assert not scans_of(decoder.received(variant + b"x\n\n", 0.0))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.binary(max_size=200) | st.sampled_from([PP, frame(0), STREAM, b"\n\n"])))
def test_any_bytes_are_taken(pieces):
    decoder = streaming()
    for i, piece in enumerate(pieces):
        decoder.sent(piece, i)
        decoder.received(piece, i)


def test_memory_is_bounded():
    decoder = streaming()
    for _ in range(100):
        decoder.received(b"x" * 4096, 0.0)
        decoder.sent(b"x" * 4096, 0.0)
    assert len(decoder._framer._buffer) <= 1 << 15
    assert decoder.losses.garbage > 300_000
    assert len(scans_of(decoder.received(b"\n\n" + frame(100), 0.0))) == 1


def test_lost_scans_are_counted_by_time_and_skip():
    decoder = streaming(b"MD0044072501100")
    for time in (1000, 1200, 1401, 2000, 2199):
        decoder.received(frame(time, command=b"MD0044072501100"), time / 1000)
    assert (decoder.losses.missed, decoder.losses.frames) == (2, 5)


def test_the_clock_may_wrap():
    decoder = streaming()
    times = [(1 << 24) - 150 + 100 * i for i in range(5)]
    scans = [scans_of(decoder.received(frame(t), i / 10))[0] for i, t in enumerate(times)]
    assert np.diff([scan.stamp for scan in scans]) == pytest.approx(0.1)
    assert decoder.losses.missed == 0


def test_a_standing_clock_is_refused_and_ends_the_stream():
    decoder = streaming()
    found = [decoder.received(frame(time), 0.1) for time in (100, 200, 200, 200, 200)]
    assert [len(scans_of(messages)) for messages in found] == [1, 1, 0, 0, 0]
    assert decoder.losses.damaged == 3
    (halt,) = found[-1]
    assert isinstance(halt, Halt)
    assert "stands still" in halt.reason


@pytest.mark.parametrize("wrong", [100, 60_000])
def test_an_impossible_time_costs_its_scan_only(wrong):
    decoder = streaming()
    found = [decoder.received(frame(t), i / 10) for i, t in enumerate((1000, 1100, wrong, 1300))]
    assert [len(scans_of(messages)) for messages in found] == [1, 1, 0, 1]
    assert (decoder.losses.damaged, decoder.losses.missed) == (1, 1)


def test_a_check_pauses_and_a_fault_halts():
    decoder = streaming()
    for status in (b"21", b"98"):
        found = decoder.received(encode_reply(STREAM, status), 1.0)
        assert not any(isinstance(message, Halt) for message in found)
    assert decoder.losses.refusals == 1
    found = decoder.received(encode_reply(STREAM, b"51"), 2.0)
    assert isinstance(found[-1], Halt)
    assert "51" in found[-1].reason


def test_an_answer_inside_a_scan_costs_that_scan():
    decoder = streaming()
    answer = encode_reply(b"II", b"00", with_key_sum(b"STAT:Sensor works well."))
    whole = frame(200)
    split = whole[:777] + answer + whole[777:]
    found = decoder.received(frame(100) + split + frame(300), 0.3)
    assert [type(message).__name__ for message in found] == ["Sweep", "Reply", "Sweep"]
    assert decoder.losses.damaged == 1


def test_another_hosts_stream_is_no_scan():
    decoder = streaming(b"MD0044072501100")
    found = decoder.received(frame(100), 0.1)
    assert len(found) == 1
    assert not scans_of(found)


def test_short_ranges_end_where_two_characters_do():
    decoder = streaming(b"MS0044072501000")
    body = encode_time(5) + encode_block(np.full(682, 4095), 2)
    (scan,) = scans_of(decoder.received(encode_reply(b"MS0044072501000", b"99", body), 0.0))
    assert scan.range_max == 4.095
    assert not scan.valid.any()


def test_the_stamp_is_that_of_the_first_ray():
    command = Measurement("MD", 300, 400, 2).encode()
    pieces = [Piece(0.0, "TX", b"PP\nTM0\nTM1\n"), Piece(0.0, "RX", PP)]
    pieces += [Piece(0.002, "RX", encode_reply(b"TM1", b"00", encode_time(5000)))]
    pieces += [Piece(0.0, "TX", command + b"\n")]
    pieces += [Piece(1.1, "RX", frame(6000, command=command, count=51))]
    found, _ = decoded(pieces)
    (scan,) = scans_of(found)
    # TM1 tells 5.0005 s at 0.001 s, in the mean
    assert scan.stamp == pytest.approx(1.0005 + 300 * 97.65625e-6)
    assert np.degrees(scan.angles[0]) == pytest.approx((300.5 - 384) * 360 / 1024)
