"""The driver and the emulator on a pseudo-terminal, in real time."""

import time
from itertools import pairwise

import numpy as np
import pytest
from urg_lines import number_of, numbered

from laserfeatures.drivers import make_driver
from laserfeatures.drivers.urg import Urg
from laserfeatures.drivers.urg.scip import sum_of
from laserfeatures.emulators import Emulator, Faults
from laserfeatures.emulators.device import Device
from laserfeatures.emulators.urg import UrgDevice, answers
from laserfeatures.errors import DriverError, DriverTimeoutError, ProtocolError


def scans(device, count=2, **parameters):
    """Return so many scans, the driver, and how long opening and closing took [s]."""
    with Emulator(device) as emulator:
        begin = time.monotonic()
        driver = Urg(port=emulator.port, **parameters)
        with driver:
            opened = time.monotonic() - begin
            found = [next(driver) for _ in range(count)]
            begin = time.monotonic()
        return found, driver, (opened, time.monotonic() - begin)


@pytest.mark.parametrize(
    "start",
    [
        {},
        {"state": "laser on"},
        {"state": "streaming"},
        {"state": "streaming", "stream": "MS0044072501900"},
        {"state": "streaming", "stream": "MD0044072501000", "left_over": b"G"},
        {"state": "tm"},
        {"state": "scip1"},
        {"left_over": b"MD00"},
        {"left_over": 60 * b"x"},
    ],
    ids=str,
)
def test_every_state_is_taken_over(start):
    device = UrgDevice(numbered(), **start)
    found, driver, (opened, closed) = scans(device)
    assert opened < 1.5
    assert closed < 1.0
    first, second = (number_of(scan) for scan in found)
    assert second == first + 1
    assert (second, None) in device.frames
    assert device.state.mode == "idle"
    assert np.diff([scan.stamp for scan in found]) == pytest.approx(0.1, abs=0.002)
    assert 0.05 < driver.arrival - found[-1].stamp < 0.5
    assert driver.losses.scans == driver.losses.refusals == driver.losses.restarts == 0


@pytest.mark.parametrize(
    ("start", "wanted", "put_back"),
    [
        ({}, None, 19_200),
        ({"baud": 115_200, "state": "idle"}, 115_200, 115_200),
        ({"state": "streaming", "stream": "MD0044072501900"}, 250_000, 19_200),
    ],
    ids=str,
)
def test_the_rate_is_found_changed_and_put_back(start, wanted, put_back):
    device = UrgDevice(numbered(), model="classic", **start)
    found, driver, (opened, _) = scans(device, count=1, baud=wanted, cluster=9)
    assert opened < 6.0
    assert len(found[0]) == 76
    assert device.baud == put_back
    assert driver.version["PROD"] == "SOKUIKI Sensor URG-04LX"


@pytest.mark.parametrize(
    ("parameters", "beams", "command"),
    [
        ({"mode": "MS"}, 682, b"MS0044072501000"),
        ({"mode": "MD", "first": 300, "last": 400, "skip": 1, "cluster": 2}, 51, None),
        ({"high_sensitivity": True, "motor_speed": 10, "reset": True}, 682, None),
        ({"clock_samples": 0}, 682, None),
    ],
    ids=str,
)
def test_parameters(parameters, beams, command):
    sent = []
    device = UrgDevice(numbered())
    found, driver, _ = scans(
        device, 3, tap=lambda way, data, _time: way == "tx" and sent.append(data), **parameters
    )
    assert [len(scan) for scan in found] == [beams] * 3
    assert command is None or command + b"\n" in sent
    assert device.state.sensitive == bool(parameters.get("high_sensitivity"))
    assert driver.geometry.speed == (540 if "motor_speed" in parameters else 600)
    period = 60 / driver.geometry.speed * (parameters.get("skip", 0) + 1)
    assert np.diff([scan.stamp for scan in found]) == pytest.approx(period, abs=0.002)
    assert -0.01 < driver.arrival - found[-1].stamp < 0.5
    assert number_of(found[0]) < number_of(found[1])


