"""What the replies and values of the LMS2xx mean."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lms_lines import session
from recordings import DATA, needs_recordings

from laserfeatures.drivers.lms import Configuration, Telegram, parse, parse_measurement
from laserfeatures.drivers.lms.configuration import parse_written
from laserfeatures.drivers.lms.measurements import (
    DEGREES,
    Measurement,
    beam_angles,
    measurement_telegram,
    turns,
    values_of,
)
from laserfeatures.drivers.lms.ranges import (
    LAYOUTS,
    first_special,
    range_limit,
    to_ranges,
    to_words,
)
from laserfeatures.drivers.lms.status import describe, parse_errors, parse_status, write_status
from laserfeatures.drivers.lms.telegrams import pack
from laserfeatures.errors import ProtocolError


def words(*values):
    return np.array(values, dtype=np.uint16)


@needs_recordings
def test_the_real_status():
    data = next(parse(d).data for _, _, d in session() if d[4] == 0xB1)
    status = parse_status(data)
    assert (status.firmware, status.serial, status.boot_version) == ("V02.19", "05270497", "V02.02")
    assert (status.mode, status.angle, status.resolution) == (0x25, 180, 50)
    assert (status.measuring_mode, status.unit, status.address) == (4, 1, 0)
    assert status.baud == 38400
    assert status.turn_time == pytest.approx(0.01332)
    assert write_status(data, mode=status.mode, baud_code=0x8019) == data


def test_a_status_that_is_too_short():
    with pytest.raises(ProtocolError, match="at least 130 bytes of data, got 5"):
        parse_status(b"V02.1")


def test_the_real_list_of_errors():
    errors = parse_errors(bytes.fromhex("84 16 84 31 01 31"))
    assert errors == [
        "old fatal error 22 (window polluted)",
        "old fatal error 49 (laser power)",
        "info 49 (laser power)",
    ]
    assert parse_errors(b"") == []
    with pytest.raises(ProtocolError, match="pairs"):
        parse_errors(b"\1")


@pytest.mark.parametrize(
    ("status", "said"),
    [
        (0x10, None),
        (0x11, None),
        (0x91, None),
        (0x12, "warning"),
        (0x13, "error"),
        (0x14, "fatal error"),
        (0x50, "implausible values"),
    ],
)
def test_the_status_byte(status, said):
    assert describe(status) == said


CONFIGURATION = "0000700000040100000202" + "00" * 21 + "0200"


def test_only_what_is_asked_for_changes_in_a_configuration():
    read = Configuration(bytes.fromhex(CONFIGURATION))
    assert (read.measuring_mode, read.unit, read.indices) == (4, 1, False)
    assert read.changed() == read.changed(reach=16, unit="mm", indices=False) == read
    changed = read.changed(reach=32, unit="cm", indices=True).data
    differing = [i for i in range(34) if changed[i] != read.data[i]]
    assert differing == [4, 5, 6]
    assert changed[4:7] == bytes([2, 6, 0])


def test_a_measuring_mode_of_the_same_reach_stays():
    assert Configuration(bytes(5) + b"\3" + bytes(28)).changed(reach=16).measuring_mode == 3
    assert Configuration(bytes(5) + b"\2" + bytes(26)).changed(reach=8).measuring_mode == 2


def test_configurations_of_a_wrong_length():
    with pytest.raises(ProtocolError, match="32 or 34 bytes of data, got 33"):
        Configuration(bytes(33))
    with pytest.raises(ProtocolError, match="got nothing"):
        parse_written(b"")
    assert parse_written(b"\1" + bytes(32)) == (True, Configuration(bytes(32)))
    assert parse_written(b"\0" + bytes(34))[0] is False


@pytest.mark.parametrize(
    ("mode", "flags", "highest"),
    [(0, 3, 0x1FFF), (1, 3, 0x1FFF), (2, 3, 0x1FFF), (3, 2, 0x3FFF), (4, 2, 0x3FFF),
     (5, 1, 0x7FFF), (6, 1, 0x7FFF)],
)  # fmt: skip
def test_flags_are_masked_and_special_values_are_no_ranges(mode, flags, highest):
    for flag in range(1 << flags):
        above = flag << (16 - flags)
        special = [highest - down for down in (0, 1, 2, 4, 5, 8)]
        values = words(*(above | v for v in [*special, highest - 9, 1, 1234]))
        ranges = to_ranges(values, mode, 1)
        assert np.isnan(ranges[:6]).all()
        assert ranges[6:].tolist() == [(highest - 9) / 1000, 0.001, 1.234]


def test_mode_0f_has_no_flags():
    assert np.isnan(to_ranges(words(0x7FFF, 0xFFFF, 0x8001), 0x0F, 1)).all()
    assert to_ranges(words(32000), 0x0F, 1).tolist() == [32.0]


def test_units_and_limits():
    assert to_ranges(words(1234), 0, 0).tolist() == [12.34]
    assert range_limit(0, 0) == 81.83
    assert range_limit(0, 1) == 8.183
    assert range_limit(4, 1) == 16.375
    assert range_limit(6, 1) == 32.759
    with pytest.raises(ProtocolError, match="unit: expected 0"):
        to_ranges(words(1), 0, 2)
    with pytest.raises(ProtocolError, match="0x3F"):
        to_ranges(words(1), 0x3F, 1)


@given(st.sampled_from(sorted(LAYOUTS)), st.sampled_from([0, 1]), st.data())
def test_ranges_come_back(mode, unit, data):
    values = data.draw(st.lists(st.integers(0, first_special(mode) - 1), max_size=50))
    ranges = to_ranges(words(*values), mode, unit)
    assert to_words(ranges, mode, unit).tolist() == values
    assert np.isnan(
        to_ranges(to_words(np.array([np.nan, 1e3, np.inf]), mode, unit), mode, unit)
    ).all()


@needs_recordings
def test_the_captured_telegram():
    data = (DATA / "serial/lms200_scan361_usick.bin").read_bytes()
    telegram = parse(data)
    measurement = parse_measurement(telegram)
    assert (measurement.words.size, measurement.unit, measurement.partial) == (361, 1, None)
    assert measurement.indices is None
    ranges = to_ranges(measurement.words, 0, measurement.unit)
    assert (ranges.min(), ranges.max()) == (0.407, 4.769)
    assert pack(measurement_telegram(0xB0, measurement, telegram.status)) == data


@given(
    command=st.sampled_from([0xB0, 0xB6, 0xB7, 0xBF]),
    values=st.lists(st.integers(0, 0xFFFF), max_size=401),
    unit=st.sampled_from([0, 1]),
    partial=st.sampled_from([None, 0, 1, 2, 3]),
    mean=st.integers(2, 250),
    first=st.integers(1, 401),
    indices=st.sampled_from([None, (7, 255)]),
)
def test_measurements_come_back(command, values, unit, partial, mean, first, indices):
    made = Measurement(
        words=words(*values),
        unit=unit,
        partial=partial,
        mean=mean if command in {0xB6, 0xBF} else 1,
        first=first if command in {0xB7, 0xBF} else None,
        indices=indices,
    )
    again = parse_measurement(measurement_telegram(command, made, 0x10))
    assert again.words.tolist() == values
    for name in ("unit", "partial", "mean", "first", "indices"):
        assert getattr(again, name) == getattr(made, name), name


def test_ranges_with_reflectivities():
    telegram = Telegram(0xC4, bytes.fromhex("0240 6400 C800 0200 0100 0200 1122"))
    assert parse_measurement(telegram).words.tolist() == [100, 200]


@given(st.sampled_from([0xB0, 0xB6, 0xB7, 0xBF, 0xC4, 0xB1]), st.binary(max_size=60))
def test_any_values_are_read_or_refused(command, data):
    with suppress(ProtocolError):
        assert parse_measurement(Telegram(command, data)).words.size * 2 < len(data)


@pytest.mark.parametrize(
    ("angle", "resolution", "count", "size"),
    [(100, 100, 101, 212), (180, 100, 181, 372), (100, 50, 201, 412), (180, 50, 361, 732),
     (100, 25, 401, 812)],
)  # fmt: skip
def test_sizes_and_directions(angle, resolution, count, size):
    assert values_of(angle, resolution) == count
    assert DEGREES[count] == (angle, resolution)
    made = Measurement(words=words(*range(count)), unit=1)
    assert len(pack(measurement_telegram(0xB0, made, 0x10))) == size
    angles = np.degrees(beam_angles(count))
    assert angles[[0, -1]] == pytest.approx([-angle / 2, angle / 2])
    assert np.diff(angles) == pytest.approx(resolution / 100)


def test_directions_of_partial_scans_and_parts():
    assert np.degrees(beam_angles(180, partial=2))[[0, -1]] == pytest.approx([-89.5, 89.5])
    assert np.degrees(beam_angles(181, partial=0))[[0, -1]] == pytest.approx([-90, 90])
    assert np.degrees(beam_angles(100, partial=3))[[0, -1]] == pytest.approx([-49.25, 49.75])
    part = np.degrees(beam_angles(3, first=181, variant=(180, 50)))
    assert part == pytest.approx([0, 0.5, 1], abs=1e-12)
    fast = np.degrees(beam_angles(181, variant=(90, 50)))
    assert fast[[0, -1]] == pytest.approx([-45, 45])
    for count, more in [(77, {}), (3, {"first": 361, "variant": (180, 50)}), (3, {"first": 0})]:
        with pytest.raises(ProtocolError, match="fit no field of view"):
            beam_angles(count, **more)


def test_turns_of_the_mirror():
    assert [turns(100), turns(50), turns(25), turns(None), turns(50, 90)] == [1, 2, 4, 1, 1]
