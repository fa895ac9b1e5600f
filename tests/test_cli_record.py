import itertools
import json
import re
import signal

import pytest
from bounded import until
from cli_runs import fails, run, start
from played import address, ld19

import laserfeatures as lf


@pytest.fixture(scope="module")
def port():
    with ld19() as emulator:
        yield address(emulator)


def scans_beside(path):
    return sum("scan" in json.loads(line) for line in path.read_text().splitlines())


def test_a_number_of_scans_or_a_time(port, tmp_path):
    result = run("record", port, "-o", tmp_path / "run.rec", "--scans", 3)
    assert result.exit_code == 0
    assert not result.stdout
    assert result.stderr.startswith("laserfeatures: 3 scans in 0.")
    assert f" kB in {tmp_path / 'run.rec'}; lost: " in result.stderr
    assert "damaged" not in result.stderr
    assert scans_beside(tmp_path / "run.rec") == 3
    assert run("record", port, "-o", tmp_path / "s.rec", "--seconds", "500ms").exit_code == 0
    assert 2 <= scans_beside(tmp_path / "s.rec") <= 5


def test_the_other_commands_read_it(port, tmp_path):
    run("record", port, "-o", tmp_path / "run.rec", "--scans", 3)
    told = run("info", tmp_path / "run.rec").stdout
    assert "recording" in told
    assert re.search(r"(9\.\d+|10(\.\d+)?) scans/s", told)
    assert run("info", f"replay:{tmp_path / 'run.rec'}?speed=20").exit_code == 0


def test_an_older_file_stays_unless_forced(port, tmp_path):
    path = tmp_path / "run.rec"
    path.write_text("precious")
    assert "run.rec: is there already: give another name, or --force" in fails(
        "record", port, "-o", path, "--scans", 1
    )
    assert "there is no such port" in fails("record", "ld19:///dev/no", "-o", path, "--force")
    assert path.read_text() == "precious"
    assert run("record", port, "-o", path, "--scans", 1, "--force").exit_code == 0
    assert scans_beside(path) == 1


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["ld19:///dev/no-such-port"], "no-such-port: there is no such port"),
        (["ld20:///dev/null"], "there is no driver 'ld20'; there are: ld19, lms"),
        (["run.log"], "there is no driver 'run.log'"),
        (["ld19:"], "expected a port after ld19:"),
        (["ld19:///dev/null", "--scans", "0"], "0 is not in the range"),
        (["ld19:///dev/null", "--seconds", "0"], "seconds must be > 0 s"),
        (["ld19:///dev/null"], "/dev/null: cannot be used as a serial port"),
        (["ld19:/dev"], "/dev: expected a serial port, got a folder"),
    ],
)
def test_a_wrong_argument_leaves_no_file(tmp_path, arguments, reason):
    assert reason in fails("record", *arguments, "-o", tmp_path / "run.rec")
    assert not list(tmp_path.iterdir())


def test_an_output_that_cannot_be_written_is_told_before_the_port_is_opened(tmp_path):
    assert "No such file or directory" in fails("record", "ld19:x", "-o", tmp_path / "no" / "x")
    assert "Is a directory" in fails("record", "ld19:x", "-o", tmp_path)
    assert "--output" in fails("record", "ld19:x")


def test_a_port_in_use_is_told(port, tmp_path):
    with lf.open_source(port):
        line = fails("record", port, "-o", tmp_path / "run.rec")
    assert "another program uses this port: close it first" in line


def test_an_unplugged_device_ends_it_and_what_came_stays(tmp_path):
    with ld19({"unplug": 0.01}, link=tmp_path / "port") as emulator:
        line = fails("record", address(emulator), "-o", tmp_path / "run.rec")
    assert "the device is gone" in line
    assert "--reconnect" in line
    *_, last = (tmp_path / "run.rec").read_text().splitlines()
    assert "the device is gone" in json.loads(last)["error"]


def test_a_reconnect_is_told_once(tmp_path):
    with ld19({"unplug": 0.003}, unplugged_time=0.7, link=tmp_path / "port") as emulator:
        faults = emulator.device.faults
        arguments = ("-o", tmp_path / "run.rec", "--reconnect", "--seconds", "2.5")
        result = run("record", address(emulator), *arguments)
        assert faults.rates
    assert result.exit_code == 0
    assert "waiting for the device" in result.stderr
    *told, last = result.stderr.splitlines()
    assert " reconnects" in last
    assert all(a != b for a, b in itertools.pairwise(told))


def test_ctrl_c_ends_it(port, tmp_path):
    path = tmp_path / "run.rec"
    with start("record", port, "-o", path) as process:
        until_scanned(path)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 0
    assert not out
    assert b" scans in " in err
    assert json.loads(path.read_text().splitlines()[-1])["end"] is True


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_sigterm_and_sighup_end_it_as_ctrl_c_does(port, tmp_path, number):
    path = tmp_path / "run.rec"
    with start("record", port, "-o", path) as process:
        until_scanned(path)
        process.send_signal(number)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 128 + number
    assert not out
    assert re.fullmatch(rb"laserfeatures: \d+ scans in .*\n", err)
    last = json.loads(path.read_text().splitlines()[-1])
    assert last["end"] is True
    assert "error" not in last


def test_two_recordings_into_one_file(tmp_path):
    path = tmp_path / "run.rec"
    with (
        ld19(link=tmp_path / "one") as one,
        ld19(link=tmp_path / "two") as two,
        start("record", address(one), "-o", path, "--force") as process,
    ):
        until_scanned(path)
        line = fails("record", address(two), "-o", path, "--force", "--scans", 2)
        assert "run.rec: another program is writing it: give another name" in line
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        with lf.open_source(path) as source:
            assert len(list(source)) >= 3
        assert run("record", address(two), "-o", path, "--force", "--scans", 2).exit_code == 0
    assert scans_beside(path) == 2


def test_what_was_written_before_a_kill_is_read(port, tmp_path):
    path = tmp_path / "run.rec"
    with start("record", port, "-o", path) as process:
        until_scanned(path)
        process.kill()
    with lf.open_source(path) as source:
        assert len(list(source)) >= 3


def until_scanned(path):
    """Wait until a recording has some scans."""
    until(lambda: path.exists() and path.read_bytes().count(b'"scan"') >= 4)
