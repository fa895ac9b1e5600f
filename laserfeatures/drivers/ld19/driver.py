"""The driver of the LD06 and LD19."""

import logging
from dataclasses import dataclass
from typing import ClassVar

from laserfeatures.drivers.driver import Driver
from laserfeatures.drivers.ld19.decoder import Ld19Decoder
from laserfeatures.drivers.ld19.frames import Frame
from laserfeatures.drivers.ld19.turns import RANGE_MIN, Turns

log = logging.getLogger("laserfeatures.drivers")

SLOW = 115_200  # [Bd]; at which an LD14 and an LDS-02 send the frames of an LD19
OTHERS = (
    f"an LD14 and an LDS-02 send the same frames at {SLOW} Bd, but their angles are not right "
    "here: they want a correction by the range that this driver does not make"
)
SPIN_UP = 3.0  # [s] until the motor turns and frames come


@dataclass(kw_only=True, eq=False)
class Ld19(Driver):
    """An LDROBOT LD06, LD19, STL-06P or STL-19P (STL-27L: ``baud=921600``).

    The device talks from power-on and cannot be told anything: leaving closes the port only.

    Parameters
    ----------
    range_max : float
        Range at and beyond which there is no return [m].
    min_intensity : int
        Measurements with less intensity (0 to 255) are no returns; weak ones near by are noise.
    """

    protocol: ClassVar[str] = "ld19"
    usual_baud: ClassVar[int] = 230_400

    range_max: float = 12.0
    min_intensity: int = 0

    def __post_init__(self) -> None:
        """Check the parameters."""
        super().__post_init__()
        if not self.range_max > RANGE_MIN:
            raise ValueError(f"range_max must be > {RANGE_MIN} m, got {self.range_max}")
        if not 0 <= self.min_intensity <= 255:
            raise ValueError(f"min_intensity must be in 0..255, got {self.min_intensity}")

    def decoder(self) -> Ld19Decoder:
        """Return a new decoder."""
        turns = Turns(self.losses, self.range_max, self.min_intensity)
        return Ld19Decoder(self.losses, turns, self.baud or self.usual_baud)

    @property
    def doubt(self) -> str | None:
        """What else a device at this rate may be."""
        return OTHERS if self.baud == SLOW else None

    @property
    def patience(self) -> float:
        """How long the next scan may take [s]: two turns of a slow motor."""
        return 1.0

    def _start(self) -> None:
        frame = self.reader.reply(
            lambda reply: reply if isinstance(reply, Frame) else None, SPIN_UP
        )
        if frame is None:
            raise self._no_answer("the frames of an LD06 or LD19 (54 2c ..)")
        if self.doubt is not None:
            log.warning("%s: %s", self.port, self.doubt)

    def _stop(self) -> None:
        pass  # there is no command for it
