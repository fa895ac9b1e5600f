"""The driver of RPLIDARs of the A and C series."""

import logging
import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeVar

from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.rplidar.decoder import RPLidarDecoder, Started
from laserfeatures.drivers.rplidar.motor import (
    FIRST_BY_PWM,
    FIRST_BY_SPEED,
    LARGEST_DUTY,
    Motor,
)
from laserfeatures.drivers.rplidar.packets import (
    STREAMS,
    Answer,
    BoardFlags,
    Command,
    Configuration,
    Health,
    Info,
    Key,
    SampleRate,
    Status,
    ask_configuration,
    request,
)
from laserfeatures.errors import DriverError, DriverTimeoutError

Asked = TypeVar("Asked")

RATES = (115_200, 256_000, 460_800, 1_000_000)
"""Baud rates of the A1 and A2M8; of A2M7, A2M12 and A3; of the C1; of the S2 and S3."""
ROUNDS = 2  # through the rates, at least
FIND = 2.0  # [s], at least: a device that starts is deaf for a second
ANSWERS_IN = 0.3  # [s]
QUIET = 0.05  # [s] without a byte: nothing is on its way any more
HUSH = 0.4  # [s] at most until a stream has stopped
BOOT = 4.0  # [s] at most from a reset to an answer
SPIN_UP = 2.5  # [s] at most until the motor turns and a scan is begun
TURNS_TO_WAIT = 3.0
LATE = 1000  # bytes that may wait in buffers
SLOWEST = 0.5  # [s]; a turn with a low duty
CONFIGURABLE = (1, 24)  # first firmware that can be asked for its modes

log = logging.getLogger("laserfeatures.drivers")


