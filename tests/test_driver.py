"""What every driver does: opening, iterating, recovering, closing. Played with the LD19."""

import itertools
import signal
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, suppress

import pytest
from bounded import Child
from numbered import NumberedFeed, numbers_of
from played import sends_on

from laserfeatures import DeviceLostError, DriverError, DriverTimeoutError, ProtocolError
from laserfeatures.drivers import driver as driver_module
from laserfeatures.drivers import make_driver
from laserfeatures.drivers.usb import UsbIdentity
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.devices import device_class
from laserfeatures.emulators.ld19 import Ld19Device


def emulator(faults=None, **options):
    return Emulator(Ld19Device(NumberedFeed(), faults), **options)


def take(driver, count):
    return list(itertools.islice(driver, count))


def readers():
    return [thread.name for thread in threading.enumerate() if thread.name.startswith("read ")]


def test_making_a_driver_does_nothing():
    driver = make_driver("ld19:///dev/no-such-port")
    assert list(driver) == []
    driver.close()


def test_an_exception_in_the_block_closes_the_port():
    with emulator() as played:
        with suppress(KeyError), make_driver(f"ld19://{played.port}") as driver:
            take(driver, 1)
            raise KeyError
        assert not readers()
        with make_driver(f"ld19://{played.port}") as driver:
            assert len(take(driver, 1)) == 1


def test_a_driver_that_cannot_start_leaves_nothing_open():
    device = Ld19Device(NumberedFeed(), Faults({"stuck": 1.0}, stuck_time=60))
    with Emulator(device) as played:
        driver = make_driver(f"ld19://{played.port}")
        with pytest.raises(DriverTimeoutError):
            driver.open()
        assert not readers()


def test_opening_twice_is_refused_and_so_is_a_port_in_use():
    with emulator() as played, make_driver(f"ld19://{played.port}") as driver:
        with pytest.raises(DriverError, match="open already"):
            driver.open()
        with pytest.raises(DriverError, match="another program uses this port: close it first"):
            make_driver(f"ld19://{played.port}").open()
        assert len(take(driver, 2)) == 2


def test_scans_nobody_takes_are_dropped_from_the_oldest_on_and_counted():
    with emulator(speed=5) as played, make_driver(f"ld19://{played.port}?buffer=3") as driver:
        take(driver, 1)
        time.sleep(0.5)
        taken = take(driver, 3)
        (first,) = set(numbers_of(taken[0]))
        assert driver.losses.overruns >= first - 4 > 5
        assert driver.losses.scans == driver.losses.overruns


def test_a_stuck_device_is_waited_for():
    faults = Faults({"stuck": 0.002}, seed=3, stuck_time=1.5)
    with emulator(faults) as played, make_driver(f"ld19://{played.port}") as driver:
        assert len(take(driver, 15)) == 15
        assert driver.losses.silences == driver.losses.restarts > 0
        assert driver.losses.problem == "no scan for 1.0 s"


def test_a_device_that_stays_silent_is_given_up(monkeypatch):
    monkeypatch.setattr("laserfeatures.drivers.ld19.driver.SPIN_UP", 0.2)
    with emulator() as played, make_driver(f"ld19://{played.port}") as driver:
        take(driver, 2)
        played.device.faults.rates["stuck"] = 1.0
        played.device.faults.stuck_time = 60.0
        with pytest.raises(DriverTimeoutError, match="got silence"):
            take(driver, 1000)
        assert driver.losses.silences == driver_module.RESTARTS


def test_a_restarted_device_goes_on():
    faults = Faults({"restart": 0.003}, seed=1)
    with emulator(faults) as played, make_driver(f"ld19://{played.port}") as driver:
        assert len(take(driver, 10)) == 10
        assert any(fault == "restart" for _, fault in played.device.frames)


def test_unplugging_is_an_error_that_says_so():
    faults = Faults({"unplug": 0.01}, seed=1, unplugged_time=0.3)
    with (
        emulator(faults) as played,
        make_driver(f"ld19://{played.port}") as driver,
        pytest.raises(DeviceLostError, match=r"the device is gone .* or use reconnect=True"),
    ):
        take(driver, 1000)


