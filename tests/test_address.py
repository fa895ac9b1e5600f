"""Addresses of ports."""

import pytest

from laserfeatures import DriverError
from laserfeatures.drivers import is_address, make_driver, settings_of
from laserfeatures.drivers.ld19 import Ld19


@pytest.mark.parametrize(
    ("address", "port"),
    [
        ("ld19:///dev/ttyUSB0", "/dev/ttyUSB0"),
        ("ld19:/dev/ttyUSB0", "/dev/ttyUSB0"),
        ("ld19:socket://10.0.0.1:4001", "socket://10.0.0.1:4001"),
        ("ld19:loop://", "loop://"),
        ("ld19:///dev/serial/by-id/usb-1?baud=921600", "/dev/serial/by-id/usb-1"),
    ],
)
def test_the_port_is_read(address, port):
    assert is_address(address)
    driver = make_driver(address)
    assert isinstance(driver, Ld19)
    assert driver.port == port


@pytest.mark.parametrize("text", ["run.log", "ld19", "ld19:", "/dev/ttyUSB0", "http://x", "c:/a"])
def test_other_texts_are_no_addresses(text):
    assert not is_address(text)


def test_parameters_have_their_types():
    driver = make_driver("ld19:///dev/x?baud=921600&range_max=8.5&reconnect=yes&buffer=3")
    assert settings_of(driver) == {
        "baud": 921_600,
        "reconnect": True,
        "buffer": 3,
        "range_max": 8.5,
        "min_intensity": 0,
    }
    assert settings_of(make_driver("ld19:///dev/x?reconnect=0"))["reconnect"] is False


@pytest.mark.parametrize(
    ("address", "message"),
    [
        ("ld91:///dev/x", "there is no driver 'ld91'.*ld19"),
        ("ld19:///", "expected a port after ld19:, as in ld19:///dev/ttyUSB0"),
        ("ld19:///dev/x?range=8", "there is no parameter 'range'.*range_max"),
        ("ld19:///dev/x?tap=1", "there is no parameter 'tap'"),
        ("ld19:///dev/x?port=1", "there is no parameter 'port'"),
        ("ld19:///dev/x?baud=fast", "baud cannot be 'fast': expected a whole number"),
        ("ld19:///dev/x?range_max=far", "range_max cannot be 'far': expected a number"),
        ("ld19:///dev/x?reconnect=maybe", "reconnect cannot be 'maybe': expected 0 or 1"),
    ],
)
def test_mistakes_are_named(address, message):
    with pytest.raises(DriverError, match=message):
        make_driver(address)
