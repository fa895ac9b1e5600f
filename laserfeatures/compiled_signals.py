"""Signals while code is compiled: what their handlers raise must not be lost on its way."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

AGAIN = 0.02  # [s]


@contextmanager
def heard_outside_of_callbacks() -> Iterator[None]:
    """Let handlers of signals run only where what they raise comes out.

    LLVM calls Python back with the code that it has made, and so do objects that go away. An
    exception ends there: Python shows it and goes on. It is the first place where a handler runs
    after LLVM was busy, so Ctrl-C was mostly lost there. Such a signal is sent again a bit later.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before: dict[int, Callable[[int, FrameType | None], Any]] = {
        number: handler
        for number in signal.valid_signals()
        if callable(handler := signal.getsignal(number)) and not isinstance(handler, int)
    }

    def hear(number: int, frame: FrameType | None) -> Any:
        if not _in_callback(frame):
            return before[number](number, frame)
        later = threading.Timer(AGAIN, os.kill, (os.getpid(), number))
        later.daemon = True
        later.start()
        return None

    for number in before:
        signal.signal(number, hear)
    try:
        yield
    finally:
        for number, handler in before.items():
            if signal.getsignal(number) is hear:  # a handler may have set another one
                signal.signal(number, handler)


def _in_callback(frame: FrameType | None) -> bool:
    while frame is not None:
        code = frame.f_code
        if code.co_name == "__del__" or code.co_name.startswith("_raw_object_cache"):
            return True
        if os.path.basename(code.co_filename) == "weakref.py":  # noqa: PTH119 - quick
            return True
        frame = frame.f_back
    return False
