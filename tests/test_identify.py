"""Saying what answers on a port."""

import random
from types import SimpleNamespace

import pytest
from recordings import DATA, needs_recordings

from laserfeatures.drivers import identify as identify_module
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
        (b"\x02sAN DeviceIdent 7 TiM551\x03", "a SICK that speaks SOPAS"),
        (b"\x02sFA 3\x03", "a SICK that speaks SOPAS"),
        (bytes.fromhex("02020202 00000005") + b"sFA\x00\x03\x1b", "a SICK that speaks SOPAS"),
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


class Line:
    """A port at which a device answers a question in its own words, at one rate."""

    def __init__(self, baud, question, answer):
        self.port = SimpleNamespace(baud=0)
        self.heard = bytearray()
        self._expected, self._answer = (baud, question), answer

    def write(self, question):
        if (self.port.baud, question) == self._expected:
            self.heard += self._answer


@pytest.mark.parametrize(
    ("answer", "name"),
    [
        (b"\x02sFA 3\x03", "a SICK that speaks SOPAS"),
        (b"what?\r\n", "another device, which sends the text b'what?"),
        (b"", None),
    ],
)
def test_what_answers_but_is_not_known_is_not_silent(answer, name, monkeypatch):
    monkeypatch.setattr(identify_module, "ANSWER_TIME", 0.0)
    found = identify_module.ask_around(Line(115_200, b"VV\n", answer))
    assert found is None if name is None else found.startswith(name)
