"""The driver of SICK LMS200, 211, 220, 221 and 291."""

import math
import time
from contextlib import suppress
from dataclasses import dataclass, field
from typing import ClassVar, Literal

from laserfeatures.drivers.lms import requests
from laserfeatures.drivers.lms.decoder import LmsDecoder
from laserfeatures.drivers.lms.dialog import AFTER_REFUSAL, BITS, REPLY, TRIES
from laserfeatures.drivers.lms.measurements import MIRROR_TURN, turns, values_of
from laserfeatures.drivers.lms.setup import LmsSetup
from laserfeatures.drivers.lms.telegrams import ENVELOPE, Answer, pack_request
from laserfeatures.errors import DriverError
from laserfeatures.scan import LaserScan

RESET_TIME = 0.1  # [s] from the reply to the reset itself, and some
SCANS_WAITED = 4  # for one to come
LEAST_PATIENCE = 1.0  # [s]
RESOLUTIONS = (1.0, 0.5, 0.25)
MOST_IN_MEAN = 250


@dataclass(kw_only=True, eq=False)
class Lms(LmsSetup):
    """A SICK LMS200, LMS211, LMS220, LMS221 or LMS291 on RS-232 or RS-422.

    Opening finds the rate of the line and stops whatever an earlier host has left running; leaving
    puts the rate back to what was found. The configuration, which the scanner keeps in an EEPROM of
    limited life, is read first and only written if a parameter asks for something else; it stays.

    Parameters
    ----------
    port, reconnect, buffer, tap
        As in `Driver`.
    baud : int or None
        Rate of the line while the driver is open [Bd]: 9600, 19200, 38400, or 500000 (RS-422 only).
        None: 38400, or what the scanner has if that is more. At 38400 Bd a scan of 0.5 degrees
        comes every 213 ms; only 500000 Bd carries all.
    angle : int or None
        Field of view [degrees]: 100 or 180; None: as the scanner is set.
    resolution : float or None
        Step from beam to beam [degrees]: 1.0, 0.5 or 0.25, which goes with 100 degrees only; None:
        as the scanner is set.
    unit : str or None
        Of the values on the line: "mm" or "cm"; None: as the scanner is set.
    reach : int or None
        How far values in millimetres go [m]: 8, 16 or 32; in centimetres ten times as far, as the
        optics allow (80 m). The fewer metres, the more flags of fields come along, which are not
        read. None: as the scanner is set.
    mode : str
        "continuous": every scan that the line carries; "on_request": one for each iteration;
        "interlaced": each turn of the mirror by itself, a scan with a step of 1 degree that is
        shifted by 0.25, 0.5 or 0.75 degrees from turn to turn.
    mean : int
        How many scans are averaged by the scanner, 1..250.
    first, last : int or None
        First and last value wanted of each scan, from 1; None: all.
    indices : bool or None
        Whether the scanner sends two counters along, which show lost scans (`losses.missed`); None:
        as the scanner is set.
    power_on_timeout : float
        How long to wait at opening for a scanner that was just switched on [s]: it needs up to 60.
        One that restarts while the driver is open is always waited for.

    Attributes
    ----------
    device_type : str
        As the scanner names itself, such as ``"LMS200;S18063;V02.19"``.
    status : Status or None
        What it said of itself at opening.

    Raises
    ------
    ValueError
        If a parameter makes no sense.

    References
    ----------
    SICK, Telegram Listing LMS2xx, 8007954/Q501, 2006.
    """

    protocol: ClassVar[str] = "lms"
    usual_baud: ClassVar[int] = 38400

    mode: Literal["continuous", "on_request", "interlaced"] = "continuous"
    mean: int = 1
    first: int | None = None
    last: int | None = None
    _wanted: bool = field(init=False, default=False, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        for name, choices in {
            "baud": tuple(requests.BAUDS),
            "angle": (100, 180),
            "resolution": RESOLUTIONS,
            "unit": ("mm", "cm"),
            "reach": (8, 16, 32),
        }.items():
            value = getattr(self, name)
            if value is not None and value not in choices:
                raise ValueError(f"{name} must be one of {choices} or None, got {value!r}")
        if self.mode not in {"continuous", "on_request", "interlaced"}:
            raise ValueError(
                f"mode must be 'continuous', 'on_request' or 'interlaced', got {self.mode!r}"
            )
        if self.angle == 180 and self.resolution == 0.25:
            raise ValueError("resolution 0.25 goes with angle 100 only, got angle 180")
        if not 1 <= self.mean <= MOST_IN_MEAN:
            raise ValueError(f"mean must be in 1..{MOST_IN_MEAN}, got {self.mean}")
        if not 0 <= self.power_on_timeout < math.inf:
            raise ValueError(f"power_on_timeout must be >= 0 s, got {self.power_on_timeout}")
        self._check_part()

    def _check_part(self) -> None:
        if (self.first is None) != (self.last is None):
            raise ValueError("first and last go together: give both or none")
        if self.first is not None and not 1 <= self.first <= (self.last or 0) <= 401:
            raise ValueError(
                f"first and last must be 1 <= first <= last <= 401, got {self.first}, {self.last}"
            )
        special = (self.mean > 1) + (self.first is not None)
        if special and self.mode == "interlaced":
            raise ValueError("mean, first and last do not go with mode 'interlaced'")
        if special == 2 and self.mode == "on_request":
            raise ValueError("mean does not go with first and last in mode 'on_request'")

    def decoder(self) -> LmsDecoder:
        """Return a decoder that counts in `losses`."""
        return LmsDecoder(self.losses)

    def open(self) -> None:
        """Find the scanner at any of its rates, whatever it is doing, and start the scans."""
        self._baud_before, self._known = None, False
        super().open()

    def __next__(self) -> LaserScan:
        """Wait for the next scan; ask for it first in mode "on_request"."""
        self._wanted = True
        try:
            if self._reader is not None:
                with suppress(DriverError):  # the wait for the scan tells what is wrong
                    self._demand()
            return super().__next__()
        finally:
            self._wanted = False

    @property
    def patience(self) -> float:
        """How long the next scan may take [s]: some periods of the stream at this rate."""
        return max(SCANS_WAITED * self.period, LEAST_PATIENCE)

    @property
    def period(self) -> float:
        """Time from scan to scan [s]: the line carries only whole scans, and drops the others."""
        field_of_view, resolution = self._variant()
        count = values_of(field_of_view, resolution)
        turns_ = turns(resolution, field_of_view)
        if self.mode == "interlaced":
            count, turns_ = values_of(field_of_view, 100), 1
        if self.first is not None and self.last is not None:
            count = self.last - self.first + 1
        scan_time = MIRROR_TURN * turns_ * self.mean
        baud = (self.status and self.status.baud) or self.baud or self.usual_baud
        sending = (ENVELOPE + 6 + 2 * count) * BITS / baud
        return math.ceil(sending / scan_time) * scan_time

    def restart(self) -> None:
        """Reset the scanner, as if switched off and on, and go on when it is up again.

        Raises
        ------
        DriverError
            If it does not come back.
        """
        self._is_stopped()
        for _ in range(TRIES):
            if self._try(pack_request(requests.RESET), self._answer_time, REPLY):
                break
        time.sleep(RESET_TIME)
        self._start()

    def _start(self) -> None:
        self._find()
        self._change_baud(self.baud or max(self.usual_baud, self.reader.port.baud))
        self._identify()
        self._configure()
        self._look_after()
        self._set_variant()
        if self.mode == "on_request":
            if self._wanted:
                self._demand()
            return
        partial = requests.operating_mode(requests.STREAM_PARTIAL)
        stream = requests.stream(mean=self.mean, first=self.first, last=self.last)
        self._set_mode(partial if self.mode == "interlaced" else stream, "the stream")

    def _stop(self) -> None:
        if self._baud_before is None:
            return  # it was never found
        if self._is_stopped():
            self._switch_baud(self._baud_before)

    def _demand(self) -> None:
        """Ask for one scan, if that is the mode."""
        if self.mode != "on_request":
            return
        request = requests.one_scan(mean=self.mean, first=self.first, last=self.last)

        def match(message: object) -> Answer | None:
            return message if isinstance(message, Answer) else None

        for _ in range(TRIES):
            answer = self._ask(request, match, self._answer_time, tries=1, gap=self._gap)
            if answer is not None and answer.good:
                return
            if answer is not None:
                time.sleep(AFTER_REFUSAL)
