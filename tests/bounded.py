"""Processes and waits that have an end, whatever goes wrong and whatever signals we ignore."""

import signal
import subprocess
import threading
import time
from contextlib import suppress

WAIT = 300  # [s]; longer than anything takes that goes well, a first compilation included
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def until(condition, step=None, pause=0.002):
    """Wait until a condition holds, with a step each time round; fail after `WAIT`."""
    end = time.monotonic() + WAIT
    while not condition():
        assert time.monotonic() < end, "it has not come"
        if step is None:
            time.sleep(pause)
        else:
            step()


class Child(subprocess.Popen):
    """A process of our own that hears signals, and is dead when its ``with`` block ends.

    A shell starts what stands before ``&`` with Ctrl-C ignored, and children inherit that. After
    `WAIT` it is killed, so that nobody reads from it for ever.
    """

    def __init__(self, arguments, *, heeds=True, **options):
        ignored = [each for each in ENDING if signal.getsignal(each) is signal.SIG_IGN]
        for each in ignored if heeds else ():
            signal.signal(each, signal.SIG_DFL)
        try:
            super().__init__(arguments, **options)
        finally:
            for each in ignored:
                signal.signal(each, signal.SIG_IGN)
        self._killer = threading.Timer(WAIT, self.kill)
        self._killer.daemon = True
        self._killer.start()

    def __exit__(self, *error):
        """Kill it, unless it is ending by itself."""
        with suppress(subprocess.TimeoutExpired):
            self.wait(timeout=0 if error[0] else WAIT)
        self._killer.cancel()
        self.kill()
        super().__exit__(*error)
