"""The host's clock, by which arrivals and stamps are told."""

import time

_EPOCH = time.time() - time.monotonic()


def now() -> float:
    """Return the time [s since the epoch], on a clock that is never set."""
    return _EPOCH + time.monotonic()
