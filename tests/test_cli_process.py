"""The command as a process: pipes, signals, terminals, shells."""

import json
import os
import pty
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
from cli_runs import ENTRY, carmen_log, start

SLOW = """
import sys, time
import laserfeatures as lf

def detector(scan):
    print("working", file=sys.stderr, flush=True)
    time.sleep(60)

lf.register_extractor("slow", lambda: detector)
""" + ENTRY  # fmt: skip


@pytest.fixture
def log(tmp_path):
    return carmen_log(tmp_path / "hallway.log", 200)


def test_a_reader_that_leaves_early_is_no_error(log):
    with start("extract", log) as process:
        assert json.loads(process.stdout.readline())["index"] == 0
        process.stdout.close()
        assert process.stderr.read() == b""
        assert process.wait(timeout=60) == 0


def test_a_short_output_to_a_reader_that_left_is_no_error(log):
    reading, writing = os.pipe()
    os.close(reading)
    with start("extract", log, "--count", 1, stdout=writing) as process:
        os.close(writing)
        assert process.stderr.read() == b""
        assert process.wait(timeout=60) == 0


def test_a_pipe_gets_no_progress_bar(log, tmp_path):
    with start("extract", log, "-o", tmp_path / "out.csv") as process:
        out, err = process.communicate(timeout=60)
        assert (out, err.count(b"\n")) == (b"", 1)
        assert err.startswith(b"laserfeatures: wrote ")
        assert process.returncode == 0


def test_a_terminal_gets_a_progress_bar(log, tmp_path):
    ours, theirs = pty.openpty()
    with start("extract", log, "-o", tmp_path / "out.csv", stderr=theirs) as process:
        os.close(theirs)
        shown = b""
        with suppress(OSError):  # how a terminal tells its end
            while part := os.read(ours, 4096):
                shown += part
        os.close(ours)
        assert process.wait(timeout=60) == 0
    assert b"scans" in shown
    assert b"200" in shown


COMPILES = """
import laserfeatures as lf
from laserfeatures.compiled import kernel

@kernel
def twice(x):
    return 2 * x

def detector(scan):
    twice(scan.stamp)
    return lf.LineSegments.none(len(scan))

lf.register_extractor("compiles", lambda: detector)
""" + ENTRY  # fmt: skip


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_is_told_that_compiling_takes_long(log, terminal):
    ours, theirs = pty.openpty()
    arguments = ("extract", log, "-e", "compiles", "--count", "2")
    there = theirs if terminal else subprocess.PIPE
    with start(*arguments, code=COMPILES, stderr=there) as process:
        os.close(theirs)
        shown = b"" if terminal else process.stderr.read()
        with suppress(OSError):  # how a terminal tells its end
            while terminal and (part := os.read(ours, 4096)):
                shown += part
        os.close(ours)
        assert process.wait(timeout=60) == 0
    assert shown.count(b"laserfeatures: compiling (once; ") == terminal
    assert terminal or shown.startswith(b"laserfeatures: wrote 2 scans")


@pytest.mark.parametrize(
    ("number", "status", "words"),
    [(signal.SIGINT, 130, b"interrupted"), (signal.SIGTERM, 143, b"")],
)
def test_a_signal_leaves_no_file(log, tmp_path, number, status, words):
    arguments = ("extract", log, "-e", "slow", "-o", tmp_path / "out.csv")
    with start(*arguments, code=SLOW) as process:
        assert process.stderr.readline() == b"working\n"
        assert len(list(tmp_path.iterdir())) == 2  # the log, and the output under another name
        process.send_signal(number)
        said = process.stderr.read()
        assert process.wait(timeout=60) == status
    assert words in said
    assert b"Traceback" not in said
    assert [path.name for path in tmp_path.iterdir()] == ["hallway.log"]


def test_a_full_device_is_one_line(log):
    with Path("/dev/full").open("wb") as full, start("extract", log, stdout=full) as process:
        said = process.stderr.read().decode()
        assert process.wait(timeout=60) == 2
    assert said.startswith("laserfeatures: error: ")
    assert said.count("\n") == 1


def test_listing_extractors_imports_nothing_slow():
    code = f"""
import sys
try:
    {ENTRY}
finally:
    print(*sorted({{"numba", "matplotlib", "cv2", "rosbags"}} & set(sys.modules)), file=sys.stderr)
"""
    with start("extractors", code=code) as process:
        out, err = process.communicate(timeout=60)
    assert b"direct_hough" in out
    assert err.strip() == b""


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_scripts_print(shell):
    script = Path(sys.executable).parent / "laserfeatures"
    if not script.exists():
        pytest.skip("the laserfeatures command is not installed beside this Python")
    out = subprocess.run(  # noqa: S603 - our own command
        [script],
        env={**os.environ, "_LASERFEATURES_COMPLETE": f"{shell}_source"},
        capture_output=True,
        check=True,
        timeout=60,
    ).stdout
    assert b"_LASERFEATURES_COMPLETE" in out


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("laserfeatures ext", "extract"),
        ("laserfeatures extract log --on-", "--on-error"),
        ("laserfeatures extract log -e direct", "direct_hough"),
        ("laserfeatures extractors direct", "direct_hough"),
        ("laserfeatures extract log -p theta_s", "theta_step="),
        ("laserfeatures extract log -e direct_hough -p segment_filter.max_e", "max_error="),
        ("laserfeatures plot log -p pres", "preset="),
        ("laserfeatures plot log -p preset=pa", "preset=paper"),
    ],
)
def test_the_shell_completes(words, offered):
    variables = {
        "_LASERFEATURES_COMPLETE": "zsh_complete",
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
    }
    with start(env=variables) as process:
        out, err = process.communicate(timeout=60)
    assert offered in out.decode()
    assert not err


def test_the_installed_command_tells_its_version():
    script = shutil.which("laserfeatures", path=str(Path(sys.executable).parent))
    if script is None:
        pytest.skip("the laserfeatures command is not installed beside this Python")
    out = subprocess.run([script, "--version"], capture_output=True, check=True, timeout=60).stdout  # noqa: S603 - our own command
    assert out.startswith(b"laserfeatures, version ")
