"""Turns out of the nodes of a standard scan."""

from typing import NamedTuple

import numpy as np

from laserfeatures.drivers.losses import Losses
from laserfeatures.drivers.rplidar.node_framing import NodeFraming, angle_at, near, starts_turn
from laserfeatures.drivers.rplidar.nodes import NODE, TURN, Measurements, unpack_nodes
from laserfeatures.drivers.rplidar.turns import difference, outliers, part

MOST = 20_000  # measurements in a turn; beyond that the motor stands
FRONT = 15 * 64  # how far from each other turns start [1/64 degree]
FEWEST = 50  # measurements in a turn
HELD = 3  # nodes that the framing holds back until it has seen what follows
SHORTEST_TURN = 0.05  # [s]
USUAL_TURN = 0.2  # [s]; that of a slow one, until one has been seen
LONGEST_GAP = 0.5  # turns without a byte: if the angle jumps there, this may be another turn


class Turn(NamedTuple):
    """The measurements of a turn, and when its first one was made [s since the epoch]."""

    measured: Measurements
    begin: float


class NodeTurns:
    """From the bytes of a standard scan to turns, each from one start flag to the next.

    A turn whose successor's start flag was lost is cut where its angles have gone round. The first
    turn begins with the first start flag.

    Parameters
    ----------
    period : float
        Time from measurement to measurement [s].
    baud : int
        Rate of the line [Bd].
    losses : Losses
        Where damage is counted.
    """

    def __init__(self, period: float, baud: int, losses: Losses) -> None:
        self.delay = NODE * 10 / baud  # from measurement to arrival
        self._period = period
        self._losses = losses
        self._framing = NodeFraming(losses)
        self._nodes = bytearray()
        self._begin: float | None = None
        self._front = self._other = self._other_at = 0  # where turns start [1/64 degree]
        self._until, self._last = float("nan"), 0  # time and angle of the last node
        self._late = False
        self._turn_time = USUAL_TURN

    def feed(self, data: bytes, time: float) -> list[Turn]:
        """Take bytes that came at `time` [s since the epoch]; return the turns that are whole."""
        done: list[Turn] = []
        for run, behind in self._framing.feed(data):
            count = len(run) // NODE
            self._losses.frames += count
            until = time - behind / NODE * self._period - self.delay
            begin = until - (count - 1) * self._period
            self._look_for_gap(run, begin)
            self._until, self._last = until, angle_at(run, count - 1)
            at = 0
            while (start := starts_turn(run, at)) >= 0:
                self._nodes += run[at * NODE : start * NODE]
                if not self._at_front(angle_at(run, start)):
                    self._nodes += run[start * NODE : start * NODE + NODE]
                    at = start + 1
                    continue
                done += self._finish()
                self._begin = begin + start * self._period
                self._nodes += run[start * NODE : start * NODE + NODE]
                at = start + 1
            self._nodes += run[at * NODE :]
            if len(self._nodes) > MOST * NODE:
                self._drop()
        return done

    def _look_for_gap(self, run: bytes, begin: float) -> None:
        """Give up the turn if bytes are late and the angle jumps; else they only came late."""
        late = self._late or begin - self._until > LONGEST_GAP * self._turn_time
        last = len(run) // NODE - 1
        if late and not near(angle_at(run, min(HELD, last)), self._last):
            self._drop()
        self._late = late and last < HELD

    def _at_front(self, angle: int) -> bool:
        """Return whether turns start at this angle; where two in a row start, they do from now on.

        A flag elsewhere comes from a damaged node.
        """
        again = self._losses.frames - self._other_at > FEWEST and near(angle, self._other, FRONT)
        if again or near(angle, self._front, FRONT):
            self._front = angle
            return True
        self._other, self._other_at = angle, self._losses.frames
        return False

    def _drop(self) -> None:
        """Give up the turn that is under way."""
        self._losses.missed += self._begin is not None
        self._begin = None
        self._nodes.clear()

    def _finish(self) -> list[Turn]:
        nodes, begin = bytes(self._nodes), self._begin
        self._nodes.clear()
        if begin is None or not nodes:
            return []
        measured = unpack_nodes(nodes)
        wrong = outliers(measured)
        self._losses.damaged += int(wrong.sum())
        pieces = one_turn_each(part(measured, ~wrong))
        turns = [Turn(piece, begin + at * self._period) for at, piece in pieces]
        self._turn_time = max(len(measured.angles) * self._period / len(turns), SHORTEST_TURN)
        return turns


def one_turn_each(measured: Measurements) -> list[tuple[int, Measurements]]:
    """Cut measurements where their angles go round; return index and measurements of each turn."""
    angles = measured.angles
    start = angles[0] - TURN if angles[0] > TURN // 2 else angles[0]
    travelled = start + np.cumsum(difference(angles, np.append(angles[0], angles[:-1])))
    if travelled[-1] < 1.5 * TURN:  # the flag is set near to the front, not right at it
        return [(0, measured)]
    turns = range(1, round(travelled[-1] / TURN))
    places = [0, *(int(np.argmax(travelled >= turn * TURN)) for turn in turns)]
    return [
        (begin, part(measured, slice(begin, end)))
        for begin, end in zip(places, [*places[1:], None], strict=True)
    ]
