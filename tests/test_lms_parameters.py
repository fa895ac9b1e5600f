"""The parameters of the driver of the LMS2xx."""

import pytest

from laserfeatures.drivers import make_driver
from laserfeatures.drivers.lms import Lms
from laserfeatures.errors import DriverError


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"baud": 115200}, "baud must be one of"),
        ({"angle": 90}, "angle must be one of"),
        ({"resolution": 0.3}, "resolution must be one of"),
        ({"angle": 180, "resolution": 0.25}, "goes with angle 100 only"),
        ({"unit": "m"}, "unit must be one of"),
        ({"reach": 80}, "reach must be one of"),
        ({"mode": "fast"}, "mode must be"),
        ({"mean": 0}, "mean must be in 1..250, got 0"),
        ({"first": 3}, "give both or none"),
        ({"first": 5, "last": 4}, "first <= last"),
        ({"mode": "interlaced", "mean": 2}, "do not go with"),
        ({"mode": "on_request", "mean": 2, "first": 1, "last": 2}, "mean does not go"),
        ({"power_on_timeout": -1.0}, "power_on_timeout must be >= 0"),
    ],
)
def test_parameters_that_make_no_sense(parameters, message):
    with pytest.raises(ValueError, match=message):
        Lms(port="/dev/null", **parameters)


def test_an_address_sets_the_parameters():
    driver = make_driver(
        "lms:///dev/ttyUSB0?baud=500000&angle=100&resolution=0.25&unit=mm&reach=32&mode=on_request"
        "&first=1&last=9&power_on_timeout=60&indices=1&reconnect=1"
    )
    assert (driver.baud, driver.angle, driver.resolution) == (500_000, 100, 0.25)
    assert (driver.unit, driver.reach, driver.mode) == ("mm", 32, "on_request")
    assert (driver.first, driver.last, driver.indices) == (1, 9, True)
    assert (driver.power_on_timeout, driver.reconnect) == (60.0, True)
    with pytest.raises(DriverError, match="angle cannot be '90': expected 100 or 180"):
        make_driver("lms:///dev/ttyUSB0?angle=90")
