"""What can go wrong between a rangefinder and its host, by name, at random, with a seed."""

from collections.abc import Callable, Mapping
from random import Random

from laserfeatures.registry import near_names


def _garbage(frame: bytes, random: Random) -> bytes:
    return random.randbytes(random.randint(1, 40)) + frame


def _lost_byte(frame: bytes, random: Random) -> bytes:
    i = random.randrange(len(frame))
    return frame[:i] + frame[i + 1 :]


def _doubled_byte(frame: bytes, random: Random) -> bytes:
    i = random.randrange(len(frame))
    return frame[: i + 1] + frame[i:]


def _bit_flip(frame: bytes, random: Random) -> bytes:
    i = random.randrange(len(frame))
    return frame[:i] + bytes([frame[i] ^ 1 << random.randrange(8)]) + frame[i + 1 :]


def _cut(frame: bytes, random: Random) -> bytes:
    return frame[: random.randrange(len(frame))]


def _whole(frame: bytes, _random: Random) -> bytes:
    return frame


FAULTS: Mapping[str, Callable[[bytes, Random], bytes]] = {
    "garbage": _garbage,
    "lost_byte": _lost_byte,
    "doubled_byte": _doubled_byte,
    "bit_flip": _bit_flip,
    "cut": _cut,
    "stuck": _whole,  # from here on the device itself, or its link, does what the name says
    "restart": _whole,
    "unplug": _whole,
}
"""What may hit a frame: garbage before it (the frame itself stays whole), a byte lost or doubled, a
bit flipped, its end cut off; the device falls silent, restarts, or is unplugged and plugged in."""


class Faults:
    """Hits frames at random.

    Parameters
    ----------
    rates : mapping of str to float
        Probability that each fault of `FAULTS` hits a frame.
    seed : int
        Seed of all of it.
    stuck_time : float
        How long a stuck device is silent and deaf [s].
    unplugged_time : float
        How long an unplugged one is away [s].

    Raises
    ------
    ValueError
        If there is no such fault, or a probability is none.
    """

    def __init__(
        self,
        rates: Mapping[str, float] | None = None,
        *,
        seed: int = 0,
        stuck_time: float = 1.0,
        unplugged_time: float = 1.0,
    ) -> None:
        self.rates = dict(rates or {})
        for name, rate in self.rates.items():
            if name not in FAULTS:
                raise ValueError(f"there is no fault {name!r}; {near_names(name, FAULTS)}")
            if not 0 <= rate <= 1:
                raise ValueError(f"the rate of {name} must be in [0, 1], got {rate}")
        self.stuck_time = stuck_time
        self.unplugged_time = unplugged_time
        self.unplugged = False
        self._random = Random(seed)  # noqa: S311 - for tests, not for secrets

    def damage(self, frame: bytes) -> tuple[bytes, str | None]:
        """Return a frame as it arrives, and the name of the fault that hit it, if one did."""
        for name, rate in self.rates.items():
            if frame and self._random.random() < rate:
                self.unplugged |= name == "unplug"
                return FAULTS[name](frame, self._random), name
        return frame, None
