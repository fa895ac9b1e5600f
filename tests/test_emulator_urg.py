"""The emulated URG, command by command, in virtual time."""

import numpy as np
import pytest
from bounded import until
from recordings import needs_recordings
from urg_lines import Line, line, numbered, real_session

from laserfeatures.drivers.urg.decoder import decode_message, decode_scan
from laserfeatures.drivers.urg.ranges import decode_time
from laserfeatures.emulators.urg import UrgDevice

STREAM = b"MD0044072501000"


def frames(data):
    return [part + b"\n\n" for part in data.split(b"\n\n")[:-1]]


@needs_recordings
def test_the_real_session_command_by_command():
    talk = line(model="classic", state="laser on", clock_ms=6_968_000)
    talk.device.baud = None  # it was logged over USB
    heard = []
    for piece in real_session():
        while talk.now < piece.time - 1e-9:
            talk.now += 0.0005
            heard.append(talk.device.take(talk.now))
        if piece.direction == "TX":
            talk.send(piece.data)
            continue
        heard.append(talk.hear(0.1))
        ours, theirs = b"".join(heard), piece.data
        heard.clear()
        talk.now = piece.time
        assert len(ours) == len(theirs)
        for own, real in zip(ours.split(b"\n"), theirs.split(b"\n"), strict=True):
            if len(own) < 64 and not own.startswith(b"TIME") and piece.time < 0.9:
                assert own == real


@pytest.mark.parametrize(
    ("command", "status"),
    [
        (b"VV", b"00"),
        (b"PP", b"00"),
        (b"II", b"00"),
        (b"BM", b"00"),
        (b"QT", b"00"),
        (b"RS", b"00"),
        (b"SCIP2.0", b"0E"),
        (b"XX", b"0E"),
        (b"%ST", b"0E"),
        (b"ME0044072501000", b"0E"),
        (b"VVV", b"0E"),
        (b"MD0044", b"0C"),
        (b"VV;" + 16 * b"a", b"00"),
        (b"VV;" + 17 * b"a", b"0G"),
        (b"VV;a!", b"0H"),
        (b"MDx044072501000", b"01"),
        (b"MD0044x72501000", b"02"),
        (b"MD00440725x1000", b"03"),
        (b"MD0044076901000", b"04"),
        (b"MD0100004401000", b"05"),
        (b"MD004407250100x", b"07"),
        (b"MD004407250100\xff", b"07"),
        (b"MD0044072501x00", b"06"),
        (b"GD0044072501", b"10"),
        (b"TM1", b"04"),
        (b"TM2", b"03"),
        (b"TM3", b"01"),
        (b"SS115200", b"00"),
        (b"SS115201", b"02"),
        (b"SSx15200", b"01"),
        (b"CR00", b"03"),
        (b"CR03", b"00"),
        (b"CR11", b"02"),
        (b"CRxx", b"01"),
        (b"HS1", b"00"),
        (b"HS0", b"02"),
        (b"HS2", b"01"),
    ],
)
def test_answers_when_idle(command, status):
    reply = frames(line().ask(command))[0]
    assert decode_message(reply).status == status
    assert reply.startswith(command + b"\n")


def test_a_command_may_come_in_pieces_and_empty_lines_are_nothing():
    talk = line()
    talk.send(b"\n\r\nV")
    assert talk.hear(1.0) == b""
    assert talk.ask(b"V").startswith(b"VV\n00P\n")


def test_one_answer_a_turn_while_the_laser_is_on():
    talk = line(state="laser on")
    talk.hear(0.033)
    times = []
    for _ in range(3):
        talk.send(b"VV\n")
        until(lambda: talk.hear(0.001), pause=0)
        times.append(talk.now)
    assert np.diff(times) == pytest.approx(0.1, abs=0.002)
    talk = line()
    talk.send(b"VV\n")
    assert talk.hear(0.0025)


