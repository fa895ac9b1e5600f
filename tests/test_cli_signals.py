"""Signals: every command heeds them, cleans up, stops lasers, and tells them by its exit status."""

import importlib
import os
import pkgutil
import pty
import signal
import subprocess
import sys
import time
import types
import typing
from contextlib import suppress

import laserfeatures_plugins
import numpy as np
import pytest
from bounded import Child
from cli_runs import ENTRY, carmen_log, run, start
from llvmlite.binding.executionengine import ExecutionEngine
from numba import config, njit
from numbered import NumberedFeed
from played import sends_on

import laserfeatures
import laserfeatures as lf
from laserfeatures import compiled, registry
from laserfeatures.emulators import Emulator
from laserfeatures.emulators.devices import device_class
from laserfeatures.simulation import Scanner, hallway

COMPILED = ("direct_hough", "ransac", "region_growing", "split_and_merge")
TRIES = 25


class OutOfTimeError(Exception):
    """What a handler of a user's own raises."""


def interrupt(extractor, after, error):
    """Call an extractor over and over until a signal's handler raises an error."""

    def raises(_number, _frame):
        raise error

    world, path = hallway()
    scan = Scanner().scan(world, path[0], np.random.default_rng(0))
    extractor(scan)
    before = signal.signal(signal.SIGALRM, raises)

    def endless():
        while True:
            extractor(scan)

    try:
        signal.setitimer(signal.ITIMER_REAL, after)
        endless()
    finally:
        signal.signal(signal.SIGALRM, before)


@njit
def count(values):
    more = values
    for _ in range(300):
        more = more + 1.0
    return values, more


def foreign(scan):
    """Find nothing, with compiled code that is no `kernel`."""
    count(scan.ranges)
    return lf.LineSegments.none(len(scan))


@pytest.mark.skipif(config.DISABLE_JIT, reason="the kind of fault is one of compiled code")
@pytest.mark.parametrize("error", [KeyboardInterrupt, OutOfTimeError])
@pytest.mark.parametrize("name", [*COMPILED, "foreign"])
def test_what_a_handler_raises_comes_out_of_compiled_code(name, error, monkeypatch):
    monkeypatch.setitem(registry._registered, "foreign", lambda: foreign)
    extractor = lf.get_extractor(name)
    for after in np.linspace(0.001, 0.004, TRIES):
        with pytest.raises(error):
            interrupt(extractor, after, error)


def test_no_kernel_returns_a_named_tuple():
    """Making one runs code of Python, and a handler in it: numba then ends the interpreter."""
    seen = 0
    for package in (laserfeatures, laserfeatures_plugins):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if module.name.endswith("__main__"):
                continue
            for value in vars(importlib.import_module(module.name)).values():
                if isinstance(value, compiled._Kernel):
                    seen += 1
                    returned = typing.get_type_hints(value.py_func)["return"]
                    parts = typing.get_args(returned) or (returned,)
                    assert not any(hasattr(part, "_fields") for part in parts), value
    assert seen > 20 or config.DISABLE_JIT