def test_reconnecting_waits_for_the_device_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(driver_module, "PAUSE", 0.05)
    faults = Faults({"unplug": 0.004}, seed=1, unplugged_time=0.3)
    link = tmp_path / "lidar"
    with emulator(faults, link=link) as played:
        assert played.port == str(link)
        with make_driver(f"ld19://{link}?reconnect=1") as driver:
            assert len(take(driver, 12)) == 12
            assert driver.losses.reconnects > 0
            assert "the device is gone" in driver.losses.problem
    assert not link.is_symlink()


def test_a_usb_device_is_found_again_under_another_name(tmp_path, monkeypatch):
    """No USB device is here: what the system lists is played, the ports are real."""
    monkeypatch.setattr(driver_module, "PAUSE", 0.05)
    identity = UsbIdentity(0x10C4, 0xEA60, "0001")
    first, second = tmp_path / "ttyUSB0", tmp_path / "ttyUSB1"
    listed = {str(first): identity}
    monkeypatch.setattr("laserfeatures.drivers.usb._connected", lambda: listed)
    monkeypatch.setattr(driver_module, "usb_identity", listed.get)
    with ExitStack() as before:
        before.enter_context(emulator(link=first))
        driver = make_driver(f"ld19://{first}?reconnect=1")
        driver.open()
        take(driver, 2)
    listed.clear()
    listed[str(second)] = identity
    with emulator(link=second):
        assert len(take(driver, 5)) == 5
        assert driver.losses.reconnects == 1
        driver.close()


CTRL_C = """
import sys
from laserfeatures.drivers import make_driver
driver = make_driver(sys.argv[1])
try:
    with driver:
        for scan in driver:
            print("scan", flush=True)
except KeyboardInterrupt:
    print("interrupted, open:", driver._reader is not None, flush=True)
"""


def test_ctrl_c_closes_the_port():
    with emulator() as played:
        command = [sys.executable, "-c", CTRL_C, f"ld19://{played.port}"]
        with Child(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout.readline() == "scan\n"
            process.send_signal(signal.SIGINT)
            rest, _ = process.communicate(timeout=10)
        assert rest.splitlines()[-1] == "interrupted, open: False"
        assert process.returncode == 0


def test_what_goes_over_the_line_can_be_tapped():
    heard = []
    with (
        emulator() as played,
        make_driver(f"ld19://{played.port}", tap=lambda *event: heard.append(event)) as driver,
    ):
        scans = take(driver, 3)
    again = make_driver("ld19://none").decoder()
    decoded = [m for _, data, at in heard for m in again.received(data, at)]
    replayed = [message.scan for message in decoded if hasattr(message, "scan")]
    for scan, copy in zip(scans, replayed, strict=False):
        assert scan.stamp == copy.stamp
        assert scan.ranges.tolist() == copy.ranges.tolist()


def test_an_error_of_the_tap_reaches_the_user():
    def full(*_event):
        raise OSError(28, "No space left on device")

    with (
        emulator() as played,
        pytest.raises(OSError, match="No space left"),
        make_driver(f"ld19://{played.port}", tap=full) as driver,
    ):
        take(driver, 1)


@pytest.mark.parametrize(
    ("driver", "device", "name"),
    [
        ("lms", "urg", "a Hokuyo that speaks SCIP"),
        ("ld19", "rplidar", "an RPLIDAR"),
        ("rplidar", "lms", "a SICK LMS2xx"),
        ("urg", "ld19", "an LD06 or LD19"),
    ],
)
def test_another_device_at_the_port_is_named(driver, device, name):
    with (
        Emulator(device_class(device)(NumberedFeed())) as played,
        pytest.raises(ProtocolError, match=name),
    ):
        make_driver(f"{driver}:{played.port}").open()


@pytest.mark.parametrize("name", ["urg", "lms", "rplidar"])
def test_the_sweep_stops_after_an_exception_and_after_ctrl_c(name):
    with Emulator(device_class(name)(NumberedFeed())) as played:
        with suppress(KeyError), make_driver(f"{name}:{played.port}") as driver:
            take(driver, 2)
            assert sends_on(played)
            raise KeyError
        assert not sends_on(played)
        command = [sys.executable, "-c", CTRL_C, f"{name}:{played.port}"]
        with Child(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout.readline() == "scan\n"
            process.send_signal(signal.SIGINT)
            assert "interrupted, open: False" in process.communicate(timeout=20)[0]
        assert not sends_on(played)
