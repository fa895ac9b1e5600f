"""Saying what answers on a port."""

import random

import pytest
from recordings import DATA, needs_recordings

from laserfeatures.drivers.identify import identify

LD19 = bytes.fromhex("54 2C 68 08") + bytes(43)


@pytest.mark.parametrize(
    ("heard", "name"),
    [
        (b"\xa5\x5a\x14\x00\x00\x00\x04" + bytes(20), "an RPLIDAR"),
        (bytes(7) + LD19 + LD19, "an LD06 or LD19"),
        (b"VV\n00P\nVEND:Hokuyo Automatic Co.,Ltd.;[\n", "a Hokuyo that speaks SCIP"),
        (b"QT\n00P\n\n", "a Hokuyo that speaks SCIP"),
        (bytes.fromhex("06 02 80 03 00 a0 00 10 16 0a"), "a SICK LMS2xx"),
        (b"$GPGGA,123519,4807.038,N,01131.000,E*47\r\n", "a GPS receiver"),
        (b"login: ", "another device, which sends the text b'login: '"),
        (random.Random(1).randbytes(200), "bytes of no protocol known here"),  # noqa: S311 - no secret
    ],
)
def test_it_is_named(heard, name):
    assert identify(heard).startswith(name)


@needs_recordings
@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("scip2_GD_A.bin", "a Hokuyo that speaks SCIP"),
        ("scip2_VV_urg04lx_ug01.bin", "a Hokuyo that speaks SCIP"),
        ("lms200_scan361_usick.bin", "a SICK LMS2xx"),
    ],
)
def test_real_devices_are_named(file, name):
    assert identify((DATA / "serial" / file).read_bytes()).startswith(name)
