import math
import os
import re
import signal
import socket

import click
import numpy as np
import pytest
from cli_runs import carmen_log, fails, start
from numbered import NumberedFeed

import laserfeatures as lf
from laserfeatures.cli.emulated import Place, make_feed
from laserfeatures.cli.emulated_device import make_device
from laserfeatures.drivers import make_driver
from laserfeatures.emulators.devices import DEVICES, device_class

ROOM = """
[[outline]]
points = [[0, 0], [4, 0], [4, 3], [0, 3]]
"""
DRIVE = "[drive]\nwaypoints = [[1, 1], [3, 1]]\n"


@pytest.fixture
def room(tmp_path):
    path = tmp_path / "room.toml"
    path.write_text(ROOM)
    return str(path)


def test_it_prints_the_command_that_reads_it_and_plays_until_ctrl_c(tmp_path, room):
    link = tmp_path / "lidar"
    arguments = ("--pty-link", link, "--world", room, "--at", "1,1,0", "--fault", "bit_flip=0.05")
    with start("emulate", "ld19", *arguments, env={"PYTHONUNBUFFERED": "1"}) as process:
        assert process.stdout.readline().decode() == f"LD19 at {link}\n"
        command = process.stdout.readline().decode().split()
        assert command == ["laserfeatures", "live", f"ld19://{link}"]
        with lf.open_source(command[-1] + "?scans=5") as source:
            scan = list(source)[-1]
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 0
    assert not out
    assert re.fullmatch(
        rb"laserfeatures: \d+ frames of scans were sent; hit by faults: \d+ bit_flip\n", err
    )
    assert source.skipped > 0
    ahead = scan.ranges[np.argmin(abs(scan.angles))]
    left = scan.ranges[np.argmin(abs(scan.angles - math.pi / 2))]
    assert (ahead, left) == (pytest.approx(3, abs=0.05), pytest.approx(2, abs=0.05))
    assert not os.path.lexists(link)


def test_a_tcp_port_and_a_log_for_a_time(tmp_path):
    log = carmen_log(tmp_path / "hallway.log")
    arguments = ("--log", log, "--tcp", 0, "--seconds", "2", "--speed", "2")
    with start("emulate", "ld19", *arguments, env={"PYTHONUNBUFFERED": "1"}) as process:
        process.stdout.readline()
        address = process.stdout.readline().split()[-1].decode()
        assert address.startswith("ld19:socket://127.0.0.1:")
        with lf.open_source(address + "?scans=3") as source:
            scan = list(source)[-1]
        assert process.wait(timeout=30) == 0
    assert scan.valid.sum() == pytest.approx(len(scan) / 2, rel=0.05)  # the log's half turn


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["ld20"], "'ld20' is not one of 'urg', 'lms', 'rplidar', 'ld19'"),
        (["ld19", "--fault", "bitflip"], "no fault 'bitflip'; did you mean 'bit_flip'"),
        (
            ["ld19", "--fault", "left_streaming"],
            "no fault 'left_streaming'; there are: bit_flip,",
        ),
        (["ld19", "--fault", "cut=2"], "the rate of cut must be in [0, 1], got 2"),
        (["ld19", "--fault", "cut=x"], "--fault cut: the rate must be a number, got 'x'"),
        (["ld19", "--model", "x"], "ld19 has no parameter 'model'"),
        (["urg", "--model", "x"], "urg: there is no model 'x'"),
        (["urg", "--state", "x"], "state must be one of scip1, idle"),
        (["urg", "--fault", "slit"], "there is no trouble 'slit'; did you mean 'split'"),
        (["lms", "-p", "memory.angel=100"], "lms: memory has no parameter 'angel'"),
        (["lms", "-p", "baud.x=100"], "lms: baud has no parts"),
        (["ld19", "-p", "feed=x"], "ld19 has no parameter 'feed'"),
        (["ld19", "-p", "turn_rate=fast"], "turn_rate must be a number"),
        (["ld19", "-p", "turn_rate"], "--param takes name=value"),
        (["ld19", "--at", "1,2"], "must be X,Y,DEG"),
        (["ld19", "--at", "1,2,3m"], "is an angle [rad], got the length '3m'"),
        (["ld19", "--at", "0,0,0"], "--at: the sensor at (0, 0) is"),
        (["ld19", "--log", "x", "--at", "1,1,0"], "--log is instead of --world and --at"),
        (["ld19", "--log", "no.log"], "no.log: cannot be opened"),
        (["ld19", "--world", "no.toml"], "no.toml"),
        (["ld19", "--pty-link", "x", "--tcp", "0"], "give one"),
        (["ld19", "--speed", "0"], "--speed must be in (0, 1000], got 0"),
        (["ld19", "--speed", "nan"], "--speed must be in (0, 1000], got nan"),
        (["ld19", "--seconds", "0"], "--seconds must be > 0 s, got 0"),
    ],
)
def test_a_wrong_argument(arguments, reason):
    assert reason in fails("emulate", *arguments)


