"""hokuyolx, written by others for Hokuyo's later models, takes the emulator for a real sensor."""

import numpy as np
import pytest
from client_environments import client_python, run_client
from urg_lines import numbered

from laserfeatures.emulators import Emulator
from laserfeatures.emulators.urg import UrgDevice


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    python = client_python(tmp_path_factory, "hokuyolx==0.9.0")
    device = UrgDevice(numbered(), clock_ms=123_456)
    with Emulator(device, tcp=0) as emulator:
        host, port = emulator.port.removeprefix("socket://").split(":")
        return run_client(python, "hokuyolx_client.py", host, port)


def test_it_knows_the_sensor(seen):
    assert seen["model"].startswith("URG-04LX-UG01")
    assert seen["steps"] == [44, 725, 384, 1024]
    assert seen["frequency"] == 10
    assert seen["version"]["SERI"] == "H1510998"
    assert seen["state"]["STAT"] == "Sensor works well."
    assert "0E" in seen["unknown"]


def test_it_reads_the_clock(seen):
    assert (seen["enter"][0], seen["exit"][0]) == ("00", "00")
    sensor, host = seen["clock"]
    assert sensor == pytest.approx(host, abs=50)


def test_it_lights_the_laser(seen):
    assert [seen["activate"][0], seen["again"][0]] == [0, 2]


def test_it_fetches_single_scans(seen):
    for turn, (_, values) in enumerate(seen["single"]):
        ranges = np.array(values)
        assert set(ranges[ranges >= 20].tolist()) == {100 + turn}
        assert set(ranges[300:350].tolist()) == {0, 6, 7}
        assert ranges.size == 682
    assert len(seen["grouped"]) == 228


def test_it_reads_a_stream_to_its_end(seen):
    assert [left for _, _, left in seen["stream"]] == [4, 3, 2, 1, 0]
    assert np.diff([time for time, _, _ in seen["stream"]]).tolist() == [200] * 4
    assert [values[0] for _, values, _ in seen["stream"]] == [103, 104, 105, 106, 107]
