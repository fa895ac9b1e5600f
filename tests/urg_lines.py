"""A URG in virtual time, and the real session of a classic one."""

import ast
import itertools
from typing import NamedTuple

import numpy as np
from recordings import DATA

from laserfeatures.drivers import Losses
from laserfeatures.drivers.urg.decoder import UrgDecoder
from laserfeatures.emulators.urg import UrgDevice

SERIAL = DATA / "serial"
TICK = 0.001


class Piece(NamedTuple):
    """Bytes in a session."""

    time: float
    direction: str
    data: bytes


def real_session():
    """Return the pieces of the recorded session of a URG-04LX."""
    lines = (SERIAL / "vectors/urg04lx_classic_session.txt").read_text().splitlines()
    parts = [line.split(maxsplit=2) for line in lines if not line.startswith("#")]
    return [Piece(float(t), way, ast.literal_eval(data)) for t, way, data in parts]


def numbered():
    """Return a feed whose n-th turn sees everything at 100 + n mm, but nothing at 50 steps."""
    turns = itertools.count()

    def feed(angles):
        ranges = np.full(angles.size, (100 + next(turns)) / 1000)
        ranges[300:350] = np.nan
        return ranges

    return feed


def number_of(scan):
    """Return which turn of `numbered` a scan shows; all its beams must."""
    values = np.rint(scan.ranges[scan.valid] * 1000).astype(int) - 100
    assert np.ptp(values) == 0
    return int(values[0])


class Line:
    """A host that talks to a device in virtual time."""

    def __init__(self, device):
        self.device = device
        self.now = 0.0
        self.rate = None
        device.power_on(0.0)

    def send(self, command):
        """Send bytes now."""
        self.device.give(command, self.now, self.rate)

    def hear(self, seconds):
        """Return what comes in so much time."""
        out = b""
        for _ in range(round(seconds / TICK)):
            self.now += TICK
            out += self.device.take(self.now, self.rate)
        return out

    def ask(self, command, seconds=0.25):
        """Send a line and return what comes within so much time."""
        self.send(command + b"\n")
        return self.hear(seconds)


def line(**parameters):
    """Return a line to a new device."""
    return Line(UrgDevice(numbered(), **parameters))


def conversation(device, seconds, commands=(b"QT", b"PP", b"MD0044072501000")):
    """Return a session of (time, direction, bytes): commands, 0.2 s apart, then silence."""
    talk = Line(device)
    pieces = []
    for command in commands:
        pieces.append(Piece(talk.now, "TX", command + b"\n"))
        pieces.extend(_heard(talk, command + b"\n", 0.2))
    pieces.extend(_heard(talk, b"", seconds))
    return pieces


def _heard(talk, command, seconds):
    talk.send(command)
    for _ in range(round(seconds / TICK)):
        data = talk.hear(TICK)
        if data:
            yield Piece(talk.now, "RX", data)


def decoded(pieces):
    """Return what a new decoder makes of a session, and its losses."""
    decoder = UrgDecoder(Losses())
    found = []
    for piece in pieces:
        if piece.direction == "TX":
            decoder.sent(piece.data, piece.time)
        else:
            found += decoder.received(piece.data, piece.time)
    return found, decoder.losses
