"""The state of an emulated sensor that its commands read and change."""

from dataclasses import dataclass, field
from typing import Literal

from laserfeatures.drivers.urg.clock import WRAP
from laserfeatures.drivers.urg.commands import Measurement
from laserfeatures.emulators.urg.models import Model

Mode = Literal["scip1", "idle", "laser on", "streaming", "tm"]


@dataclass
class State:
    """What a sensor is doing.

    Parameters
    ----------
    model : Model
        What it is.
    mode : str
        "scip1", "idle", "laser on", "streaming" or "tm".
    clock_ms : float
        What its clock shows at time `since` [ms].
    since : float
        [s] on the link's clock; a turn begins then, too.
    """

    model: Model
    mode: Mode
    clock_ms: float
    since: float
    stream: Measurement | None = None
    echo_string: bytes = b""  # what stands behind the stream's command
    left: int = 0  # scans still to come of a stream with an end
    begin: int = 0  # turn before which a stream sends nothing
    motor: int = 0
    spin: float = field(init=False)  # when turn `turn_0` began
    turn_0: int = 0
    sensitive: bool = False
    baud: int | None = None
    pending_baud: int | None = None
    checking: int = 0  # turns until a check is over

    def __post_init__(self) -> None:
        """Let the first turn begin."""
        self.spin = self.since

    @property
    def laser(self) -> bool:
        """Whether the laser is on."""
        return self.mode in {"laser on", "streaming"}

    @property
    def speed(self) -> float:
        """Speed of the motor [rpm]: a per cent less for each number of CR."""
        return self.model.geometry.speed * (1 - self.motor / 100)

    @property
    def period(self) -> float:
        """How long a turn takes [s]."""
        return 60.0 / self.speed

    def clock(self, time: float) -> int:
        """Return what the clock shows [ms] at a time [s]."""
        return int(self.clock_ms + (time - self.since) * 1000 + 1e-6) % WRAP

    def turn_begin(self, turn: int) -> float:
        """Return when a turn is at step 0 [s]."""
        return self.spin + (turn - self.turn_0) * self.period

    def turn_end(self, turn: int) -> float:
        """Return when a turn has measured its last step [s]."""
        geometry = self.model.geometry
        return self.turn_begin(turn) + (geometry.last + 1) / geometry.steps * self.period

    def next_turn(self, time: float) -> int:
        """Return the first turn that ends after a time [s]."""
        turns = (time - self.turn_end(self.turn_0)) / self.period
        return self.turn_0 + max(int(turns + 1 + 1e-9), 0)

    def set_motor(self, motor: int, time: float) -> None:
        """Change the motor's speed from the next turn on."""
        turn = self.next_turn(time)
        self.spin, self.turn_0 = self.turn_begin(turn), turn
        self.motor = motor

    def light(self, mode: Mode) -> None:
        """Go to a mode; a stream that is none any more is forgotten."""
        self.mode = mode
        self.checking = 0
        if mode != "streaming":
            self.stream = None
