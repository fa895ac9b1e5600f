"""Real conversations with an LMS200, and a host in virtual time."""

import numpy as np
from recordings import DATA

from laserfeatures.drivers.lms import pack_request
from laserfeatures.emulators import ScansFeed
from laserfeatures.emulators.lms import LmsDevice

SESSION = DATA / "serial/vectors/lms200_session.txt"
STEP = 0.001  # [s] of virtual time


def session():
    """Return the lines of the real session: time of day [s], "TX" or "RX", bytes."""
    lines = []
    for line in SESSION.read_text().splitlines():
        if line.startswith("#"):
            continue
        clock, direction, hexadecimal = line.split(" ", 2)
        hours, minutes, seconds = clock.replace(",", ".").split(":")
        time = int(hours) * 3600 + int(minutes) * 60 + float(seconds)
        lines.append((time, direction, bytes.fromhex(hexadecimal)))
    return lines


def wall(angles):
    """Return ranges of a round room of 3 m."""
    return np.full(angles.size, 3.0)


class Numbered:
    """A feed whose turns can be told apart: the first two ranges carry the turn's number."""

    def __init__(self):
        self.turns = 0

    def __call__(self, angles):
        ranges = np.full(angles.size, 3.0)
        ranges[:2] = 0.5 + self.turns % 1000 / 1000, 0.5 + self.turns // 1000 / 1000
        self.turns += 1
        return ranges


def turn_of(scan):
    """Return the number that `Numbered` put into a scan."""
    low, high = np.rint(scan.ranges[:2] * 1000).astype(int) - 500
    return int(low + 1000 * high)


class Host:
    """Talks to a device without any port, in virtual time."""

    def __init__(self, device):
        self.device, self.now = device, 0.0
        device.power_on(0.0)

    def listen(self, seconds):
        """Return what comes within some time."""
        heard = bytearray()
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            heard += self.device.take(self.now)
        return bytes(heard)

    def send(self, data):
        """Send bytes."""
        self.device.give(data, self.now)

    def ask(self, command, data=b"", seconds=1.0):
        """Return what comes within some time after a request."""
        self.send(pack_request(command, data))
        return self.listen(seconds)


def host(feed=wall, **parameters):
    """Return a host of a new device."""
    return Host(LmsDevice(feed, **parameters))


def playing(scans):
    """Return a feed of recorded scans."""
    return ScansFeed(lambda: scans)
