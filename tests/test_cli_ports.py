"""The commands that take a log take a port, and Ctrl-C ends it as a log ends."""

import json
import signal
import threading
import time

import pytest
from bounded import until
from cli_runs import fails, run, start
from played import address, ld19


@pytest.fixture(scope="module")
def port():
    with ld19() as emulator:
        yield address(emulator)


def test_info_and_plot_and_compare_read_a_port(port, tmp_path):
    told = run("info", f"{port}?scans=4")
    assert told.stdout.startswith("format            ld19\nscans             4\n")
    assert not told.stderr
    picture = tmp_path / "scan.png"
    assert run("plot", port, "--scan", 1, "-o", picture, "-e", "split_and_merge").exit_code == 0
    assert picture.stat().st_size > 1000
    table = run("compare", port, "--count", 2, "--extractors", "split_and_merge")
    assert table.exit_code == 0
    assert "split_and_merge" in table.stdout


def test_extract_reads_a_port_and_drops_what_is_too_far(port):
    result = run("extract", port, "--count", 2, "--range-max", "2m", "-e", "split_and_merge")
    first, second = (json.loads(line) for line in result.stdout.splitlines())
    assert (first["index"], second["index"]) == (0, 1)
    assert second["stamp"] - first["stamp"] == pytest.approx(0.1, abs=0.05)
    ends = [end for s in first["segments"] for end in ((s["x1"], s["y1"]), (s["x2"], s["y2"]))]
    assert all(x**2 + y**2 < 2.1**2 for x, y in ends)


def test_ctrl_c_completes_what_is_written(port, tmp_path):
    path = tmp_path / "out.jsonl"
    with start("extract", port, "-e", "split_and_merge", "-o", path) as process:
        aside = tmp_path / f".out.jsonl.{process.pid}.part"
        until(lambda: aside.exists() and aside.stat().st_size)  # its first block
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
        assert (out, err.count(b"\n")) == (b"", 1)
        assert err.startswith(b"laserfeatures: wrote ")
    assert process.returncode == 0
    records = [json.loads(line) for line in path.read_text().splitlines()]
    assert [record["index"] for record in records] == list(range(len(records)))


def test_a_time_limit_ends_it_though_no_scan_comes(tmp_path):
    with ld19(link=tmp_path / "port", unplugged_time=3) as emulator:
        pulling = threading.Timer(0.7, emulator.device.faults.rates.update, ({"unplug": 1.0},))
        pulling.start()
        began = time.monotonic()
        result = run("info", address(emulator, "reconnect=1&seconds=1.5"))
        assert time.monotonic() - began < 2.5
    assert result.exit_code == 0
    assert "waiting for the device" in result.stderr
    assert "format            ld19" in result.stdout


def test_an_option_that_a_port_has_not_is_one_line():
    assert "topic does not apply to a port" in fails("info", "ld19:///dev/null", "--topic", "/x")
    assert "expected a file or folder, or an address" in fails("info", "gps:///dev/null")