@dataclass(kw_only=True, eq=False)
class RPLidar(Driver):
    """A Slamtec RPLIDAR: A1, A2, A3, C1, and those that speak as they do.

    It turns clockwise in irregular steps; each scan is one turn, sorted counter-clockwise, 0 at the
    front. A turn lasts about 0.1 s: its `stamp` is the time of its first measurement, which is
    anywhere near the front, from its arrival less the time of transmission. No return is nan.

    Parameters
    ----------
    port, baud, reconnect, buffer, tap
        As of `Driver`. ``baud=None`` tries 115200, 256000, 460800 and 1000000 Bd.
    scan_mode : "auto", "standard" or "express"
        The device's typical mode; or 5-byte nodes, which tell the quality of an echo and have no
        checksum; or capsules of 32 measurements with a checksum, at twice the rate.
    motor : "auto", "dtr" or "pwm"
        How it is turned on: all ways that the device says it has; the line DTR of an A1's adapter
        alone; a request to the accessory board of an A2 or A3 alone.
    duty : int
        Duty of the pulse-width modulation, 0 .. 1023.
    coverage : float
        Least share of a turn that makes a scan. What is missing was lost on the way; a turn with
        less is dropped, and counted in ``losses.missed``.
    min_quality : int
        Echoes of less quality, 0 .. 63, are no returns; in a standard scan.

    Attributes
    ----------
    info : Info or None
        Which device it is, once it is open.

    Raises
    ------
    ValueError
        If a parameter makes no sense.
    """

    protocol: ClassVar[str] = "rplidar"
    usual_baud: ClassVar[int] = RATES[0]

    scan_mode: Literal["auto", "standard", "express"] = "auto"
    motor: Literal["auto", "dtr", "pwm"] = "auto"
    duty: int = 660
    coverage: float = 0.5
    min_quality: int = 1
    info: Info | None = field(init=False, default=None)
    _rate: int | None = field(init=False, default=None, repr=False)
    _motor: Motor | None = field(init=False, default=None, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        for name, choices in (
            ("scan_mode", ("auto", "standard", "express")),
            ("motor", ("auto", "dtr", "pwm")),
        ):
            if getattr(self, name) not in choices:
                wanted = ", ".join(choices)
                raise ValueError(f"{name} must be one of {wanted}, got {getattr(self, name)!r}")
        if not 0 < self.duty <= LARGEST_DUTY:
            raise ValueError(f"duty must be in 1 .. {LARGEST_DUTY}, got {self.duty}")
        if not 0 < self.coverage <= 1:
            raise ValueError(f"coverage must be in (0, 1], got {self.coverage}")
        if not 0 <= self.min_quality <= 63:
            raise ValueError(f"min_quality must be in 0 .. 63, got {self.min_quality}")

    def decoder(self) -> RPLidarDecoder:
        """Return a new decoder."""
        return RPLidarDecoder(self.losses, self.baud, self.coverage, self.min_quality)

    @property
    def patience(self) -> float:
        """Return the time of some turns and of transmission; before the first, of spinning up."""
        begin = SPIN_UP if math.isnan(self.arrival) else 0.0
        return begin + TURNS_TO_WAIT * SLOWEST + LATE * 10 / self.reader.port.baud

    def _start(self) -> None:
        self._motor = Motor(self.reader, self.duty)
        if self.motor != "pwm":
            self._motor.line_on()
        self.info = self._find()
        self._check_health()
        self._turn_on(self.info)
        rate = self._request(Command.SAMPLE_RATE, SampleRate, tries=2)
        if rate is None:
            log.info("%s: does not tell its sample rate: that of an A1 is assumed", self.port)
        for asked, kinds in self._scans(self.info):
            if self._started(asked, kinds):
                return
        raise DriverTimeoutError(
            f"{self.port}: the device answers, but begins no {self.scan_mode} scan within "
            f"{SPIN_UP:g} s: check that its motor turns and is powered, and try another motor= "
            "(auto, dtr, pwm) or scan_mode="
        )

    def _stop(self) -> None:
        self._hush()
        if self._motor is not None:
            self._motor.off()

    def _find(self) -> Info:
        """Find the baud rate at which a device answers, whatever it is doing."""
        known = self.baud or self._rate  # that of the last time: it is the same device, likely
        rates = (known,) if known else RATES
        end, tried = now() + FIND, 0
        while tried < ROUNDS * len(rates) or now() < end:
            rate = rates[tried % len(rates)]
            tried += 1
            self.reader.port.baud = rate
            self._hush()
            info = self._request(Command.INFO, Info, tries=1)
            if info is not None:
                self._rate = rate
                return info
        self._rate = None
        raise self._no_answer("an RPLIDAR that answers a5 50")

    def _hush(self) -> None:
        """Stop whatever runs, and wait until what was on its way has come."""
        end = now() + HUSH
        self.reader.write(request(Command.STOP))
        begin = now()
        while now() < end:
            time.sleep(QUIET / 5)
            quiet_since = max(self.reader.last_heard, begin)
            if now() - quiet_since > QUIET:
                return
        self.reader.write(request(Command.STOP))  # the first may have met a wrong rate

    def _check_health(self) -> None:
        """Reset a device that protects itself, once.

        Raises
        ------
        DriverError
            If that does not help.
        """
        health = self._request(Command.HEALTH, Health)
        if health is not None and health.status == Status.ERROR:
            self.losses.refusals += 1
            self.losses.problem = f"the device reports error {health.code:#06x}"
            log.warning("%s: %s: resetting it", self.port, self.losses.problem)
            self.reader.write(request(Command.RESET))
            health = self._health_after_reset()
        if health is None:
            raise self._no_answer("an RPLIDAR that tells its health")
        if health.status == Status.ERROR:
            raise DriverError(
                f"{self.port}: the device protects itself because of error {health.code:#06x}, "
                "also after a reset: check its power supply and that its motor turns freely"
            )
        if health.status:
            self.losses.problem = f"the device warns with code {health.code:#06x}"
            log.warning("%s: %s", self.port, self.losses.problem)

    def _health_after_reset(self) -> Health | None:
        end = now() + BOOT
        while now() < end:
            time.sleep(QUIET)
            health = self._request(Command.HEALTH, Health, tries=1)
            if health is not None:
                return health
        return None

    def _turn_on(self, info: Info) -> None:
        """Turn the motor on."""
        if self._motor is None or self.motor == "dtr":
            return
        if self.motor == "pwm":
            self._motor.on(Command.MOTOR_PWM)
        elif info.series >= FIRST_BY_SPEED:
            self._motor.on(Command.MOTOR_SPEED)
        elif info.series >= FIRST_BY_PWM:
            flags = self._request(Command.BOARD_FLAGS, BoardFlags, payload=bytes(4), tries=2)
            if flags is not None and flags.pwm:
                self._motor.on(Command.MOTOR_PWM)

    def _scans(self, info: Info) -> Iterator[tuple[bytes, set[Answer]]]:
        """Yield the scans to try, in order: request, and how it may be answered."""
        if self.scan_mode == "auto" and (mode := self._typical_mode(info)) is not None:
            kinds = self._ask_mode(info, mode) - {Answer.NODES}
            if kinds:
                yield request(Command.EXPRESS_SCAN, bytes((mode, 0, 0, 0, 0))), kinds
        elif self.scan_mode != "standard":
            yield request(Command.EXPRESS_SCAN, bytes(5)), {Answer.CAPSULES}
        if self.scan_mode != "express":
            self._ask_mode(info, 0)
            yield request(Command.SCAN), {Answer.NODES}

    def _typical_mode(self, info: Info) -> int | None:
        if info.firmware < CONFIGURABLE:
            return None
        value = self._configuration(Key.TYPICAL_MODE)
        return value[0] if value else None

    def _ask_mode(self, info: Info, mode: int) -> set[Answer]:
        """Let the decoder hear what a mode is; return how it will be answered, if that is known."""
        if info.firmware < CONFIGURABLE:
            return set()
        kind = self._configuration(Key.ANSWER_TYPE, mode)
        self._configuration(Key.SAMPLE_TIME, mode)
        self._configuration(Key.MAX_DISTANCE, mode)
        return {known for known in STREAMS if kind and known == kind[0]}

    def _configuration(self, key: Key, mode: int | None = None) -> bytes | None:
        def match(reply: object) -> bytes | None:
            fits = isinstance(reply, Configuration) and reply.key == key
            return reply.value if fits else None  # type: ignore[attr-defined]

        return self._ask(ask_configuration(key, mode), match, ANSWERS_IN, tries=2)

    def _request(
        self, command: Command, kind: type[Asked], *, payload: bytes = b"", tries: int = 3
    ) -> Asked | None:
        def match(reply: object) -> Asked | None:
            return reply if isinstance(reply, kind) else None

        return self._ask(request(command, payload), match, ANSWERS_IN, tries=tries)

    def _started(self, asked: bytes, kinds: set[Answer]) -> bool:
        def match(reply: object) -> bool | None:
            return (isinstance(reply, Started) and reply.kind in kinds) or None

        return bool(self._ask(asked, match, ANSWERS_IN, tries=round(SPIN_UP / ANSWERS_IN)))