@pytest.mark.skipif(config.DISABLE_JIT, reason="the kind of fault is one of compiling")
@pytest.mark.parametrize("where", ["_raw_object_cache_notify", "__del__", "elsewhere"])
def test_ctrl_c_while_llvm_calls_back_is_heard(where, monkeypatch):
    """Python is only called back after LLVM was busy: there handlers run, and nothing comes out."""
    sent = []

    def lost():  # as ctypes has it: the exception is shown, and gone
        with suppress(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    callback = types.FunctionType(lost.__code__.replace(co_name=where), globals())
    assert hasattr(ExecutionEngine, "_raw_object_cache_notify")

    def compiling(*_args, **_named):
        sent.append(1)
        callback()
        if where != "elsewhere":
            time.sleep(30)
        return lambda x: x

    monkeypatch.setattr(compiled.CPUDispatcher, "_compile_for_args", compiling)
    fresh = compiled.kernel(lambda x: x)
    if where == "elsewhere":
        fresh(1.0)  # what this test takes for granted: there it is lost
    else:
        with pytest.raises(KeyboardInterrupt):
            fresh(1.0)
    assert sent
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
@pytest.mark.parametrize("wrapped", [True, False])
def test_a_signal_is_the_status_whatever_an_extractor_makes_of_it(
    number, status, wrapped, monkeypatch, tmp_path
):
    def detector(_scan):
        try:
            os.kill(os.getpid(), number)
            time.sleep(30)
        except BaseException as error:
            if wrapped:
                raise ValueError from error
            raise

    monkeypatch.setitem(registry._registered, "waits", lambda: detector)
    handlers = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    path = tmp_path / "out.jsonl"
    log = carmen_log(tmp_path / "hallway.log")
    result = run("extract", log, "-e", "waits", "-o", path)
    assert result.exit_code == status
    assert "failed" not in result.stderr
    assert not path.exists()
    assert handlers == [
        signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    ]


@pytest.mark.parametrize("made", [lambda: sys.exit(5), lambda: lambda _: sys.exit(5)])
def test_an_extractor_that_ends_the_program_is_bad_input(made, monkeypatch, tmp_path):
    monkeypatch.setitem(registry._registered, "quits", made)
    result = run("extract", carmen_log(tmp_path / "hallway.log"), "-e", "quits")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert "SystemExit: 5" in line


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_while_a_plugin_is_loaded_is_not_taken_for_its_own_end(
    number, status, monkeypatch, tmp_path
):
    def made():
        os.kill(os.getpid(), number)
        time.sleep(30)

    monkeypatch.setitem(registry._registered, "waits", made)
    log = carmen_log(tmp_path / "hallway.log")
    assert run("extract", log, "-e", "waits").exit_code == status
    assert run("compare", log, "--extractors", "waits,split_and_merge").exit_code == status


@pytest.mark.parametrize("device", ["urg", "lms", "rplidar"])
@pytest.mark.parametrize("command", ["live", "record", "extract"])
def test_a_terminal_that_closes_stops_the_sweep(device, command, tmp_path):
    ours, theirs = pty.openpty()
    arguments = () if command == "live" else ("-o", tmp_path / "out")
    with Emulator(device_class(device)(NumberedFeed())) as played:
        address = f"{device}:{played.port}"
        with start(command, address, *arguments, stdout=theirs, stderr=theirs) as process:
            os.close(theirs)
            while not played.device.frames:
                time.sleep(0.01)
                assert process.poll() is None
            time.sleep(0.5)
            os.close(ours)
            process.send_signal(signal.SIGHUP)
            process.send_signal(signal.SIGHUP)  # of the shell, and of the terminal
            time.sleep(0.05)
            process.send_signal(signal.SIGHUP)
            assert process.wait(timeout=30) == 129
        assert not sends_on(played)


@pytest.mark.parametrize("device", ["urg", "lms", "rplidar"])
def test_a_reader_that_leaves_stops_the_sweep(device):
    with Emulator(device_class(device)(NumberedFeed())) as played:
        with start("live", f"{device}:{played.port}") as process:
            assert b"scans" in process.stdout.readline()
            process.stdout.close()
            assert process.wait(timeout=30) == 0
        assert not sends_on(played)


def test_nohup_is_heeded(tmp_path):
    with Emulator(device_class("urg")(NumberedFeed())) as played:
        path = tmp_path / "out.rec"
        before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
        command = [sys.executable, "-c", ENTRY, "record", f"urg:{played.port}", "-o", path]
        try:
            process = Child([*command, "--scans", "10"], heeds=False, stderr=subprocess.PIPE)
        finally:
            signal.signal(signal.SIGHUP, before)
        with process:
            while not played.device.frames:
                time.sleep(0.01)
            process.send_signal(signal.SIGHUP)
            assert b"10 scans" in process.communicate(timeout=30)[1]
        assert process.returncode == 0


@pytest.mark.parametrize("command", ["record", "live", "emulate"])
def test_ctrl_c_is_heard_though_a_script_started_it_in_the_background(command, tmp_path):
    with Emulator(device_class("urg")(NumberedFeed())) as played:
        address = f"urg:{played.port}"
        arguments = {
            "record": ("record", address, "-o", tmp_path / "run.rec"),
            "live": ("live", address),
            "emulate": ("emulate", "urg", "--pty-link", tmp_path / "link"),
        }[command]
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            process = start(*arguments, heeds=False, env={"PYTHONUNBUFFERED": "1"})
        finally:
            signal.signal(signal.SIGINT, before)
        with process:
            if command == "record":
                while not played.device.frames:
                    time.sleep(0.01)
                time.sleep(0.5)
            else:
                process.stdout.readline()
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=30)
        assert process.returncode == 0
    assert not os.path.lexists(tmp_path / "link")


@pytest.mark.parametrize(
    "command",
    [
        "extract {log}",
        "extract {log} -o {out}",
        "extract",
        "extractors",
        "--help",
        "extract --help",
        "--version",
        "info {log}",
    ],
)
@pytest.mark.parametrize("shut", [">&-", "2>&-", "<&-", ">&- 2>&-", "> /dev/full", "<&- >&- 2>&-"])
def test_no_traceback_where_a_standard_stream_is_closed_or_full(command, shut, tmp_path):
    names = {"log": carmen_log(tmp_path / "a.log", 2), "out": tmp_path / "out.jsonl"}
    given = command.format(**names).split()
    done = subprocess.run(  # noqa: S603 - our own command
        ["/bin/sh", "-c", f'exec "$@" {shut}', "sh", sys.executable, "-m", "laserfeatures", *given],
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    assert done.stderr.count("\n") <= 1 or command == "extract"
    speaks = "{out}" not in command and command != "extract"
    lost = speaks and (">&-" in shut.split() or "full" in shut)
    assert done.returncode == (2 if lost or command == "extract" else 0)
    if lost and "2>&-" not in shut:
        assert "standard output is closed" in done.stderr or "No space left" in done.stderr
    if "{out}" in command:
        assert names["out"].read_text().count("\n") == 2


def test_children_of_tests_hear_signals_and_end_with_the_block():
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        command = [sys.executable, "-c", "import time; print(1, flush=True); time.sleep(600)"]
        with Child(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
            process.stdout.readline()
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=30) == -signal.SIGINT
        with pytest.raises(KeyError), Child(command) as process:
            raise KeyError
        assert process.returncode == -signal.SIGKILL
    finally:
        signal.signal(signal.SIGINT, before)
