"""An RPLIDAR and a decoder that talk in virtual time, without a port."""

from itertools import pairwise

from laserfeatures.drivers import Sweep
from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.decoder import RPLidarDecoder
from laserfeatures.drivers.rplidar.packets import Command, Key, ask_configuration, request
from laserfeatures.emulators.rplidar import RPLidarDevice

ASK = [request(Command.INFO), request(Command.SAMPLE_RATE)]
SCANS = {
    "standard": request(Command.SCAN),
    "express": request(Command.EXPRESS_SCAN, bytes(5)),
    "boost": request(Command.EXPRESS_SCAN, bytes((2, 0, 0, 0, 0))),
}
PERIOD = {"standard": [], "express": [], "boost": [ask_configuration(Key.SAMPLE_TIME, 2)]}
STEP = 0.002  # [s]
ANSWERS = 0.04  # [s]
PATIENCE = 1.0  # [s] without a scan; then the scan is asked for again
SOON = 0.04  # [s]; a stamp is not further from the first frame of its turn


class Watched(RPLidarDevice):
    """A device that remembers what became of its frames."""

    def __init__(self, *args, **parameters):
        super().__init__(*args, **parameters)
        self.said = []  # time, turn, fault

    def say(self, frame, at, turn=None):
        super().say(frame, at, turn)
        if turn is not None:
            self.said.append((at, turn, self.frames[-1][1]))

    def clean_turns(self, around):
        """Return when each turn begins that no fault touches, and none `around` seconds off."""
        begins = {turn: at for at, turn, _ in reversed(self.said)}
        faults = [(at, fault) for at, _, fault in self.said if fault not in {None, "garbage"}]
        turns = sorted(begins)
        return [
            begins[turn]
            for turn, after in pairwise(turns[1:-1])
            if turn - 1 in begins
            and not any(
                begins[turn] - 0.05 - around[fault] < at < begins[after] + 0.05
                for at, fault in faults
            )
        ]


def decoder_for(coverage=0.8, min_quality=1, baud=None):
    return RPLidarDecoder(Losses(), baud, coverage, min_quality)


def talk(device, requests, seconds, decoder=None):
    """Let a decoder listen to requests and what a device answers; return what it makes of it."""
    decoder = decoder or decoder_for()
    device.power_on(0.0)
    heard, time, last = [], 0.0, 0.0
    todo = list(requests)
    asked = -1.0
    while time < seconds:
        if todo and time - asked >= ANSWERS:
            asked = last = time
            wanted = todo.pop(0)
            decoder.sent(wanted, time)
            device.give(wanted, time)
        time += STEP
        new = decoder.received(device.take(time), time)
        heard += new
        last = time if new else last
        if not todo and time - last > PATIENCE:
            todo = [request(Command.STOP), requests[-1]]
    return heard, decoder


def scans_of(heard):
    return [event.scan for event in heard if isinstance(event, Sweep)]
