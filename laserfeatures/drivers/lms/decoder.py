"""From the bytes on the line of an LMS2xx to scans and replies."""

import logging
from collections.abc import Iterator
from contextlib import suppress

from laserfeatures.drivers.decoder import Halt, Sweep
from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.configuration import Configuration, parse_written
from laserfeatures.drivers.lms.framing import Framer
from laserfeatures.drivers.lms.measurements import (
    DEGREES,
    MIRROR_TURN,
    PREFIX,
    Measurement,
    beam_angles,
    check_variant,
    parse_measurement,
    turns,
)
from laserfeatures.drivers.lms.ranges import range_limit, to_ranges
from laserfeatures.drivers.lms.status import POLLUTION, describe, parse_status
from laserfeatures.drivers.lms.telegrams import FROM_SCANNER, Telegram, parse_request
from laserfeatures.drivers.losses import Losses
from laserfeatures.errors import ProtocolError
from laserfeatures.scan import LaserScan

log = logging.getLogger("laserfeatures.drivers")

RESTARTED = "the scanner has restarted"


class LmsDecoder:
    """Decodes a conversation with an LMS2xx.

    It learns from the replies how the values are to be read. Values are scans only after a request
    for them, so that what an earlier host has left streaming is never read the wrong way.

    The scanner has no clock. A scan's stamp is the time at which its telegram began to arrive, less
    the time of the scan itself, 13.32 ms for each turn of the mirror: the first ray may be up to a
    further scan older. Rays of a scan with 0.5 degrees come from two turns, with 0.25 from four.

    Parameters
    ----------
    losses : Losses
        Where it counts.
    live : bool
        Whether values are scans from the first byte on: for bytes without a host's requests.
    measuring_mode : int
        How values are read until the scanner has said it.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, p. 19, 47-50.
    """

    def __init__(self, losses: Losses, *, live: bool = False, measuring_mode: int = 0) -> None:
        self.losses = losses
        self._at_first = live, measuring_mode
        self.reset()

    def reset(self) -> None:
        """Forget what is half received and what is known of the scanner."""
        self._live, self._measuring_mode = self._at_first
        self._framer = Framer()
        self._variant: tuple[int, int] | None = None
        self._mode_asked: int | None = None
        self._last_index: int | None = None
        self._polluted = False

    def sent(self, data: bytes, time: float) -> None:  # noqa: ARG002 - the order says enough
        """Take note of a request."""
        self._framer.asked = True
        try:
            command, rest = parse_request(data)
        except ProtocolError:  # a recording that was cut in a request
            return
        if command == requests.MODE and rest:
            self._mode_asked = rest[0]
            self._live &= rest[0] in requests.BAUDS.values()
        elif command in {requests.VALUES, requests.MEAN, requests.SUB_RANGE}:
            self._live = True
        elif command in {requests.RESET, requests.VARIANT}:
            self._live = False

    def received(self, data: bytes, time: float) -> list[object]:
        """Take bytes of the scanner.

        Returns
        -------
        list
            `Sweep`, `Halt`, and the replies: `Answer` and `Telegram`.
        """
        framer, was_live = self._framer, self._live
        framer.damaged = framer.garbage = 0
        messages: list[object] = []
        for message, arrival in framer.take(data, time):
            if isinstance(message, Telegram):
                messages += self._read(message, arrival)
            else:
                messages.append(message)
        if was_live:  # else a rate is being looked for, or nothing is due
            self.losses.damaged += framer.damaged
            self.losses.garbage += framer.garbage
            if framer.damaged:
                self.losses.problem = "a telegram with a wrong checksum"
        return messages

    def _read(self, telegram: Telegram, arrival: float) -> Iterator[object]:
        if telegram.command in PREFIX:
            if self._live:
                with suppress(ProtocolError):
                    self._note(telegram.status)
                    yield self._sweep(telegram, arrival)
                    return
                self.losses.damaged += 1
                self.losses.problem = "values that cannot be read"
        elif telegram.command == requests.POWERED_ON and self._live:
            self._live = False
            yield Halt(RESTARTED)
        else:
            with suppress(ProtocolError):
                self._learn(telegram)
            yield telegram

    def _learn(self, telegram: Telegram) -> None:
        command, data = telegram.command - FROM_SCANNER, telegram.data
        if command == requests.MODE and data == b"\0" and self._mode_asked in requests.STREAMS:
            self._live, self._last_index = True, None
        elif command == requests.STATUS:
            status = parse_status(data)
            self._measuring_mode = status.measuring_mode
            self._variant = check_variant(status.angle, status.resolution)
        elif command == requests.READ_CONFIGURATION:
            self._measuring_mode = Configuration(data).measuring_mode
        elif command == requests.WRITE_CONFIGURATION:
            self._measuring_mode = parse_written(data)[1].measuring_mode
        elif command == requests.VARIANT and len(data) == 5:
            angle, resolution = (int.from_bytes(data[i : i + 2], "little") for i in (1, 3))
            self._variant = check_variant(angle, resolution)

    def _sweep(self, telegram: Telegram, arrival: float) -> Sweep:
        values = parse_measurement(telegram)
        scan = LaserScan(
            angles=beam_angles(
                values.words.size,
                partial=values.partial,
                first=values.first,
                variant=self._variant,
            ),
            ranges=to_ranges(values.words, self._measuring_mode, values.unit),
            range_max=range_limit(self._measuring_mode, values.unit),
            stamp=arrival - self._duration(values),
        )
        self.losses.frames += 1
        self._count_missed(values)
        return Sweep(scan, arrival)

    def _duration(self, values: Measurement) -> float:
        """Return how long the scanner has measured for a telegram [s]."""
        if values.partial is not None:
            return MIRROR_TURN
        field, resolution = self._variant or DEGREES.get(values.words.size, (180, 50))
        return MIRROR_TURN * turns(resolution, field) * max(values.mean, 1)

    def _count_missed(self, values: Measurement) -> None:
        if values.indices is None:
            return
        last, self._last_index = self._last_index, values.indices[1]
        if last is not None:
            self.losses.missed += (self._last_index - last - 1) % 256

    def _note(self, status: int) -> None:
        fault = describe(status)
        if fault:
            self.losses.refusals += 1
            self.losses.problem = f"the scanner reports: {fault} (status {status:02X})"
        if status & POLLUTION and not self._polluted:
            log.warning("the scanner reports that its front window is dirty: clean it")
        self._polluted = bool(status & POLLUTION)
