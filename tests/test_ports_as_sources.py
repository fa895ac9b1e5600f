"""A port is a source like a log."""

import math
import os
import signal
import threading
import time

import pytest
from played import address, ld19

import laserfeatures as lf
from laserfeatures.drivers.host_clock import now
from laserfeatures.sources import Source


@pytest.fixture(scope="module")
def port():
    with ld19() as emulator:
        yield emulator


def test_a_port_s_scans_are_a_log_s(port):
    with lf.open_source(address(port)) as source:
        assert isinstance(source, Source)
        assert (source.format, source.poses, source.path) == ("ld19", "none", None)
        assert source.name == address(port)
        scans = [next(source) for _ in range(3)]
        assert [len(scan) > 300 for scan in scans] == [True] * 3
        assert 0 < now() - source.arrival < 0.5
        assert (source.skipped, source.first_error) == (0, None)
    assert list(source) == []


def test_limits_end_it(port):
    with lf.open_source(address(port, "scans=2")) as source:
        assert len(list(source)) == 2
        assert list(source) == []
    began = time.monotonic()
    with lf.open_source(address(port, "seconds=0.45")) as source:
        assert 2 <= len(list(source)) <= 5
    assert time.monotonic() - began < 2


def test_range_max_is_lowered(port):
    with lf.open_source(address(port, "scans=1"), range_max=2.0) as source:
        (scan,) = source
    assert scan.range_max == 2.0
    assert scan.ranges[scan.beams].max() < 2.0


def test_a_network_address_is_a_port():
    with ld19(tcp=0) as emulator, lf.open_source(address(emulator, "scans=1")) as source:
        assert emulator.port.startswith("socket://")
        assert len(list(source)) == 1


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("format", "carmen"),
        ("topic", "/scan"),
        ("field_of_view", 3.0),
        ("slice_band", (0.0, 1.0)),
        ("slice_origin", (0.0, 1.0)),
    ],
)
def test_options_that_a_port_has_not(option, value):
    with pytest.raises(ValueError, match=f"{option} does not apply to a port"):
        lf.open_source("ld19:///dev/null", **{option: value})


@pytest.mark.parametrize(
    ("query", "complaint"),
    [
        ("scans=x", "scans must be a number, got 'x'"),
        ("scans=0", "scans must be >= 1, got 0"),
        ("scans=1.5", "scans must be a whole number, got 1.5"),
        ("seconds=-1", "seconds must be > 0 s, got -1"),
        ("seconds=nan", "seconds must be > 0 s, got nan"),
        ("buffr=3", "no parameter 'buffr'; did you mean 'buffer'"),
        ("buffer=0", "buffer must be >= 1, got 0"),
    ],
)
def test_queries_that_make_no_sense(query, complaint):
    with pytest.raises(lf.DriverError, match=complaint) as error:
        lf.open_source(f"ld19:///dev/null?{query}")
    assert str(error.value).startswith("ld19:///dev/null?")


def test_unknown_schemes_are_named_with_the_known_ones(tmp_path, monkeypatch):
    with pytest.raises(lf.SourceError, match=r"tcp://host:1: expected a file .* urg, .*, replay"):
        lf.open_source("tcp://host:1")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ld19:log").write_text("angle,range\n0,1\n0.1,1\n")
    with lf.open_source("ld19:log") as source:  # a file that is there is a file
        assert source.format == "csv"


def test_damaged_frames_are_counted_as_skipped():
    with ld19({"bit_flip": 0.05}) as emulator:
        with lf.open_source(address(emulator, "scans=6")) as source:
            assert len(list(source)) == 6
        assert source.skipped == source.losses.damaged > 0
        assert source.first_error.startswith(f"ld19:{emulator.port}: an LD19 frame must ")


def test_a_port_that_is_missing_is_a_driver_s_error():
    with pytest.raises(lf.DriverError, match="there is no such port"):
        lf.open_source("ld19:///dev/no-such-port")


def test_closing_frees_the_port(port):
    for _ in range(2):
        source = lf.open_source(address(port))
        next(source)
        source.close()
        source.close()
        assert not [t.name for t in threading.enumerate() if t.name.startswith("read ")]


def test_interrupting_ends_it_between_scans(port):
    with lf.open_source(address(port)) as source:
        next(source)
        source.interrupt()
        assert list(source) == []


def test_interrupting_ends_it_while_it_waits():
    with ld19() as emulator, lf.open_source(address(emulator)) as source:
        before = signal.signal(signal.SIGINT, lambda *_: source.interrupt())
        try:
            next(source)
            faults = emulator.device.faults
            faults.stuck_time, faults.rates = math.inf, {"stuck": 1.0}
            timer = threading.Timer(0.4, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            began = time.monotonic()
            assert len(list(source)) < 3
            assert time.monotonic() - began < source.driver.patience  # then it starts it again
            timer.join()
        finally:
            signal.signal(signal.SIGINT, before)


def test_an_interrupt_that_is_not_the_source_s_stays_one(monkeypatch):
    def interrupted():
        raise KeyboardInterrupt

    with ld19() as emulator, lf.open_source(address(emulator)) as source:
        monkeypatch.setattr(source, "_wait", interrupted)
        with pytest.raises(KeyboardInterrupt):
            next(source)
