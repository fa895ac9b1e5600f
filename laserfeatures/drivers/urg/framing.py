"""Finding the replies in what comes from a sensor, damaged or not."""

import re
from collections import deque
from collections.abc import Callable, Iterator
from typing import TypeVar

from laserfeatures.drivers.losses import Losses
from laserfeatures.errors import ProtocolError

Message = TypeVar("Message")

END = b"\n\n"
LARGEST = 1 << 14  # bytes; a scan of 1440 steps has 4.6 kB

# Where a reply may begin: an echo and a status, wherever they stand.
_HEAD = re.compile(
    rb"(?:M[DS]\d{13}|G[DS]\d{10}|VV|PP|II|BM|QT|RS|RT|V|TM.|SS.{6}|CR..|HS.|SCIP2\.0)"
    rb"(?:;[ -~]{0,16})?\n(?:[0-9][0-9A-Z][0-o]|[0E])\n"
)


class Framer:
    """Cuts a stream of bytes into replies.

    A reply ends with an empty line. What stands before an empty line is tried from each place
    where a reply may begin, so that the remains of one do not hurt the next.

    Parameters
    ----------
    losses : Losses
        Where damage is counted.
    """

    def __init__(self, losses: Losses) -> None:
        self._losses = losses
        self.reset()

    def reset(self) -> None:
        """Forget what is half received."""
        self._buffer = bytearray()
        self._searched = 0
        self._start = 0  # of the buffer, in all bytes ever taken
        self._pieces: deque[tuple[int, float]] = deque()  # where a piece begins, and its time

    def take(
        self, data: bytes, time: float, decode: Callable[[bytes], Message]
    ) -> Iterator[tuple[Message, float]]:
        """Yield what `decode` makes of each reply, and when its first byte came [s].

        `decode` takes bytes that end with an empty line and raises ProtocolError if they are no
        whole reply.
        """
        self._pieces.append((self._start + len(self._buffer), time))
        self._buffer += data
        while (end := self._buffer.find(END, self._searched)) >= 0:
            yield from self._replies(bytes(self._buffer[: end + 2]), decode)
            self._drop(end + 2)
        self._searched = max(len(self._buffer) - 1, 0)
        if len(self._buffer) > LARGEST:
            self._losses.garbage += len(self._buffer) - LARGEST // 2
            self._drop(len(self._buffer) - LARGEST // 2)

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self._searched = max(self._searched - count, 0)
        self._start += count
        while len(self._pieces) > 1 and self._pieces[1][0] <= self._start:
            self._pieces.popleft()

    def _replies(
        self, chunk: bytes, decode: Callable[[bytes], Message]
    ) -> Iterator[tuple[Message, float]]:
        failures = 0
        position = 0
        while found := _HEAD.search(chunk, position):
            try:
                message = decode(chunk[found.start() :])
            except ProtocolError as error:
                failures += 1
                self._losses.problem = str(error)
                position = found.start() + 1
                continue
            self._count(failures, found.start())
            self._losses.frames += 1
            yield message, self._time_of(found.start())
            return
        self._count(failures, len(chunk))

    def _count(self, failures: int, length: int) -> None:
        """Count what stands before a reply: replies that fail, or bytes that are none."""
        if failures:
            self._losses.damaged += 1
        else:
            self._losses.garbage += length

    def _time_of(self, position: int) -> float:
        """Return when a byte of the buffer came."""
        time = self._pieces[0][1]
        for begin, came in self._pieces:
            if begin > self._start + position:
                break
            time = came
        return time
