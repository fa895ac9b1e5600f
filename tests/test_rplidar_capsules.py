"""Capsules of express, ultra and dense scans, and their beginning in any stream."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar import ultra
from laserfeatures.drivers.rplidar.capsule_framing import CapsuleFraming
from laserfeatures.drivers.rplidar.capsules import (
    CAPSULE,
    LARGEST,
    SAMPLES,
    capsule_fits,
    pack_capsule,
    start_of,
    unpack_capsules,
)
from laserfeatures.drivers.rplidar.node_framing import NodeFraming
from laserfeatures.drivers.rplidar.nodes import DEGREE, FINE, NODE, TURN, Measurements, pack_nodes
from laserfeatures.errors import ProtocolError

# Head of a capsule that starts at 45 degrees, 1000 mm with 1 degree off, 1010 mm with 0.5 degrees.
HEAD = bytes.fromhex("AB 54 40 0B A0 0F C8 0F 48")


def test_a_capsule_as_documented():
    theta, distances = np.zeros(SAMPLES, int), np.zeros(SAMPLES)
    theta[:2], distances[:2] = (8, 4), (1000, 1010)
    data = pack_capsule(45 * DEGREE, theta, distances, first=False)
    assert data[2:9] == HEAD[2:9]
    theta[:], distances[:] = [8, 4] * 16, [1000, 1010] * 16  # as in the example all through
    data = pack_capsule(45 * DEGREE, theta, distances, first=False)
    assert data[:9] == HEAD
    assert len(data) == CAPSULE
    assert capsule_fits(data)
    assert start_of(data) == (45 * DEGREE, False)
    measured = unpack_capsules(data, np.array([45 * DEGREE]), np.array([16 * DEGREE]))
    assert measured.angles[:3].tolist() == [
        44 * DEGREE, 45 * DEGREE, 45 * DEGREE
    ]  # 45 - 1, 45 + 0.5 - 0.5, 45 + 1 - 1  # fmt: skip
    assert measured.distances[:3].tolist() == [1000, 1010, 1000]
    assert set(measured.quality) == {47}


@given(
    st.integers(0, TURN // FINE - 1),
    arrays(int, SAMPLES, elements=st.integers(0, 63)),
    arrays(int, SAMPLES, elements=st.integers(0, LARGEST)),
    st.booleans(),
    st.integers(1, 60 * 64),
)
def test_capsules_come_back(start, theta, distances, first, span):
    data = pack_capsule(start * FINE, theta, distances.astype(float), first=first)
    assert capsule_fits(data)
    assert start_of(data) == (start * FINE, first)
    spans = np.array([span * FINE])
    measured = unpack_capsules(data, np.array([start * FINE]), spans)
    np.testing.assert_array_equal(measured.distances, distances)
    # The documented formula, in degrees.
    angles = start / 64 + span / 64 * np.arange(SAMPLES) / SAMPLES - theta / 8
    off = (measured.angles / DEGREE - angles + 180) % 360 - 180
    assert abs(off).max() <= 1 / DEGREE
    assert ((measured.angles >= 0) & (measured.angles < TURN)).all()


@given(st.integers(0, 8 * CAPSULE - 1), st.integers(0, TURN // FINE - 1))
def test_a_flipped_bit_never_fits(bit, start):
    data = bytearray(pack_capsule(start * FINE, np.zeros(SAMPLES, int), np.ones(SAMPLES), first=0))
    data[bit // 8] ^= 1 << bit % 8
    assert not capsule_fits(bytes(data))


def test_codes_of_ultra_capsules_grow_in_steps():
    millimetres = np.arange(28_655)
    decoded, levels = ultra.steps_of(ultra.codes_of(millimetres))
    assert (decoded <= millimetres).all()
    assert (millimetres - decoded < 1 << levels).all()
    assert set(levels) == {0, 1, 2, 3, 4}
    assert ultra.codes_of(np.array([512, 2048, 4096, 16384, 40_000])).tolist() == [
        512, 1280, 1792, 3328, 0
    ]  # fmt: skip


@given(st.integers(0, TURN // FINE - 1), st.integers(200, 28_000), st.integers(-30, 30))
def test_smooth_ranges_come_back_from_ultra_capsules(start, near, slope):
    distances = np.clip(near + slope * np.arange(97.0), 200, 28_000)
    data = ultra.pack_ultra(start * FINE, distances[:96], distances[96], first=True)
    after = ultra.pack_ultra(0, np.full(96, distances[96]), distances[96], first=False)
    assert capsule_fits(data)
    assert len(data) == ultra.ULTRA_CAPSULE
    starts, spans = np.array([start * FINE]), np.array([22 * DEGREE])
    measured = ultra.unpack_ultra(data, starts, spans, after[4:8])
    step = np.where(distances[:96] < 16_384 - 1000, 8, 16)
    assert (abs(measured.distances - distances[:96]) < 2 * step).all()
    raw = start * FINE + 22 * DEGREE * np.arange(96) // 96
    off = (raw - measured.angles) % TURN / DEGREE
    assert ((off > -1e-9) & (off < 8.01)).all()  # near things more to the side


def test_ultra_capsules_tell_no_return_and_jumps():
    distances = np.full(96, 1000.0)
    distances[[4, 10, 50]] = (0, 9000, 0)  # a lost one, a jump that no difference can hold
    distances[30] = (
        0  # the first of three: those after it borrow the next one's, that before cannot
    )
    data = ultra.pack_ultra(0, distances, 1000.0, first=False)
    measured = ultra.unpack_ultra(data, np.array([0]), np.array([DEGREE]), data[4:8])
    assert np.flatnonzero(measured.distances == 0).tolist() == [4, 10, 29, 30, 50]
    assert set(measured.distances) == {0, 1000}
    assert set(measured.quality[measured.distances == 0]) == {0}


@given(arrays(int, 40, elements=st.integers(0, 0xFFFF)))
def test_dense_capsules_come_back(distances):
    data = ultra.pack_dense(90 * DEGREE, distances.astype(float), first=False)
    assert capsule_fits(data)
    measured = ultra.unpack_dense(data, np.array([90 * DEGREE]), np.array([20 * DEGREE]), b"")
    np.testing.assert_array_equal(measured.distances, distances)
    np.testing.assert_array_equal(measured.angles, 90 * DEGREE + DEGREE // 2 * np.arange(40))


@pytest.mark.parametrize("unpack", [ultra.unpack_ultra, ultra.unpack_dense])
def test_half_capsules_are_refused(unpack):
    one = np.array([0])
    with pytest.raises(ProtocolError, match="expected 1"):
        unpack(bytes(83), one, one, bytes(4))
    with pytest.raises(ProtocolError, match="expected 1"):
        unpack_capsules(bytes(83), one, one)


def nodes(first, count):
    """Return nodes of different angles and distances."""
    index = np.arange(first, first + count)
    measured = Measurements(index * DEGREE % TURN, 1000.0 + index, np.full(count, 20))
    return pack_nodes(measured, index % 360 == 0)


@given(st.binary(max_size=30), st.integers(1, 40), st.integers(0, 3 * NODE))
def test_a_stream_of_nodes_goes_on_after_damage(garbage, chunk, lost):
    losses = Losses()
    framing = NodeFraming(losses)
    before, after = nodes(1, 100), nodes(101, 100)
    data = before[: len(before) - lost] + garbage + after
    runs = [run for i in range(0, len(data), chunk) for run in framing.feed(data[i : i + chunk])]
    got = b"".join(run for run, _ in runs)
    safe = len(before) - lost - 3 * NODE
    assert got.startswith(before[: safe // NODE * NODE])
    assert got.endswith(after[12 * NODE : -NODE])  # the last may go on
    assert framing.pending <= 20 * NODE


def test_a_damaged_node_costs_itself():
    data = bytearray(nodes(0, 60))
    data[30 * NODE] ^= 2  # both start flags are equal now
    losses = Losses()
    got = b"".join(run for run, _ in NodeFraming(losses).feed(bytes(data)))
    assert got == bytes(data[: 30 * NODE] + data[31 * NODE : -NODE])
    assert (losses.damaged, losses.garbage) == (1, 0)


@pytest.mark.parametrize("lost", range(NODE))
def test_a_lost_byte_brings_no_node_that_was_not_sent(lost):
    data = nodes(0, 80)
    at = 30 * NODE + lost
    runs = NodeFraming(Losses()).feed(data[:at] + data[at + 1 :])
    got = [run[i : i + NODE] for run, _ in runs for i in range(0, len(run), NODE)]
    assert set(got) <= {data[i : i + NODE] for i in range(0, len(data), NODE)}
    assert len(got) >= 74


@given(st.binary(max_size=2000), st.integers(1, 300))
def test_framing_takes_anything_and_keeps_little(data, chunk):
    for framing, most in ((NodeFraming(Losses()), 12 * NODE), (CapsuleFraming(84, Losses()), 84)):
        for i in range(0, len(data), chunk):
            framing.feed(data[i : i + chunk])
            assert len(framing._buffer) <= most


def test_a_damaged_capsule_costs_itself():
    whole = [
        pack_capsule(i * DEGREE, np.zeros(32, int), np.ones(32), first=False) for i in range(9)
    ]
    losses = Losses()
    data = b"".join(whole[:4]) + whole[4][:40] + b"\xa5" + whole[4][41:] + b"".join(whole[5:])
    found = CapsuleFraming(CAPSULE, losses).feed(data)
    assert [framed.capsule for framed in found] == whole[:4] + whole[5:]
    assert [framed.stray for framed in found] == [0, 0, 0, 0, CAPSULE, 0, 0, 0]
    assert (losses.damaged, losses.garbage) == (1, CAPSULE)
