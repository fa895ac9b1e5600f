"""SCIP's frames, sums, numbers and statuses, against the worked examples and real replies."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recordings import needs_recordings
from urg_lines import SERIAL, real_session

from laserfeatures.drivers.urg import ranges, scip, sensor, statuses
from laserfeatures.drivers.urg.commands import Measurement, decode_measurement
from laserfeatures.drivers.urg.decoder import decode_message, decode_scan
from laserfeatures.errors import ProtocolError

SUMS = b"00P 01Q 02R 03S 04T 05U 06V 07W 10Q 98a 99b 0Aa 0Bb 0Cc 0Dd 0Ee 0Ff 0Gg 0Hh 0Ii"


@pytest.mark.parametrize("line", SUMS.split())
def test_sums_of_statuses(line):
    assert scip.decode_line(line, 2) == line[:2]


@pytest.mark.parametrize(
    ("value", "text"),
    [(1234, b"CB"), (20, b"0D"), (4095, b"oo"), (5600, b"1GP"), (392, b"068"), (262143, b"ooo")],
)
def test_numbers(value, text):
    assert ranges.encode(np.array([value]), len(text)) == text
    assert ranges.decode(text, len(text)).tolist() == [value]


@pytest.mark.parametrize(("value", "line"), [(6_968_830, b"JUGnD"), (11_149_560, b"ZR3h7")])
def test_times(value, line):
    assert ranges.encode_time(value) == line + b"\n"
    assert ranges.decode_time(line) == value


def test_the_answer_to_tm1():
    reply = scip.decode_reply(b"TM1\n00P\n<SfkP\n\n")
    assert reply.echo == b"TM1"
    assert ranges.time_of(reply.lines[0]) == ranges.decode_time(b"<SfkP")


def test_a_semicolon_is_a_number_in_data_and_an_end_in_a_key_line():
    assert scip.decode_line(scip.with_sum(b"007;")[:-1]) == b"007;"
    assert scip.decode_key_line(b"DMIN:20;4") == b"DMIN:20"
    summed = b"DMIN:20;" + scip.sum_of(b"DMIN:20;")
    assert scip.decode_key_line(summed) == b"DMIN:20"


@pytest.mark.parametrize("line", [b"\xb00P", b"p\x10P", b"P", b"", b"00Q"])
def test_a_bit_that_the_sum_does_not_see_is_seen(line):
    with pytest.raises(ProtocolError):
        scip.decode_line(line)


def test_the_reply_of_scip_1():
    assert scip.decode_reply(b"SCIP2.0\n0\n\n") == scip.Reply(b"SCIP2.0", b"0")
    assert scip.encode_reply(b"QT", b"E") == b"QT\nE\n\n"


@pytest.mark.parametrize(
    ("command", "size"),
    [
        (b"GD0044072501", 2134),
        (b"MD0044072501000", 2137),
        (b"GS0044072501", 1432),
        (b"MS0044072501000", 1435),
    ],
)
def test_sizes_of_whole_scans(command, size):
    measurement = decode_measurement(command)
    assert measurement.values == 682
    body = ranges.encode_time(0)
    body += ranges.encode_block(np.full(682, 1234), measurement.characters)
    frame = scip.encode_reply(command, b"99" if measurement.streams else b"00", body)
    assert len(frame) == size
    assert decode_scan(frame).values.tolist() == [1234] * 682


@pytest.mark.parametrize(("cluster", "values"), [(0, 682), (1, 682), (2, 341), (3, 228), (99, 7)])
def test_values_of_clusters(cluster, values):
    assert decode_measurement(b"GD00440725%02d" % cluster).values == values


def test_an_echo_counts_down():
    command = Measurement("MD", 44, 725, 1, 0, 5)
    assert decode_measurement(b"MD0044072501004").answers(command)
    assert not decode_measurement(b"MD0044072501006").answers(command)
    assert not decode_measurement(b"MD0044072502004").answers(command)
    assert not decode_measurement(b"MD0044072501001").answers(Measurement("MD", 44, 725))


@needs_recordings
@pytest.mark.parametrize(
    ("name", "time", "codes", "shortest", "longest"),
    [
        ("scip2_GD_A", 11_149_560, {0: 53, 6: 24, 7: 8}, 90, 5461),
        ("scip2_GD_B", 513, None, None, None),
    ],
)
def test_real_scans(name, time, codes, shortest, longest):
    scan = decode_scan((SERIAL / f"{name}.bin").read_bytes())
    assert (scan.time, scan.values.size) == (time, 682)
    assert scan.measurement == Measurement("GD", 44, 725)
    if codes:
        seen = scan.values[scan.values >= 20]
        assert {code: int((scan.values == code).sum()) for code in codes} == codes
        assert (seen.min(), seen.max()) == (shortest, longest)
        assert seen.size == 682 - sum(codes.values())


@needs_recordings
def test_the_real_session():
    frames = [piece.data for piece in real_session() if piece.direction == "RX"]
    *replies, scan = [decode_message(frame) for frame in frames]
    assert [reply.status for reply in replies] == [b"00"] * 4 + [b"02", b"03"] + [b"00"] * 3
    geometry = sensor.decode_geometry(replies[2].lines)
    assert geometry == sensor.Geometry(
        "URG-04LX(Hokuyo Automatic Co.,Ltd.)", 20, 5600, 1024, 44, 725, 384, 600
    )
    information = sensor.decode_fields(replies[3].lines)
    assert information["TIME"] == "6A5404"
    assert sensor.with_speed(geometry, information) == geometry
    assert scan.time == 6_968_830
    seen = scan.values[scan.values >= 20]
    codes = {code: int((scan.values == code).sum()) for code in (0, 7, 10)}
    assert codes == {0: 94, 7: 6, 10: 1}
    assert (seen.min(), seen.max(), scan.values[0]) == (76, 4166, 392)


@needs_recordings
def test_the_real_version_and_every_sum():
    frame = (SERIAL / "scip2_VV_urg04lx_ug01.bin").read_bytes()
    reply = scip.decode_reply(frame)
    assert sensor.decode_fields(reply.lines)["SERI"] == "H1510998"
    body = b"".join(scip.with_key_sum(line) for line in reply.lines)
    assert scip.encode_reply(b"VV", b"00", body) == frame
    frame = frame.replace(b"VV", b"PP", 1)  # of VV, wrong sums are let pass
    for i in range(len(frame) - 1):  # a bit that breaks no sum breaks no digit
        flipped = frame[:i] + bytes([frame[i] ^ 1]) + frame[i + 1 :]
        if frame[i] != ord("\n") and i > 2:
            with pytest.raises(ProtocolError):
                scip.decode_reply(flipped)


def test_geometry():
    geometry = sensor.Geometry("", 20, 5600, 1024, 44, 725, 384, 600)
    assert geometry.period == pytest.approx(0.1)
    assert geometry.step_time == pytest.approx(97.66e-6, abs=1e-8)
    whole = np.degrees(geometry.angles(Measurement("MD", 44, 725)))
    assert whole[-1] - whole[0] == pytest.approx(681 * 360 / 1024)
    assert (whole.size, whole[340]) == (682, 0)
    clusters = np.degrees(geometry.angles(Measurement("MD", 380, 389, 4)))
    assert clusters == pytest.approx(np.array([-2.5, 1.5, 4.5]) * 360 / 1024)


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ([b"DMIN:20"], "DMAX"),
        ([b"DMIN:x"], "a number for DMIN"),
        ([b"DMIN"], "KEY:VALUE"),
        ([b"DMIN:20", b"DMAX:10", b"ARES:1024", b"AMIN:44", b"AMAX:725", b"AFRT:384", b"SCAN:600"],
         "DMIN < DMAX"),
        ([b"DMIN:20", b"DMAX:5600", b"ARES:100", b"AMIN:44", b"AMAX:725", b"AFRT:38", b"SCAN:600"],
         "AMAX"),
    ],
)  # fmt: skip
def test_an_impossible_geometry(lines, says):
    with pytest.raises(ProtocolError, match=says):
        sensor.decode_geometry(lines)


@pytest.mark.parametrize(
    ("command", "status", "says"),
    [
        (b"GD0044072501", b"10", "the laser is off"),
        (b"MD0044072501000", b"05", "the last step is before the first"),
        (b"MD0044072501000", b"21", "pauses to check"),
        (b"MD0044072501000", b"97", "fault of the hardware"),
        (b"MD", b"98", "goes on"),
        (b"BM", b"02", "on already"),
        (b"CR00", b"04", "fixed"),
        (b"SS019200", b"03", "already"),
        (b"TM1", b"04", "not in time stamp mode"),
        (b"HS1", b"03", "no such mode"),
        (b"XX", b"0E", "not defined"),
        (b"XX", b"77", "does not know"),
    ],
)
def test_what_a_status_says(command, status, says):
    assert says in statuses.meaning(command, status)


numbers = st.integers(1, 3).flatmap(
    lambda n: st.tuples(st.just(n), st.lists(st.integers(0, 64**n - 1), min_size=1, max_size=300))
)


@given(numbers)
def test_blocks_come_back(case):
    characters, values = case
    block = ranges.encode_block(np.array(values), characters)
    assert ranges.decode_block(block, len(values), characters).tolist() == values
    assert all(len(line) <= 65 for line in block.split(b"\n"))


@settings(max_examples=300)
@given(st.binary(max_size=80), st.integers(0, 2135), st.sampled_from(["cut", "insert", "replace"]))
def test_only_protocol_errors_come_of_mutated_bytes(noise, place, how):
    block = ranges.encode_block(np.arange(682) * 8, 3)
    frame = scip.encode_reply(b"MD0044072501000", b"99", ranges.encode_time(1234) + block)
    mutated = {
        "cut": frame[:place],
        "insert": frame[:place] + noise + frame[place:],
        "replace": frame[:place] + noise + frame[place + len(noise) :],
    }[how]
    for candidate in (mutated, noise, noise + b"\n\n"):
        for decode in (decode_message, decode_scan, scip.decode_reply, decode_measurement):
            try:
                decode(candidate)
            except ProtocolError:
                continue


@given(st.lists(st.binary(max_size=20), max_size=9))
def test_only_protocol_errors_come_of_any_fields(lines):
    for decode in (sensor.decode_fields, sensor.decode_geometry):
        try:
            decode(lines)
        except ProtocolError:
            continue


@pytest.mark.parametrize("echo", [b"VV", b"II"])
@pytest.mark.parametrize("line", [b"FIRM:3.0.00(06/Oct./2004);X", b"SCSP:2400[rpm]<-Default;!"])
def test_a_wrong_sum_in_what_is_only_told_costs_nothing(echo, line, caplog):
    frame = scip.encode_reply(echo, b"00", scip.with_key_sum(b"VEND:Hokuyo") + line + b"\n")
    reply = scip.decode_reply(frame)
    assert reply.lines == (b"VEND:Hokuyo", line[:-2])
    assert "a line of the sensor's has a wrong sum" in caplog.text
    with pytest.raises(ProtocolError, match="expected the sum"):  # is needed to measure
        scip.decode_reply(frame.replace(echo, b"PP", 1))


def test_a_remark_need_not_be_summed():
    summed = b"SCSP:2400[rpm]<-"
    line = summed + b"Default;" + scip.sum_of(summed)
    assert scip.decode_key_line(line) == b"SCSP:2400[rpm]<-Default"
    geometry = sensor.Geometry("", 20, 4000, 1024, 0, 768, 384, 600)
    told = sensor.decode_fields([scip.decode_key_line(line)])
    assert sensor.with_speed(geometry, told).speed == 2400