def test_a_stream_counts_down_and_ends():
    talk = line()
    accepted, *scans = frames(talk.ask(b"MD0044072501103;tag", 1.0))
    assert accepted == b"MD0044072501103;tag\n00P\n\n"
    echoes = [scan.split(b"\n")[0] for scan in scans]
    assert echoes == [b"MD004407250110%d;tag" % left for left in (2, 1, 0)]
    times = [decode_scan(scan).time for scan in scans]
    assert np.diff(times).tolist() == [200, 200]
    assert talk.ask(b"BM") == b"BM\n00P\n\n"  # the laser was off


def test_an_endless_stream_ends_with_qt():
    talk = line(state="streaming", clock_ms=16_777_100)
    scans = [decode_scan(frame) for frame in frames(talk.hear(0.5))]
    assert [scan.time for scan in scans] == [16_777_100, 16_777_200, 84, 184, 284]
    assert b"QT\n00P\n\n" in talk.ask(b"QT")
    assert talk.hear(1.0) == b""


def test_a_second_stream_is_refused():
    talk = line(state="streaming")
    assert STREAM + b"\n0Bb\n\n" in talk.ask(STREAM)


def test_time_stamp_mode():
    talk = line(state="laser on", clock_ms=4711)
    assert talk.ask(b"TM0") == b"TM0\n00P\n\n"
    assert talk.ask(b"TM0") == b"TM0\n02R\n\n"
    assert talk.ask(b"VV") == b"VV\n0Ee\n\n"
    talk.send(b"TM1\n")
    reply = talk.hear(0.002)
    assert decode_time(reply.split(b"\n")[2]) == pytest.approx(4711 + talk.now * 1000, abs=2)
    assert talk.ask(b"TM2") == b"TM2\n00P\n\n"
    assert talk.ask(b"GD0044072501") == b"GD0044072501\n10Q\n\n"


def test_scip_1_after_every_restart_of_the_classic_model():
    talk = line(model="classic")
    talk.rate = 19_200
    for _ in range(2):
        assert talk.ask(b"QT") == b"QT\nE\n\n"
        assert talk.ask(b"V").startswith(b"V\n0\nVEND:Hokuyo Automatic Co.,Ltd.\n")
        assert talk.ask(b"SCIP2.0") == b"SCIP2.0\n0\n\n"
        assert talk.ask(b"SCIP2.0") == b"SCIP2.0\n0Ee\n\n"
        talk.device.power_on(talk.now)


def test_a_new_rate_begins_after_the_answer():
    talk = line(model="classic", state="idle")
    talk.rate = 19_200
    assert talk.ask(b"SS019200") == b"SS019200\n03S\n\n"
    assert talk.ask(b"SS115200") == b"SS115200\n00P\n\n"
    assert talk.ask(b"QT") == b""
    talk.rate = 115_200
    assert talk.ask(b"II").count(b"SBPS:115200[bps]") == 1
    assert talk.ask(b"RS") == b"RS\n00P\n\n"
    talk.rate = 19_200
    assert talk.ask(b"QT") == b"QT\n00P\n\n"


def test_a_slow_line_carries_fewer_scans():
    talk = line(model="classic", state="idle")
    talk.rate = 19_200
    scans = [decode_scan(frame) for frame in frames(talk.ask(STREAM, 3.7))[1:]]
    assert np.diff([scan.time for scan in scans]).tolist() == [1200, 1200]


def test_single_scans_clusters_and_steps_outside():
    talk = line(state="laser on")
    scan = decode_scan(talk.ask(b"GD0040076803"))
    assert scan.values[[0, -1]].tolist() == [19, 19]
    assert set(scan.values.tolist()) <= {19, 100, 0, 6, 7}
    short = decode_scan(talk.ask(b"GS0044072501"))
    assert (short.values == 101).sum() == 632
    codes = short.values[300:350]
    assert {0, 6, 7} == set(codes.tolist())


