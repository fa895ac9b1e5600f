import json
import os
import pty
import re
import signal
import time
from contextlib import suppress

import pytest
from cli_runs import carmen_log, fails, run, start
from played import address, ld19, record

from laserfeatures import registry
from laserfeatures.cli.live_display import Tally
from laserfeatures.drivers import Losses
from laserfeatures.emulators import Emulator, WorldFeed
from laserfeatures.emulators.urg import UrgDevice
from laserfeatures.simulation import hallway


@pytest.fixture(scope="module")
def port():
    with ld19() as emulator:
        yield address(emulator)


@pytest.fixture(scope="module")
def recording(port, tmp_path_factory):
    path = tmp_path_factory.mktemp("live") / "run.rec"
    record(path, port, 12)
    return path


def test_a_pipe_gets_a_line_a_second_and_a_summary(port):
    result = run("live", port, "--seconds", "1500ms")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert len(lines) == 2
    assert re.search(
        r"^\d\.\d s  \d+ scans  (9\.\d|10\.\d) /s  latency \d+\.\d ms median, \d+\.\d ms p99"
        r"  lost 0  losses [^d]*  \d+ lines  \d+ corners  nearest \(-?\d+\.\d\d, -?\d+\.\d\d\) m ",
        lines[-1],
    )
    assert re.fullmatch(
        r"laserfeatures: 1\d scans in 1\.\d s .*; lost scans: 0; losses: [^d]*\n", result.stderr
    )


def test_the_output_is_what_extract_writes(recording, tmp_path):
    live = run("live", f"replay:{recording}?speed=20", "-o", tmp_path / "live.jsonl")
    assert live.exit_code == 0
    assert (tmp_path / "live.jsonl").read_text() == run("extract", recording).stdout
    both = run("live", f"replay:{recording}?speed=20", "-o", "-", "-e", "split_and_merge")
    assert both.stdout == run("extract", recording, "-e", "split_and_merge").stdout
    assert "corners" in both.stderr


def test_an_older_output_is_replaced_as_by_extract_but_stays_where_nothing_comes(
    recording, tmp_path
):
    path = tmp_path / "live.jsonl"
    path.write_text("precious")
    fails("live", "ld19:///dev/no-such-port", "-o", path)
    assert path.read_text() == "precious"
    for arguments in (["live", f"replay:{recording}?speed=50"], ["extract", recording]):
        path.write_text("old")
        assert run(*arguments, "-o", path).exit_code == 0
        assert json.loads(path.read_text().splitlines()[0])["index"] == 0
    assert run("live", f"replay:{recording}?speed=50", "-o", path, "--force").exit_code == 0
    for command, rule in (
        ("live", "replaces an older file of that name"),
        ("extract", "replaces an older file of that name"),
        ("record", "an older one is replaced with --force only"),
    ):
        assert rule in " ".join(run(command, "--help").stdout.split())


def test_what_is_no_port_is_named(recording, tmp_path):
    assert f"or replay:{recording} if it is a recording" in fails("live", recording)
    assert "is no port" in fails("live", carmen_log(tmp_path / "x.log"))
    assert "there is no such port" in fails("live", "ld19:///dev/no-such-port")
    assert "did you mean 'ransac'" in fails("live", "ld19:///dev/no-such-port", "-e", "ransc")


def test_a_wrong_device_or_rate_is_named(port):
    world, path = hallway()
    urg = UrgDevice(WorldFeed(world, path[0]), state="streaming")
    with (
        Emulator(urg) as emulator,
        start("live", f"ld19:{emulator.port}") as wrong_device,
        start("live", f"{port}?baud=115200") as wrong_rate,
    ):
        _, said = wrong_device.communicate(timeout=30)
        assert b"got a Hokuyo that speaks SCIP (urg:)" in said
        _, said = wrong_rate.communicate(timeout=30)
        assert b"a wrong baud rate, or another device" in said
    assert (wrong_device.returncode, wrong_rate.returncode) == (2, 2)


def test_an_extractor_that_fails_is_named(recording, monkeypatch):
    def fragile(scan):
        if len(scan) > 200:
            raise ZeroDivisionError
        return registry.get_extractor("direct_hough").detector(scan)

    monkeypatch.setitem(registry._registered, "fragile", lambda: fragile)
    line = fails("live", f"replay:{recording}", "-e", "fragile")
    assert "extractor 'fragile' failed at scan 0: ZeroDivisionError" in line


def test_an_unplugged_device_is_one_line_or_waited_for(tmp_path):
    with ld19({"unplug": 0.01}, link=tmp_path / "port") as emulator:
        result = run("live", address(emulator))
        assert result.exit_code == 2
        assert "the device is gone" in result.stderr
        emulator.device.faults.rates = {}
        time.sleep(0.5)  # it comes back
        went_on = run("live", address(emulator), "--reconnect", "--seconds", "1")
        assert went_on.exit_code == 0


def test_a_terminal_is_redrawn_in_place_until_ctrl_c(port, tmp_path):
    ours, theirs = pty.openpty()
    arguments = ("live", port, "-o", tmp_path / "live.jsonl")
    with start(*arguments, stdout=theirs, env={"COLUMNS": "80"}) as process:
        os.close(theirs)
        shown = b""
        while shown.count(b"\x1b[8F") < 3:
            shown += os.read(ours, 4096)
        process.send_signal(signal.SIGINT)
        with suppress(OSError):  # how a terminal tells its end
            while os.read(ours, 4096):
                pass
        os.close(ours)
        said = process.stderr.read()
        assert process.wait(timeout=30) == 0
    assert b" scans in " in said
    assert b"corners" in shown
    lines = (tmp_path / "live.jsonl").read_bytes().splitlines(keepends=True)
    assert all(json.loads(line)["corners"] and line.endswith(b"\n") for line in lines)
    assert len(lines) >= 6


def test_a_second_ctrl_c_aborts():
    code = """
import signal, os
from laserfeatures.cli import ports
from laserfeatures.sources.live import Limits, LiveSource

class Endless(LiveSource):
    losses = arrival = 0
    def _wait(self): ...
    def close(self): ...

with ports.ended_by_ctrl_c(Endless("x", "x", Limits(), None)):
    os.kill(os.getpid(), signal.SIGINT)
    print("first", flush=True)
    os.kill(os.getpid(), signal.SIGINT)
    print("second", flush=True)
"""
    with start(code=code) as process:
        out, err = process.communicate(timeout=30)
    assert out == b"first\n"
    assert b"KeyboardInterrupt" in err


def test_the_tally_counts():
    tally = Tally(Losses())
    assert (tally.rate, tally.latency()) == (0.0, "-")
    for i in range(101):
        tally.add(arrival=i / 10, done=i / 10 + i / 1000)
    assert tally.rate == pytest.approx(10)
    assert tally.latency() == "50.0 ms median, 99.0 ms p99"
    assert tally.scans == 101
