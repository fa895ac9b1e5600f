"""The frames of the LD19, against the worked example of its manual."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from laserfeatures import ProtocolError
from laserfeatures.drivers.ld19.decoder import Ld19Decoder
from laserfeatures.drivers.ld19.frames import SIZE, Frame, crc8, decode, encode
from laserfeatures.drivers.ld19.turns import Turns
from laserfeatures.drivers.losses import Losses

MANUAL = bytes.fromhex(
    "54 2C 68 08 AB 7E E0 00 E4 DC 00 E2 D9 00 E5 D5 00 E3 D3 00 E4 D0 00 E9 CD 00 E4 CA 00 E2 "
    "C7 00 E9 C5 00 E5 C2 00 E5 C0 00 E5 BE 82 3A 1A 50"
)


def following(frame, gap=0):
    """Return the frame that follows one, `gap` frames later."""
    width = (frame.end - frame.start) % 36_000
    start = (frame.start + width * 12 * (gap + 1) // 11) % 36_000
    time = (frame.time + round(width * 12 / 11 * (gap + 1) / frame.speed * 10)) % 30_000
    end = (start + width) % 36_000
    return Frame(frame.speed, start, end, frame.ranges, frame.intensities, time)


def in_a_row(count):
    row = [decode(MANUAL)]
    while len(row) < count:
        row.append(following(row[-1]))
    return [encode(frame) for frame in row]


frames = st.builds(
    lambda speed, start, width, points, time: Frame(
        speed=speed,
        start=start,
        end=(start + width) % 36_000,
        ranges=np.array([r for r, _ in points], dtype=np.uint16),
        intensities=np.array([i for _, i in points], dtype=np.uint8),
        time=time,
    ),
    st.integers(0, 65535),
    st.integers(0, 35_999),
    st.integers(0, 4500),
    st.lists(st.tuples(st.integers(0, 65535), st.integers(0, 255)), min_size=12, max_size=12),
    st.integers(0, 29_999),
)


def decoder():
    losses = Losses()
    return Ld19Decoder(losses, Turns(losses, 12.0, 0), 230_400)


def frames_in(messages):
    return [encode(message) for message in messages if isinstance(message, Frame)]


def test_the_manuals_example_decodes():
    frame = decode(MANUAL)
    assert (frame.speed, frame.start, frame.end, frame.time) == (2152, 32427, 33470, 6714)
    assert (frame.ranges[0], frame.intensities[0]) == (224, 228)
    assert (frame.ranges[-1], frame.intensities[-1]) == (192, 229)
    assert np.allclose(frame.angles[[0, -1]], [324.27, 334.70])


def test_the_crc_is_of_polynomial_4d():
    assert [crc8(bytes([i])) for i in range(8)] == [0, 0x4D, 0x9A, 0xD7, 0x79, 0x34, 0xE3, 0xAE]
    assert [crc8(bytes([i])) for i in range(252, 256)] == [0x7F, 0x32, 0xE5, 0xA8]


@pytest.mark.parametrize("i", [0, 1, 2, 10, 44, 46])
def test_a_wrong_byte_is_named(i):
    wrong = bytearray(MANUAL)
    wrong[i] ^= 1
    with pytest.raises(ProtocolError, match="CRC" if i > 1 else "54 2c"):
        decode(bytes(wrong))


def test_angles_that_cannot_be_are_refused():
    frame = decode(MANUAL)
    for start, end in ((0, 36_000), (0, 20_000)):
        wide = Frame(frame.speed, start, end, frame.ranges, frame.intensities, 0)
        with pytest.raises(ProtocolError, match="deg of a turn"):
            decode(encode(wide))


@given(frames)
def test_encoding_and_decoding_are_inverse(frame):
    assert encode(decode(encode(frame))) == encode(frame)


@given(st.lists(st.integers(1, 60), min_size=1))
def test_frames_come_out_whatever_the_pieces(sizes):
    data = b"".join(in_a_row(100))
    taken, found = decoder(), []
    for size in itertools.islice(itertools.cycle(sizes), len(data)):
        found += taken.received(data[:size], 0.0)
        data = data[size:]
    assert frames_in(found) == in_a_row(100)
    assert taken.losses.garbage == taken.losses.damaged == 0


@given(st.binary(max_size=400), st.binary(max_size=30))
def test_any_bytes_are_taken_and_frames_behind_them_are_found(noise, more):
    taken = decoder()
    found = taken.received(noise, 0.0)
    found += taken.received(b"".join(in_a_row(5)) + more + bytes(SIZE), 1.0)
    assert frames_in(found)[-4:] == in_a_row(5)[-4:]  # the noise may end in a head


def test_a_false_head_before_a_frame_does_not_cost_the_frame():
    taken = decoder()
    data = b"\x54\x2c\x00" + b"".join(in_a_row(2)) + bytes(60)
    assert frames_in(taken.received(data, 0.0)) == in_a_row(2)
    assert taken.losses.damaged == 1


def test_a_frame_that_only_its_crc_speaks_for_is_refused():
    row = [decode(frame) for frame in in_a_row(6)]
    false = Frame(2000, 500, 1500, row[0].ranges, row[0].intensities, 20_000)
    taken = decoder()
    data = b"".join(map(encode, [*row[:3], false, *row[3:]]))
    assert frames_in(taken.received(data, 0.0)) == in_a_row(6)
    assert taken.losses.damaged == 1


def test_a_device_that_starts_again_loses_no_frame():
    old = [encode(following(decode(MANUAL), gap)) for gap in (1, 2)]
    taken = decoder()
    first = decode(MANUAL)
    new = [Frame(2152, 0, 1043, first.ranges, first.intensities, 0)]
    new += [following(new[0], 0), following(new[0], 3)]
    data = b"".join([*old, *map(encode, new)])
    assert frames_in(taken.received(data, 0.0)) == [*old, *map(encode, new)]
    assert taken.losses.damaged == 0


def test_memory_stays_bounded():
    taken = decoder()
    for _ in range(1000):
        taken.received(b"\x54" * 1000, 0.0)
    assert len(taken._buffer) < SIZE


def test_a_clock_that_stands_still_costs_no_frame():
    row = [decode(MANUAL)]
    while len(row) < 200:
        row.append(following(row[-1]))
    losses = Losses()
    decoder = Ld19Decoder(losses, Turns(losses, 12.0, 0), 230_400)
    sweeps = []
    for i, each in enumerate(row):
        data = encode(replace(each, time=7))
        sweeps += decoder.received(data, i * 0.003)
    assert len(sweeps) >= 4
    assert losses.frames >= 195
    assert losses.damaged == losses.garbage == 0
