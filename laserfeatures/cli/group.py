"""The command group: how every command ends."""

import errno
import logging
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, NoReturn

import click

from laserfeatures.errors import LaserFeaturesError, shown

NAME = "laserfeatures"
LONGEST = 900  # characters of a message
BAD_INPUT = 2
BY_SIGNAL = 128  # and the signal's number, as a shell reports it: 130 is Ctrl-C
ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

# What ends this command although it goes on for a moment to end as it should.
ended_by: list[signal.Signals] = []


class CommandGroup(click.Group):
    """A group whose commands end with one line on standard error, never with a traceback.

    Whatever is wrong with arguments, input or a plugin ends with exit status 2, Ctrl-C with 130,
    SIGTERM with 143, SIGHUP with 129. A reader that closes the pipe early, such as ``head``, has
    what it wanted: that is no error.
    """

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = NAME,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run the command line and leave with its exit status."""
        if not standalone_mode:
            return super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
        _open_streams()
        try:
            with _ended_by_signals(), _compiling_told():
                status = super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            status = BAD_INPUT
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else NAME
            status = _failed(f"{error.format_message()} (see '{command} --help')")
        except click.ClickException as error:
            status = _failed(error.format_message())
        except (click.Abort, KeyboardInterrupt):
            _say("interrupted")
            status = BY_SIGNAL + signal.SIGINT
        except OSError as error:  # of --help and --version, which are no command
            status = _failed(_told(error))
        finally:
            _flush()
        if ended_by:
            status = BY_SIGNAL + ended_by[0]
        sys.exit(status if isinstance(status, int) else 0)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a subcommand and turn what it raises into one line."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except LaserFeaturesError as error:
            raise click.ClickException(str(error)) from error
        except OSError as error:
            if error.errno == errno.EPIPE:
                _discard_output()
                ctx.exit(0)
            raise click.ClickException(_told(error)) from error
        except SystemExit as error:
            if isinstance(error, _EndedBySignal):
                raise
            text = f"a plugin ended the program: SystemExit: {error}"
            raise click.ClickException(text) from error
        return result


class _EndedBySignal(SystemExit):
    """A signal ends the command."""


def _told(error: OSError) -> str:
    if error.filename is None and error.errno == errno.EBADF:
        return "standard output is closed"
    name = error.filename or ("standard output" if error.errno == errno.ENOSPC else "")
    where = f"{name}: " if name else ""
    return f"{where}{error.strerror or error}"


def _failed(message: str) -> int:
    _say(f"error: {shown(message, LONGEST)}")
    return BAD_INPUT


def _say(message: str) -> None:
    with suppress(OSError):  # a terminal that is gone
        click.echo(f"{NAME}: {message}", err=True)


def _flush() -> None:
    try:
        sys.stdout.flush()
    except OSError:
        _discard_output()


def _open_streams() -> None:
    """Open those of the standard streams that are closed, as by ``>&-``.

    Else the next file that is opened would get a standard stream's number. What is written to
    standard output then is an error, as it is to other programs.
    """
    for name, flags in (("stdin", os.O_RDONLY), ("stdout", os.O_RDONLY), ("stderr", os.O_WRONLY)):
        if getattr(sys, name) is None:
            descriptor = os.open(os.devnull, flags)
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(descriptor, mode, closefd=False, encoding="utf-8"))  # noqa: SIM115 - open to the end


def _discard_output() -> None:
    """Send what is still buffered nowhere, so that the interpreter's own flush does not fail."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class _Teller(logging.Handler):
    """Says what is logged."""

    def emit(self, record: logging.LogRecord) -> None:
        """Say it."""
        _say(record.getMessage())


@contextmanager
def _compiling_told() -> Iterator[None]:
    """Say that code cannot be kept, and on a terminal that it is compiled: it takes long."""
    logger = logging.getLogger("laserfeatures.compiled")
    level, propagate, teller = logger.level, logger.propagate, _Teller()
    logger.setLevel(logging.INFO if sys.stderr.isatty() else logging.WARNING)
    logger.propagate = False
    logger.addHandler(teller)
    try:
        yield
    finally:
        logger.removeHandler(teller)
        logger.setLevel(level)
        logger.propagate = propagate


@contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Let signals unwind the stack, so that half-written files are removed and lasers turned off.

    Ctrl-C does also where a shell has it ignored, as it has for what a script starts with ``&``;
    ``nohup`` is heeded. A terminal that closes may send SIGHUP twice: only Ctrl-C hurries an end.
    """
    came: list[signal.Signals] = []

    def leave(number: int, _frame: FrameType | None) -> NoReturn:
        came.append(signal.Signals(number))
        ignore_further(number)
        raise _ended(came[0])

    ended_by.clear()
    before = {each: signal.getsignal(each) for each in ENDING}
    for each in ENDING:
        if each != signal.SIGHUP or before[each] is not signal.SIG_IGN:
            signal.signal(each, leave)
    try:
        yield
    except Exception as error:
        if came:  # whatever has become of it on its way
            raise _ended(came[0]) from error
        raise
    else:
        if came and came[0] != signal.SIGINT:  # it was taken for a plugin's own end
            raise _ended(came[0])
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def ignore_further(number: int) -> None:
    """Ignore SIGTERM and SIGHUP once one of them came; only Ctrl-C hurries the end."""
    if number != signal.SIGINT:
        for each in ENDING[1:]:
            signal.signal(each, signal.SIG_IGN)


def _ended(number: signal.Signals) -> BaseException:
    return KeyboardInterrupt() if number == signal.SIGINT else _EndedBySignal(BY_SIGNAL + number)
