"""The requests in the bytes that an emulated LMS2xx hears."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from laserfeatures.drivers.lms.telegrams import BROADCAST, ENVELOPE, STX

LONGEST = 64  # bytes that LEN counts at most in a request


@dataclass
class Hearing:
    """Collects requests.

    Parameters
    ----------
    gap : float
        After how long between two bytes a half request is dropped [s].
    address : int
        That it obeys, beside the broadcast.
    """

    gap: float
    address: int
    _buffer: bytearray = field(default_factory=bytearray)
    _last: float = 0.0

    def take(self, data: bytes, now: float) -> Iterator[bytes]:
        """Yield the requests to this scanner that have become whole, with any checksum."""
        if now - self._last > self.gap:
            self._buffer.clear()
        self._last = now
        self._buffer += data
        while (start := self._buffer.find(STX)) >= 0:
            del self._buffer[:start]
            if len(self._buffer) < 4:
                return
            length = int.from_bytes(self._buffer[2:4], "little")
            if not 1 <= length <= LONGEST:
                del self._buffer[0]
                continue
            if len(self._buffer) < length + ENVELOPE:
                return
            request = bytes(self._buffer[: length + ENVELOPE])
            del self._buffer[: length + ENVELOPE]
            if request[1] in {BROADCAST, self.address}:
                yield request
        self._buffer.clear()

    def forget(self) -> None:
        """Drop what is half heard."""
        self._buffer.clear()
