"""The thread that reads a port, so that nothing is lost while its user is busy."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar

from laserfeatures.drivers.decoder import Decoder, Event, Sweep
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.port import Port

Tap = Callable[[str, bytes, float], None]
Reply = TypeVar("Reply")

POLL = 0.1  # [s]; how long a closing driver waits for its thread at most
HEARD = 4096  # bytes kept, to say what answered
REPLIES = 256


class Reader:
    """Reads a port into a decoder and keeps what comes out until it is fetched.

    Parameters
    ----------
    port : Port
        Where the device is.
    decoder : Decoder
        Of its protocol.
    buffer : int
        How many scans are kept; beyond that the oldest goes, and is counted.
    tap : callable or None
        Is called with "rx" or "tx", the bytes and their time, in the decoder's order; first of all
        with "open" and no bytes.
    """

    def __init__(self, port: Port, decoder: Decoder, buffer: int, tap: Tap | None) -> None:
        self.port = port
        self.heard = bytearray()
        self.last_heard = now()
        self._decoder = decoder
        self._tap = tap
        self._events: deque[Event] = deque()
        self._buffer = buffer
        self._replies: deque[object] = deque(maxlen=REPLIES)
        self._lock = threading.Lock()
        self._new_event = threading.Condition(self._lock)
        self._new_reply = threading.Condition(self._lock)
        self._error: BaseException | None = None
        self._stopping = False
        if tap:
            tap("open", b"", self.last_heard)
        self._thread = threading.Thread(target=self._run, name=f"read {port.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the thread and close the port."""
        self._stopping = True
        self._thread.join()
        self.port.close()

    def write(self, data: bytes, gap: float = 0.0) -> None:
        """Send bytes to the device, one by one with a pause of `gap` [s] if that is not 0.

        Raises
        ------
        DeviceLostError
            If the port is gone.
        """
        with self._lock:
            time_ = now()
            if self._tap:
                self._tap("tx", data, time_)
            self._decoder.sent(data, time_)
        if not gap:
            self.port.write(data)
            return
        for i in range(len(data)):
            self.port.write(data[i : i + 1])
            time.sleep(gap)

    def forget(self) -> None:
        """Drop the replies that nobody has fetched."""
        with self._lock:
            self._replies.clear()

    def event(self, timeout: float) -> Event | None:
        """Return the next scan or halt, or None if none has come within `timeout` [s]."""
        return self._wait(
            self._new_event, timeout, lambda: self._events.popleft() if self._events else None
        )

    def reply(self, match: Callable[[object], Reply | None], timeout: float) -> Reply | None:
        """Return what `match` makes of the first reply that it accepts, or None after `timeout`.

        The replies before it are dropped.
        """

        def look() -> Reply | None:
            while self._replies:
                found = match(self._replies.popleft())
                if found is not None:
                    return found
            return None

        return self._wait(self._new_reply, timeout, look)

    def _wait(
        self, news: threading.Condition, timeout: float, look: Callable[[], Reply | None]
    ) -> Reply | None:
        deadline = time.monotonic() + timeout
        with self._lock:
            while (found := look()) is None:
                if self._error:
                    raise self._error
                left = deadline - time.monotonic()
                if left <= 0:
                    return None
                news.wait(left)
            return found

    def _run(self) -> None:
        try:
            while not self._stopping:
                data = self.port.read(POLL)
                if data:
                    self._take(data, now())
        except BaseException as error:  # noqa: BLE001 - whoever waits for scans gets it
            with self._lock:
                self._error = error
                self._new_event.notify_all()
                self._new_reply.notify_all()

    def _take(self, data: bytes, time_: float) -> None:
        with self._lock:
            self.last_heard = time_
            self.heard += data
            del self.heard[:-HEARD]
            if self._tap:
                self._tap("rx", data, time_)
            for message in self._decoder.received(data, time_):
                if isinstance(message, Event):
                    self._events.append(message)
                    self._new_event.notify()
                else:
                    self._replies.append(message)
                    self._new_reply.notify()
            while len(self._events) > self._buffer:
                dropped = self._events.popleft()
                self._decoder.losses.overruns += isinstance(dropped, Sweep)
