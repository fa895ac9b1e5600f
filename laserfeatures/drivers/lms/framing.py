"""Finding the telegrams of an LMS2xx in a stream of bytes."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from laserfeatures.drivers.lms.measurements import INDEX_BYTES, PREFIX, WITH_REFLECTIVITY
from laserfeatures.drivers.lms.measurements import expected_size as data_size
from laserfeatures.drivers.lms.telegrams import (
    ACK,
    ENVELOPE,
    FROM_SCANNER,
    LARGEST,
    NAK,
    REPLY_ADDRESSES,
    STX,
    Answer,
    Message,
    Telegram,
    parse,
)
from laserfeatures.errors import ProtocolError

SHORT = 256  # bytes that LEN counts at most in what carries no values; the longest known has 154
LONG_REPLIES = {*PREFIX, 0xBE, 0xF5}
ANSWERS = {ACK: True, NAK: False}


@dataclass
class Framer:
    """Cuts a stream of bytes into telegrams; after damage it goes on at the next possible start.

    Attributes
    ----------
    asked : bool
        Whether an answer to a request is due. The request stops what the scanner is sending, so
        that the answer may follow a telegram that never ends.
    damaged, garbage : int
        Telegrams with a wrong checksum, and bytes of no telegram, so far.
    """

    asked: bool = False
    damaged: int = 0
    garbage: int = 0
    _buffer: bytearray = field(default_factory=bytearray)
    _base: int = 0  # place in the stream of the buffer's first byte
    _marks: deque[tuple[int, float]] = field(default_factory=deque)
    _damage_end: int = 0
    _clean: bool = True  # no garbage before the buffer's first byte

    def take(self, data: bytes, time: float) -> Iterator[tuple[Message, float]]:
        """Yield what has become whole with more bytes, and when its first byte came [s]."""
        if not self._buffer:
            self._marks.clear()
        self._marks.append((self._base + len(self._buffer), time))
        self._buffer += data
        while self._buffer:
            if self.asked and self._clean and self._buffer[0] in ANSWERS:
                yield Answer(ANSWERS[self._buffer[0]]), self._arrival()
                self.asked = False
                self._drop(1)
                continue
            size = self._size_at(0)
            if size == 0 or (size and len(self._buffer) < size):
                if not self._cut_by_answer():
                    return
            elif size is None or (telegram := self._parsed(0, size)) is None:
                self._skip(size or 0)
            else:
                yield telegram, self._arrival()
                self.asked &= telegram.command in LONG_REPLIES
                self._drop(size)
                self._clean = True

    def _arrival(self) -> float:
        return self._marks[0][1]

    def _drop(self, count: int) -> None:
        del self._buffer[:count]
        self._base += count
        while len(self._marks) > 1 and self._marks[1][0] <= self._base:
            self._marks.popleft()

    def _skip(self, size: int) -> None:
        """Go to the next possible start; `size` > 0: here stands a telegram that is damaged."""
        if size and self._base >= self._damage_end:
            self.damaged += 1
            self._damage_end = self._base + size
        count = self._buffer.find(STX, 1)
        count = len(self._buffer) if count < 0 else count
        self.garbage += max(self._base + count - max(self._damage_end, self._base), 0)
        self._clean = False
        self._drop(count)

    def _size_at(self, start: int) -> int | None:
        """Return the size of the telegram that may start here, 0: unclear yet; None: none does."""
        head = bytes(self._buffer[start : start + 13])
        if head[0] != STX or (len(head) > 1 and head[1] not in REPLY_ADDRESSES):
            return None
        if len(head) < 5:
            return 0
        length, command = int.from_bytes(head[2:4], "little"), head[4]
        largest = LARGEST - ENVELOPE if command in LONG_REPLIES else SHORT
        if not (command & FROM_SCANNER and 2 <= length <= largest):
            return None
        if command in PREFIX and command != WITH_REFLECTIVITY:
            data = data_size(command, head[5:])
            if data is None:
                return 0
            if length - 2 - data not in {0, INDEX_BYTES}:
                return None
        return length + ENVELOPE

    def _parsed(self, start: int, size: int) -> Telegram | None:
        try:
            return parse(bytes(self._buffer[start : start + size]))
        except ProtocolError:
            return None

    def _cut_by_answer(self) -> bool:
        """Drop the telegram here if within it stands a whole answer, and return whether."""
        at = 0
        while self.asked and (at := self._buffer.find(bytes([ACK, STX]), at + 1)) > 0:
            size = self._size_at(at + 1)
            if size and len(self._buffer) >= at + 1 + size and self._parsed(at + 1, size):
                self.garbage += at
                self._drop(at)
                self._clean = True
                return True
        return False
