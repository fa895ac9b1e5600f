"""Telegrams of the LMS2xx against the printed ones and real ones, and the checksum its own way."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lms_lines import SESSION, session
from recordings import needs_recordings

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.telegrams import (
    Telegram,
    crc,
    pack,
    pack_request,
    parse,
    parse_request,
)
from laserfeatures.errors import ProtocolError


def slow_crc(data):
    """Return the checksum as the listing describes it, p. 107."""
    word = before = 0
    for byte in data:
        word = word << 1 & 0xFFFF ^ (0x8005 if word & 0x8000 else 0) ^ before << 8 ^ byte
        before = byte
    return word


def test_the_steps_of_the_checksum():
    request = bytes.fromhex("02 00 01 00 31")
    steps = [crc(request[: i + 1]) for i in range(5)]
    assert steps == [0x0002, 0x0204, 0x0409, 0x0912, 0x1215]


@given(st.binary(max_size=814))
def test_the_checksum_is_that_of_the_listing(data):
    assert crc(data) == slow_crc(data)


REQUESTS = {
    "02 00 01 00 10 34 12": pack_request(requests.RESET),
    "02 00 0A 00 20 00 53 49 43 4B 5F 4C 4D 53 BE C5": requests.installation_mode(),
    "02 00 0A 00 20 30 53 49 43 4B 5F 4C 4D 53 EE F5": requests.operating_mode(
        0x30, requests.PASSWORD
    ),
    "02 00 02 00 20 10 00 08": requests.operating_mode(requests.DIAGNOSIS),
    "02 00 02 00 20 24 34 08": requests.stream(),
    "02 00 02 00 20 25 35 08": requests.operating_mode(requests.ON_REQUEST),
    "02 00 02 00 20 2A 3A 08": requests.operating_mode(requests.STREAM_PARTIAL),
    "02 00 06 00 20 27 1B 00 2B 01 FF FE": requests.stream(first=27, last=299),
    "02 00 03 00 20 26 05 79 3E": requests.stream(mean=5),
    "02 00 02 00 20 40 50 08": requests.session_baud(38400),
    "02 00 02 00 20 41 51 08": requests.session_baud(19200),
    "02 00 02 00 20 42 52 08": requests.session_baud(9600),
    "02 00 02 00 20 48 58 08": requests.session_baud(500_000),
    "02 00 02 00 30 01 31 18": requests.one_scan(),
    "02 00 02 00 30 08 38 18": pack_request(requests.VALUES, bytes([requests.ONE_PARTIAL_SCAN])),
    "02 00 01 00 31 15 12": pack_request(requests.STATUS),
    "02 00 01 00 32 16 12": pack_request(requests.ERRORS),
    "02 00 01 00 35 11 12": pack_request(0x35),
    "02 00 02 00 36 02 3E 1E": requests.one_scan(mean=2),
    "02 00 05 00 37 01 00 69 01 EB 75": requests.one_scan(first=1, last=361),
    "02 00 01 00 3A 1E 12": pack_request(requests.TYPE),
    "02 00 05 00 3B B4 00 64 00 97 49": requests.variant(180, 100),
    "02 00 05 00 3B B4 00 32 00 3B 1F": requests.variant(180, 50),
    "02 00 05 00 3B 64 00 64 00 1D 0F": requests.variant(100, 100),
    "02 00 05 00 3B 64 00 32 00 B1 59": requests.variant(100, 50),
    "02 00 05 00 3B 64 00 19 00 E7 72": requests.variant(100, 25),
    "02 00 02 00 66 00 9C 4E": requests.power_on_baud(keep=False),
    "02 00 02 00 66 01 9D 4E": requests.power_on_baud(keep=True),
    "02 00 01 00 74 50 12": pack_request(requests.READ_CONFIGURATION),
    "02 00 01 00 7B 5F 12": pack_request(0x7B),
    "02 00 23 00 77 00 00 46 00 00 00 01 00 00 02 02 02 00 00 0A 0A 50 64 00 0A 0A 50 80 00 0A 0A "
    "50 64 00 00 00 00 02 00 7B 4B": pack_request(
        0x77,
        bytes.fromhex("0000460000000100000202020000")
        + bytes.fromhex("0A0A5064000A0A5080000A0A50640000000002 00"),
    ),
}


@pytest.mark.parametrize("printed", REQUESTS)
def test_requests_are_the_printed_ones(printed):
    expected = bytes.fromhex(printed)
    assert REQUESTS[printed] == expected
    command, data = parse_request(expected)
    assert pack_request(command, data) == expected


REPLIES = {
    "02 80 03 00 A0 00 10 16 0A": Telegram(0xA0, b"\0"),
    "02 80 03 00 A0 00 11 17 0A": Telegram(0xA0, b"\0", 0x11),
    "02 80 03 00 A0 01 10 14 0B": Telegram(0xA0, b"\1"),
    "02 80 02 00 91 10 79 30": Telegram(0x91, b""),
    "02 80 02 00 92 10 7F 33": Telegram(0x92, b""),
    "02 80 02 00 B2 10 3F 13": Telegram(0xB2, b""),
    "02 80 07 00 BB 01 B4 00 32 00 10 03 9D": Telegram(0xBB, bytes.fromhex("01B4003200")),
    "02 80 07 00 BB 00 B4 00 32 00 10 23 8D": Telegram(0xBB, bytes.fromhex("00B4003200")),
    "02 80 17 00 BA" + b"LMS200;301063;V02.10 ".hex() + "10 22 61": Telegram(
        0xBA, b"LMS200;301063;V02.10 "
    ),
    "02 80 17 00 BA" + b"LMS200;S18063;V02.19 ".hex() + "10 85 6A": Telegram(
        0xBA, b"LMS200;S18063;V02.19 "
    ),
    "02 80 17 00 90" + b"LMS200;301063;V02.10 ".hex() + "10 63 5E": Telegram(
        0x90, b"LMS200;301063;V02.10 "
    ),
    "02 81 17 00 90" + b"LMS200;301063;V02.06 ".hex() + "13 64 5A": Telegram(
        0x90, b"LMS200;301063;V02.06 ", 0x13, 0x81
    ),
    "02 80 04 00 E6 01 00 10 CD FC": Telegram(0xE6, b"\1\0"),
    "02 80 04 00 E6 01 01 10 CF FD": Telegram(0xE6, b"\1\1"),
}


@pytest.mark.parametrize("printed", REPLIES)
def test_replies_are_the_printed_ones(printed):
    expected = bytes.fromhex(printed)
    assert pack(REPLIES[printed]) == expected
    assert parse(expected) == REPLIES[printed]


def test_the_listings_misprint_fails_its_own_rule():
    with pytest.raises(ProtocolError, match="checksum 5E63, got 5663"):
        parse(bytes.fromhex("028017 0090" + b"LMS200;301063;V02.10 ".hex() + "106356"))


@needs_recordings
def test_every_real_telegram_is_read_and_written_byte_for_byte():
    assert SESSION.exists()
    for _, direction, data in session():
        if direction == "TX":
            assert pack_request(*parse_request(data)) == data
        else:
            assert pack(parse(data)) == data


@given(
    st.integers(0x80, 0xFF),
    st.binary(max_size=800),
    st.integers(0, 255),
    st.sampled_from([0x80, 0x81]),
)
def test_telegrams_come_back(command, data, status, address):
    telegram = Telegram(command, data, status, address)
    assert parse(pack(telegram)) == telegram


@given(st.integers(0, 0x7F), st.binary(max_size=800), st.integers(0, 0x7F))
def test_requests_come_back(command, data, address):
    assert parse_request(pack_request(command, data, address)) == (command, data)


@given(st.binary(max_size=900))
def test_any_bytes_are_read_or_refused(data):
    for reader in (parse, parse_request):
        try:
            reader(data)
        except ProtocolError:
            continue


@given(st.integers(0, 731), st.integers(1, 255))
def test_one_wrong_byte_is_always_seen(place, change):
    whole = pack(Telegram(0xB0, bytes(range(5, 256)) * 2 + bytes(222)))
    wrong = bytearray(whole)
    wrong[place % len(whole)] ^= change
    with pytest.raises(ProtocolError):
        parse(bytes(wrong))


FLIPS = st.tuples(st.integers(0, 729), st.integers(0, 7))


@given(FLIPS, FLIPS, st.integers(1, 7))
def test_of_two_flipped_bits_it_misses_those_as_many_bytes_as_places_apart(one, other, apart):
    data = bytes(range(146)) * 5
    for two in (other, (one[0] + apart, one[1] + apart)):
        if max(two[0], one[0]) >= len(data) or two[1] > 7:
            continue
        wrong = bytearray(data)
        for byte, bit in (one, two):
            wrong[byte] ^= 1 << bit
        missed = crc(bytes(wrong)) == crc(data)
        assert missed == (two[0] - one[0] == two[1] - one[1])