def test_the_shortest_range_of_a_cluster_counts():
    def feed(angles):
        return np.where(np.arange(angles.size) % 4 == 1, 1.0, np.where(angles > 0, 2.0, np.nan))

    talk = Line(UrgDevice(feed, state="laser on"))
    assert set(decode_scan(talk.ask(b"GD0044072304")).values.tolist()) == {1000}


def test_the_same_seed_gives_the_same_bytes():
    first, second, other = (line(state="streaming", seed=seed).hear(0.3) for seed in (1, 1, 2))
    assert first == second != other


def test_a_check_is_followed_by_a_pause():
    talk = line(state="streaming", troubles={"check": 1.0})
    heard = frames(talk.hear(0.95))
    assert [decode_message(frame).status for frame in heard] == [b"21", b"98"] * 2 + [b"21"]


def test_a_failure_switches_the_laser_off():
    talk = line(state="streaming", troubles={"failure": 1.0})
    assert talk.hear(1.0) == STREAM + b"\n51V\n\n"
    assert talk.ask(b"BM") == b"BM\n00P\n\n"


def test_a_frozen_clock_repeats_its_time():
    talk = line(state="streaming", troubles={"frozen": 1.0}, clock_ms=5)
    assert {decode_scan(frame).time for frame in frames(talk.hear(0.5))} == {0}


def test_an_answer_may_split_a_scan():
    talk = line(state="streaming", troubles={"split": 1.0})
    talk.hear(0.2)
    first, rest = talk.ask(b"II", 0.1).split(b"II\n00P\n")
    answer, end = rest.split(b"STAT:Sensor works well.;8\n\n")
    assert answer.startswith(b"MODL:")
    assert decode_scan(first + end).values.size == 682


@pytest.mark.parametrize(
    "wrong", [{"model": "ug02"}, {"state": "tmm"}, {"troubles": {"chek": 0.1}}, {"stream": "MD"}]
)
def test_names_are_checked(wrong):
    with pytest.raises((ValueError, OSError), match=r"there is no|expected MD"):
        UrgDevice(numbered(), **wrong)


@pytest.mark.parametrize("state", [None, "laser on", "streaming", "tm", "scip1"])
def test_in_time_for_the_makers_client(state):
    """It waits 0.14 s for a line, asks QT first and tells the state by the answer."""
    talk = line(state=state)
    talk.hear(0.042)
    wait = 0.14
    answer = frames(talk.ask(b"QT", wait))[-1]
    if answer == b"QT\nE\n\n":
        assert talk.ask(b"SCIP2.0", wait) == b"SCIP2.0\n0\n\n"
    elif answer == b"QT\n0Ee\n\n":
        assert talk.ask(b"TM2", wait) == b"TM2\n00P\n\n"
    assert talk.ask(b"QT", wait) == b"QT\n00P\n\n"
    assert talk.hear(wait) == b""  # it reads until the line is quiet
    assert talk.ask(b"PP", wait).count(b"\n") == 11
    assert talk.ask(b"BM", wait) == b"BM\n00P\n\n"
    assert decode_scan(talk.ask(b"GD0044072501", wait)).values.size == 682
    first = talk.ask(STREAM, wait)
    assert first.startswith(STREAM + b"\n00P\n\n")
    assert frames(first + talk.ask(b"QT", wait))[-1] == b"QT\n00P\n\n"


@pytest.mark.parametrize("state", ["idle", "streaming", "tm"])
def test_a_client_that_resets_twice_begins_anew(state):
    talk = line(state=state, clock_ms=99_999)
    for command in (b"TM2", b"RS", b"RS"):
        answer = frames(talk.ask(command, 0.2))[-1]
    assert answer == b"RS\n00P\n\n"
    assert talk.ask(b"TM0") == b"TM0\n00P\n\n"
    assert decode_time(talk.ask(b"TM1").split(b"\n")[2]) < 1000
