"""From an LD19's bytes to frames and scans."""

from laserfeatures.drivers.decoder import Sweep
from laserfeatures.drivers.ld19.continuity import Continuity
from laserfeatures.drivers.ld19.frames import HEAD, SIZE, Frame, decode
from laserfeatures.drivers.ld19.turns import Turns
from laserfeatures.drivers.losses import Losses
from laserfeatures.errors import ProtocolError

BITS = 10  # on the line for a byte


class Ld19Decoder:
    """Finds the frames among the bytes, and has them put together to turns.

    Parameters
    ----------
    losses : Losses
        Where damage is counted.
    turns : Turns
        What makes scans of frames.
    baud : int
        Rate of the line [Bd], to tell when a frame's first byte came.
    """

    def __init__(self, losses: Losses, turns: Turns, baud: int) -> None:
        self.losses = losses
        self._turns = turns
        self._baud = baud
        self._continuity = Continuity()
        self.reset()

    def reset(self) -> None:
        """Forget what is half received."""
        self._buffer = bytearray()
        self._continuity.reset()
        self._turns.reset()

    def sent(self, data: bytes, time: float) -> None:
        """Ignore it: the device does not listen."""

    def received(self, data: bytes, time: float) -> list[Sweep | Frame]:
        """Return the frames, and the scans that they complete."""
        self._buffer += data
        found: list[Sweep | Frame] = []
        while len(self._buffer) >= SIZE and self._skip_to_head():
            try:
                frame = decode(bytes(self._buffer[:SIZE]))
            except ProtocolError as error:
                self.losses.damaged += 1
                self.losses.problem = str(error)
                self._drop(1)  # another frame may begin anywhere behind
                continue
            first = time - len(self._buffer) * BITS / self._baud
            certain, false = self._continuity.check(frame, first)
            self.losses.damaged += false
            # A false frame may have taken the first bytes of the next.
            del self._buffer[: 1 if self._continuity.doubts else SIZE]
            for each, arrival in certain:
                self.losses.frames += 1
                found.append(each)
                found += self._turns.add(each, arrival)
        return found

    def _skip_to_head(self) -> bool:
        """Drop what stands before the next head; return whether a whole frame may follow."""
        start = self._buffer.find(HEAD)
        if start < 0:
            start = len(self._buffer) - self._buffer.endswith(HEAD[:1])
        if start:
            self._drop(start)
        return len(self._buffer) >= SIZE

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self.losses.garbage += count
