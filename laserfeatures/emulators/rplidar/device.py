"""An RPLIDAR as a state machine.

References
----------
Slamtec, "RPLIDAR interface protocol and application notes"; what the vendor's library and the
common clients expect of it.
"""

import math
from collections.abc import Collection
from random import Random
from typing import ClassVar

from laserfeatures.drivers.rplidar.packets import (
    LENGTHS,
    U16,
    U32,
    Answer,
    BoardFlags,
    Command,
    Configuration,
    Health,
    Info,
    Key,
    Reply,
    SampleRate,
    Status,
    build_reply,
    descriptor,
    next_request,
)
from laserfeatures.emulators.device import Device
from laserfeatures.emulators.faults import Faults
from laserfeatures.emulators.feed import Feed
from laserfeatures.emulators.rplidar.models import MODELS, Mode
from laserfeatures.emulators.rplidar.sampling import Sampler
from laserfeatures.emulators.rplidar.streams import Stream, with_bad_checksum, with_jump
from laserfeatures.registry import near_names

START_STATES = ("idle", "streaming", "express", "protection", "booting")
TROUBLES = ("bad_checksum", "angle_jump", "old_firmware", "warning", "broken")
FIRMWARE, OLD_FIRMWARE = (1, 29), (1, 20)
SERIAL = "64E699F3C7E59AF0A2E69DF8F13735D0"
BANNER = "RP LIDAR System.\r\nFirmware Ver {}.{}, HW Ver {}\r\nModel: {:02X}\r\n"
BOOT = 0.5  # [s] without hearing, then the banner
ANSWER_AFTER = 0.001  # [s]
FIRST_SAMPLE = 0.004  # [s] after the request
LATE = 0.3  # [s]; later than that a frame is left out
ERROR_CODE, WARNING_CODE = 0x8002, 0x0011
USUAL_RPM, USUAL_DUTY = 600, 660
LEAST_RPM, LARGEST_RPM = 200, 1200