def test_single_scans_are_fetched_when_asked_for():
    device = UrgDevice(numbered())
    with Emulator(device) as emulator, Urg(port=emulator.port, mode="GD") as driver:
        begin = time.time()
        first = next(driver)
        time.sleep(0.3)
        second = next(driver)
    assert abs(first.stamp - begin) < 0.5
    assert 0.25 < second.stamp - first.stamp < 1.0
    assert [number_of(scan) for scan in (first, second)] == [0, 1]
    assert list(driver) == []


def test_the_address_names_the_parameters():
    driver = make_driver("urg:///dev/ttyACM0?skip=1&mode=MS&high_sensitivity=1&first=100")
    assert (driver.skip, driver.mode, driver.high_sensitivity, driver.first) == (1, "MS", True, 100)


@pytest.mark.parametrize(
    "wrong",
    [
        {"mode": "ME"},
        {"cluster": 0},
        {"skip": 10},
        {"first": -1},
        {"first": 300, "last": 200},
        {"motor_speed": 11},
        {"clock_samples": 65},
        {"baud": 0},
    ],
    ids=str,
)
def test_parameters_are_checked(wrong):
    with pytest.raises(ValueError, match=next(reversed(wrong))):
        Urg(port="/dev/null", **wrong)


@pytest.mark.parametrize(
    "answer",
    [
        (b"00", b"FIRM:3.0.00(06/Oct./2004);X\n"),  # not its sum
        (b"00", b"no key;" + sum_of(b"no key") + b"\n"),
        (b"00", b"VEND:\xfc;Z\n"),
        (b"0E", b""),
    ],
    ids=str,
)
@pytest.mark.parametrize("command", [b"VV", b"II"])
def test_only_pp_is_needed_to_measure(command, answer, monkeypatch, caplog):
    monkeypatch.setitem(answers._SIMPLE, command, lambda *_: answer)
    found, driver, _ = scans(UrgDevice(numbered()), 2, motor_speed=5)
    assert [len(scan) for scan in found] == [682] * 2
    assert driver.geometry.model.startswith("URG-04LX-UG01")
    assert "wrong sum" in caplog.text or f"without what {command.decode()} tells" in caplog.text


def test_a_refusal_is_named():
    with pytest.raises(DriverError, match=r"04: the last step is out of range .*44\.\.725"):
        scans(UrgDevice(numbered()), last=800)


class Talker(Device):
    """Something else on the port."""

    name = "talker"
    text = b"$GPGGA,123519,4807.038,N\r\n"

    def power_on(self, now):
        self.at = now

    def hear(self, data, now):
        pass

    def next_event(self):
        return self.at

    def advance(self, now):
        while self.at <= now:
            self.say(self.text, self.at)
            self.at += 0.05


class Mute(Talker):
    """A port where nobody is."""

    text = b""


@pytest.mark.parametrize(
    ("device", "error", "says"),
    [(Talker, ProtocolError, "GPS"), (Mute, DriverTimeoutError, "silence")],
)
def test_a_wrong_device_is_named(device, error, says, monkeypatch):
    monkeypatch.setattr("laserfeatures.drivers.urg.driver.RATES", (115_200,))
    with pytest.raises(error, match=f"expected a Hokuyo that answers QT and VV, got .*{says}"):
        scans(device(numbered()))


def test_a_stuck_sensor_is_left_in_time():
    device = UrgDevice(numbered(), Faults(stuck_time=60.0))
    with Emulator(device) as emulator, Urg(port=emulator.port) as driver:
        next(driver)
        device.faults.rates["stuck"] = 1.0
        time.sleep(0.15)
        begin = time.monotonic()
    assert time.monotonic() - begin < 5.0


@pytest.mark.parametrize(
    ("trouble", "says"), [("failure", "status 51"), ("frozen", "stands still")]
)
def test_a_stream_that_ends_is_started_again(trouble, says):
    device = UrgDevice(numbered())
    with Emulator(device) as emulator, Urg(port=emulator.port) as driver:
        next(driver)
        device._troubles[trouble] = 1.0
        while device.state.stream is not None and not driver.losses.refusals:
            time.sleep(0.01)
            if driver.losses.damaged >= 3:
                break
        device._troubles.clear()
        found = [next(driver) for _ in range(3)]
    assert driver.losses.restarts == 1
    assert says in driver.losses.problem
    assert all(a.stamp < b.stamp for a, b in pairwise(found))
