"""What the commands that read ports share: Ctrl-C as the end, and what drivers have to say."""

import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING
from urllib.parse import urlencode

import click

from laserfeatures.cli.group import ENDING, ended_by, ignore_further
from laserfeatures.errors import shown
from laserfeatures.sources.live import LiveSource
from laserfeatures.sources.log import LOGGER

if TYPE_CHECKING:
    from laserfeatures.sources import Source


NOTICES = LOGGER.name


@contextmanager
def ended_by_ctrl_c(source: "Source") -> Iterator[None]:
    """Let the first Ctrl-C end a port's scans as a log ends; the second one interrupts.

    SIGTERM and SIGHUP do the same, and are the command's exit status. The source's time limit ends
    it, too, while no scan comes.
    """
    if not isinstance(source, LiveSource):
        yield
        return
    before = {number: signal.getsignal(number) for number in ENDING}

    def end(number: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGINT, before[signal.SIGINT])
        if number in {signal.SIGTERM, signal.SIGHUP}:
            ended_by.append(signal.Signals(number))
            ignore_further(number)
        source.interrupt()

    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, end)
    alarm = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, source.time_left or 0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, alarm)
        for number, handler in before.items():
            if signal.getsignal(number) is end:  # not ignored by now: the port is closed next
                signal.signal(number, handler)


class _Teller(logging.Handler):
    """Says warnings on standard error, the same one once."""

    last = ""

    def __init__(self, *, notices: bool) -> None:
        super().__init__(logging.WARNING)
        self._notices = notices

    def emit(self, record: logging.LogRecord) -> None:
        """Say it."""
        if record.name == NOTICES and not self._notices:
            return
        text = shown(record.getMessage())
        if text != self.last:
            self.last = text
            click.echo(f"laserfeatures: {text}", err=True)


@contextmanager
def warnings_told(*, notices: bool = True) -> Iterator[None]:
    """Say on standard error what is warned of, such as a device that is waited for.

    What is to be known of a log only if `notices`.
    """
    logger = logging.getLogger("laserfeatures")
    teller = _Teller(notices=notices)
    propagate = logger.propagate
    logger.addHandler(teller)
    logger.propagate = False
    try:
        yield
    finally:
        logger.propagate = propagate
        logger.removeHandler(teller)


def with_query(address: str, **values: object) -> str:
    """Return an address with more in its query, without what is None or False."""
    given = {
        name: int(value) if value is True else value
        for name, value in values.items()
        if value is not None and value is not False
    }
    mark = "&" if "?" in address else "?"
    return f"{address}{mark}{urlencode(given)}" if given else address
