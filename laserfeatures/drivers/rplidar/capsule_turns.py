"""Turns out of the capsules of an express scan."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import IntArray
from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.capsule_framing import CapsuleFraming
from laserfeatures.drivers.rplidar.capsules import CAPSULE, HEAD, SAMPLES, start_of, unpack_capsules
from laserfeatures.drivers.rplidar.node_turns import LONGEST_GAP, SHORTEST_TURN, USUAL_TURN, Turn
from laserfeatures.drivers.rplidar.nodes import DEGREE, TURN, Measurements
from laserfeatures.drivers.rplidar.turns import EMPTY, joined, part

WIDEST = 120 * DEGREE  # that a capsule spans
SIMILAR = 0.3  # relative difference from the usual span
FOLLOWING = 4  # bytes of the next capsule's body that a capsule is decoded with
DOUBLED = 1  # stray bytes after a capsule with a doubled byte, which its checksum may not tell
MOST = 2000  # capsules in a turn; beyond that the motor stands


class Kind(NamedTuple):
    """A kind of capsule: bytes, measurements, and how many of them are decoded at once."""

    size: int
    samples: int
    unpack: Callable[[bytes, IntArray, IntArray, bytes], Measurements]


def _legacy(data: bytes, starts: IntArray, spans: IntArray, _: bytes) -> Measurements:
    return unpack_capsules(data, starts, spans)


LEGACY = Kind(CAPSULE, SAMPLES, _legacy)


class CapsuleTurns:
    """From the bytes of an express scan to turns, each from one wrap of the angle to the next.

    A capsule needs the start of the next one for its own angles: with a lost or damaged capsule the
    one before it is lost, too. One that seems to span much more or less than the others do stands
    before a gap.

    Parameters
    ----------
    kind : Kind
        What capsules they are.
    period : float
        Time from measurement to measurement [s].
    baud : int
        Rate of the line [Bd].
    losses : Losses
        Where damage is counted.
    """

    def __init__(self, kind: Kind, period: float, baud: int, losses: Losses) -> None:
        self.delay = kind.samples * period + kind.size * 10 / baud  # from measurement to arrival
        self._kind = kind
        self._period = period
        self._losses = losses
        self._framing = CapsuleFraming(kind.size, losses)
        self._previous: tuple[bytes, int, float] | None = None
        self._usual = self._other = 0
        self._turn_time = USUAL_TURN
        self._until = float("nan")
        self._begin: float | None = None
        self._head = EMPTY  # measured in the last capsule of the turn before
        self._last = -1  # start of the last capsule taken in this turn
        self._end = 0  # where the last one taken ends
        self._capsules, self._following = bytearray(), bytearray()
        self._starts: list[int] = []
        self._spans: list[int] = []

    def feed(self, data: bytes, time: float) -> list[Turn]:
        """Take bytes that came at `time` [s since the epoch]; return the turns that are whole."""
        done: list[Turn] = []
        byte_time = self._kind.samples * self._period / self._kind.size
        for capsule, behind, stray in self._framing.feed(data):
            self._losses.frames += 1
            start, first = start_of(capsule)
            if first:  # the device has started anew
                self._drop()
            elif self._previous is not None and stray != DOUBLED:
                done += self._decode(self._previous, capsule, start, hurt=stray > 0)
            self._previous = (capsule, start, time - behind * byte_time - self.delay)
        return done

    def _decode(
        self, previous: tuple[bytes, int, float], after: bytes, end: int, *, hurt: bool
    ) -> list[Turn]:
        """Take a capsule whose successor is known, and whether something was damaged between."""
        capsule, start, begin = previous
        span = (end - start) % TURN
        if not self._fits(span, hurt):
            return []
        late = begin - self._until > LONGEST_GAP * self._turn_time
        if len(self._starts) > MOST or (late and not self._goes_on(start)):
            self._drop()
        self._until = begin + self._kind.samples * self._period
        done = self._finish(None, begin) if start < self._last else []
        self._last, self._end = start, start + span
        self._capsules += capsule
        self._following += after[HEAD : HEAD + FOLLOWING]
        self._starts.append(start)
        self._spans.append(span)
        if start + span >= TURN:
            within = -((start - TURN) * self._kind.samples // span)  # raw angle past 360 degrees
            done += self._finish(within, begin + within * self._period)
        return done

    def _goes_on(self, start: int) -> bool:
        """Return whether a capsule starts where the last one taken ends: it only came late."""
        off = (start - self._end + TURN // 2) % TURN - TURN // 2
        return abs(off) <= SIMILAR * self._usual

    def _fits(self, span: int, hurt: bool) -> bool:
        """Return whether a span is the usual one; what comes twice becomes usual."""
        for known in (self._usual, self._other):
            if 0 < span <= WIDEST and abs(span - known) <= SIMILAR * known:
                self._usual, self._other = span, 0
                return True
        if not hurt:  # else it has been counted
            self._losses.damaged += self._usual > 0
            self._other = span
        return False

    def _clear(self, rest: Measurements) -> None:
        self._head = rest
        self._last = -1
        for kept in (self._capsules, self._following, self._starts, self._spans):
            kept.clear()

    def _drop(self) -> None:
        """Give up the turn that is under way."""
        self._losses.missed += self._begin is not None
        self._begin = None
        self._clear(EMPTY)

    def _finish(self, within: int | None, next_begin: float) -> list[Turn]:
        """End a turn, after `within` measurements of its last capsule or after all of them."""
        starts, spans = np.array(self._starts, np.int64), np.array(self._spans, np.int64)
        decoded = EMPTY
        if self._starts:
            raw, following = bytes(self._capsules), bytes(self._following)
            decoded = self._kind.unpack(raw, starts, spans, following)
        whole = joined((self._head, decoded))
        size = len(whole.angles)
        end = size if within is None else size - self._kind.samples + within
        begin, self._begin = self._begin, next_begin
        self._clear(part(whole, slice(end, None)))
        if begin is None:
            return []
        self._turn_time = max(size * self._period, SHORTEST_TURN)
        return [Turn(part(whole, slice(end)), begin)]