def test_a_link_or_port_that_is_taken(tmp_path):
    (tmp_path / "file").write_text("precious")
    assert "an existing file" in fails("emulate", "ld19", "--pty-link", tmp_path / "file")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        line = fails("emulate", "ld19", "--tcp", taken.getsockname()[1])
    assert "Address already in use" in line


def test_a_world_without_way_points_needs_a_place(room):
    assert "room.toml has no way-points: say with --at where it stands" in fails(
        "emulate", "ld19", "--world", room
    )


def test_the_robot_drives_where_there_are_way_points(tmp_path):
    pytest.importorskip("mujoco", reason="a robot needs the extra sim")
    (tmp_path / "drive.toml").write_text(ROOM + DRIVE)
    feed = make_feed(str(tmp_path / "drive.toml"), None, None, 0)
    ahead = [float(feed(np.zeros(1))[0]) for _ in range(20)]
    assert ahead[0] == pytest.approx(3, abs=0.3)
    assert ahead[-1] < ahead[0] - 0.5
    behind = feed(np.array([math.pi]))
    assert np.isfinite(behind).all()


def test_places():
    convert = Place().convert
    assert convert("1,-2cm,90", None, None) == (1, -0.02, pytest.approx(math.pi / 2))
    assert convert("1,2,1rad", None, None) == (1, 2, 1)


def made(device, *, model=None, state=None, faults=(), params=()):
    choices = {"model": model, "state": state, "faults": faults, "params": params, "seed": 3}
    return make_device(device, np.zeros_like, **choices)


def test_the_faults_of_all_devices_and_of_their_own():
    assert made("ld19", faults=("cut", "garbage=0.5")).faults.rates == {"cut": 0.01, "garbage": 0.5}
    assert made("urg", faults=("split=0.2", "cut"))._troubles == {"split": 0.2}
    rplidar = made("rplidar", faults=("angle_jump=0.3",))
    assert (rplidar._troubles, rplidar._trouble_rate) == ({"angle_jump"}, 0.3)
    lms = made("lms", faults=("bad_crc", "glued", "hangs_after=7"))
    assert (lms._bad_crc, lms._glued, lms._hangs_after) == (0.01, True, 7)


def test_the_parameters_of_devices():
    assert made("ld19", params=("turn_rate=6",))._turn_rate == 6.0
    assert made("urg", model="classic", state="streaming").state.mode == "streaming"
    assert made("rplidar", model="A2", state="protection")._start == "protection"
    assert made("lms", params=("memory.angle=100", "memory.device_type=LMS291"))
    lms = made("lms", state="booting", params=("memory.angle=100", "memory.baud=38400"))
    assert (lms._start, lms.memory.angle, lms.memory.baud) == ("booting", 100, 38400)


def test_devices_have_names():
    with pytest.raises(ValueError, match="no device 'ld18'; did you mean 'ld19'"):
        device_class("ld18")
    assert [device_class(name).__name__ for name in DEVICES] == [k for _, k in DEVICES.values()]


@pytest.mark.parametrize("name", ["urg", "lms", "rplidar"])
def test_a_device_can_be_left_streaming(name):
    device = make_device(
        name, NumberedFeed(), model=None, state=None, faults=("left_streaming",), params=(), seed=0
    )
    device.power_on(0.0)
    heard = b"".join(device.take(i / 100) for i in range(100))
    assert len(heard) > 500


@pytest.mark.parametrize(("name", "turns"), [("urg", 1 << 24), ("ld19", 30_000)])
def test_a_clock_can_be_about_to_wrap(name, turns):
    faults = ("clock_wrap", "left_streaming") if name == "urg" else ("clock_wrap",)
    device = make_device(
        name, NumberedFeed(), model=None, state=None, faults=faults, params=(), seed=0
    )
    driver = make_driver(f"{name}:none")
    decoder = driver.decoder()
    times = []
    device.power_on(0.0)
    for i in range(1200):
        for message in decoder.received(device.take(i / 100), i / 100):
            raw = getattr(message, "time", None)
            times += [] if raw is None else [raw]
    assert max(times) > turns - 200
    assert min(times) < 2500
    assert times[-1] < times[0]
    with pytest.raises(click.UsageError, match="no fault 'clock_wrap'"):
        make_device("lms", NumberedFeed(), model=None, state=None, faults=("clock_wrap",),
                    params=(), seed=0)  # fmt: skip