class RPLidarDevice(Device):
    """An emulated RPLIDAR.

    The motor of an A1 hangs on the line DTR, which a pseudo-terminal has not: it always turns.
    That of an A2 or A3 stands until a request sets its duty, and until then a scan is refused
    without a word.

    Parameters
    ----------
    feed, faults
        As of `Device`; a frame is a capsule, or eight nodes.
    model : str
        One of `MODELS`.
    start : str
        "idle"; "streaming" nodes or "express" capsules, left so by a host that crashed, from the
        middle of a frame on; "protection": health 2, refuses to scan until it is reset; "booting":
        deaf for half a second, then prints its banner.
    turn_rate : float, optional
        Turns per second; by default the model's.
    troubles : collection of str
        "bad_checksum", "angle_jump": capsules that are wrong, at `trouble_rate`; "old_firmware":
        knows no configuration request; "warning": health 1; "broken": health 2 also after a reset.
    trouble_rate : float
        Probability that a capsule has each of the chosen troubles.
    seed : int
        Seed of irregularities and troubles.

    Raises
    ------
    ValueError
        If there is no such model, start state or trouble.
    """

    name: ClassVar[str] = "RPLIDAR"

    def __init__(
        self,
        feed: Feed,
        faults: Faults | None = None,
        *,
        model: str = "A1",
        start: str = "idle",
        turn_rate: float | None = None,
        troubles: Collection[str] = (),
        trouble_rate: float = 0.02,
        seed: int = 0,
    ) -> None:
        super().__init__(feed, faults)
        for value, known, what in [(model, MODELS, "model"), (start, START_STATES, "start state")]:
            if value not in known:
                raise ValueError(f"there is no {what} {value!r}; {near_names(value, known)}")
        for trouble in troubles:
            if trouble not in TROUBLES:
                raise ValueError(
                    f"there is no trouble {trouble!r}; {near_names(trouble, TROUBLES)}"
                )
        self.model = MODELS[model]
        self.baud = self.model.baud
        self.firmware = OLD_FIRMWARE if "old_firmware" in troubles else FIRMWARE
        self._turn_time = 1 / (turn_rate or self.model.turn_rate)
        self._troubles, self._trouble_rate = set(troubles), trouble_rate
        self._start: str | None = start
        self._random = Random(seed)  # noqa: S311 - for tests, not for secrets
        self._seed = seed
        self._turn = 0
        self._host = b""
        self._stream: Stream | None = None
        self._ready_at: float | None = None
        self.motor_on = not self.model.pwm
        self.health = Health(Status.GOOD, 0)

    def power_on(self, now: float) -> None:
        """Begin in the start state, and later as after power-on: with the banner."""
        start, self._start = self._start, None
        self.motor_on = not self.model.pwm
        if start in {None, "booting"}:
            self._boot(now)
            return
        self.health = self._healthy()
        if start == "protection":
            self.health = Health(Status.ERROR, ERROR_CODE)
        elif start in {"streaming", "express"}:
            self.motor_on = True
            self._measure(self.model.modes[start == "express"], now)
            if self._stream is not None:  # the host hears it from the middle of a frame on
                frame = self._stream.next_frame().data
                super().say(frame[len(frame) // 2 + 1 :], now)

    def hear(self, data: bytes, now: float) -> None:
        """Take bytes of the host; deaf while it starts."""
        if self._ready_at is not None and now < self._ready_at:
            return
        self._host += data
        while (found := next_request(self._host)) is not None:
            command, payload, end = found
            self._host = self._host[end:]
            if payload is not None:
                self._obey(command, payload, now)

    def advance(self, now: float) -> None:
        """Finish starting, and send the measurements that are due."""
        if self._ready_at is not None and now >= self._ready_at:
            text = BANNER.format(*self.firmware, self.model.hardware, self.model.code)
            self.say(text.encode(), self._ready_at)
            self._ready_at = None
        while self._stream is not None and self._stream.due <= now:
            frame = self._stream.next_frame()
            self._turn = frame.turn
            if now - frame.at < LATE:
                self.say(self._troubled(frame.data), frame.at, frame.turn)

    def next_event(self) -> float:
        """Return when something is due."""
        if self._ready_at is not None:
            return self._ready_at
        return math.inf if self._stream is None else self._stream.due

    def _obey(self, command: int, payload: bytes, now: float) -> None:
        """Do what a request asks; what is not known is ignored."""
        if command == Command.MOTOR_PWM and self.model.pwm and len(payload) == U16.size:
            self.motor_on = U16.unpack(payload)[0] > 0
            self._stream = self._stream if self.motor_on else None
        elif command == Command.STOP:
            self._stop()
        elif command == Command.RESET:
            self._boot(now)
        elif command in {Command.SCAN, Command.FORCE_SCAN}:
            self._scan(self.model.modes[0], now)
        elif command == Command.EXPRESS_SCAN and len(payload) == 5:
            if payload[0] < len(self.model.modes):
                self._scan(self.model.modes[payload[0] or 1], now)
        elif (reply := self._reply(command, payload)) is not None:
            self._stop()  # any request ends a scan
            self.say(build_reply(reply), now + ANSWER_AFTER)

    def _reply(self, command: int, payload: bytes) -> Reply | None:
        modes = self.model.modes
        if command == Command.INFO:
            return Info(self.model.code, self.firmware, self.model.hardware, SERIAL)
        if command == Command.HEALTH:
            return self.health
        if command == Command.SAMPLE_RATE:
            return SampleRate(modes[0].period, modes[1].period)
        if command == Command.BOARD_FLAGS and self.model.code >> 4 > 1:
            return BoardFlags(self.model.pwm)
        known = self.firmware > OLD_FIRMWARE
        if command == Command.CONFIGURATION and known and len(payload) >= U32.size:
            key = U32.unpack_from(payload)[0]
            mode = U16.unpack_from(payload + bytes(2), U32.size)[0]
            return Configuration(key, self._configured(key, mode))
        return None

    def _configured(self, key: int, mode: int) -> bytes:
        """Return the value of a configuration key; of one that it does not know, nothing."""
        modes = self.model.modes
        plain: dict[int, bytes] = {
            Key.DESIRED_SPEED: U16.pack(USUAL_RPM) + U16.pack(USUAL_DUTY),
            Key.LEAST_SPEED: U16.pack(LEAST_RPM),
            Key.LARGEST_SPEED: U16.pack(LARGEST_RPM),
            Key.MODES: U16.pack(len(modes)),
            Key.TYPICAL_MODE: U16.pack(self.model.typical),
        }
        if key in plain:
            return plain[key]
        if mode >= len(modes):
            return b""
        chosen = modes[mode]
        of_mode: dict[int, bytes] = {
            Key.SAMPLE_TIME: U32.pack(round(chosen.period * 1e6 * 256)),
            Key.MAX_DISTANCE: U32.pack(round(chosen.max_distance * 256)),
            Key.ANSWER_TYPE: bytes((chosen.answer,)),
            Key.NAME: chosen.name.encode() + b"\0",
        }
        return of_mode.get(key, b"")

    def _scan(self, mode: Mode, now: float) -> None:
        self._stop()
        if self.motor_on and self.health.status != Status.ERROR:
            self.say(descriptor(mode.answer, LENGTHS[mode.answer]), now + ANSWER_AFTER)
            self._measure(mode, now)

    def _measure(self, mode: Mode, now: float) -> None:
        self._turn += 1
        sampler = Sampler(
            self.feed,
            mode.answer,
            period=mode.period,
            turn_time=self._turn_time,
            begin=now + FIRST_SAMPLE,
            first_turn=self._turn,
            seed=self._seed,
        )
        self._stream = Stream(mode.answer, sampler)

    def _troubled(self, frame: bytes) -> bytes:
        """Return a frame with the troubles that befall it."""
        if self._stream is None or self._stream.answer is Answer.NODES:
            return frame
        for trouble, change in (("bad_checksum", with_bad_checksum), ("angle_jump", with_jump)):
            if trouble in self._troubles and self._random.random() < self._trouble_rate:
                frame = change(frame)
        return frame

    def _healthy(self) -> Health:
        if "broken" in self._troubles:
            return Health(Status.ERROR, ERROR_CODE)
        if "warning" in self._troubles:
            return Health(Status.WARNING, WARNING_CODE)
        return Health(Status.GOOD, 0)

    def _stop(self) -> None:
        if self._stream is not None:
            self.hush()
        self._stream = None

    def _boot(self, now: float) -> None:
        self.hush()
        self._host = b""
        self._stream = None
        self.health = self._healthy()
        self._ready_at = now + BOOT
