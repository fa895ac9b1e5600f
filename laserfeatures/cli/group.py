"""The command group: how every command ends."""

import errno
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
INTERRUPTED = 130  # as a shell reports Ctrl-C


class CommandGroup(click.Group):
    """A group whose commands end with one line on standard error, never with a traceback.

    Whatever is wrong with arguments, input or a plugin ends with exit status 2, Ctrl-C with 130. A
    reader that closes the pipe early, such as ``head``, has what it wanted: that is no error.
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
        try:
            with _terminated_cleanly():
                status = super().main(args, prog_name, complete_var, standalone_mode=False, **extra)
        except click.exceptions.NoArgsIsHelpError as error:
            error.show()
            sys.exit(BAD_INPUT)
        except click.UsageError as error:
            command = error.ctx.command_path if error.ctx else NAME
            _fail(f"{error.format_message()} (see '{command} --help')")
        except click.ClickException as error:
            _fail(error.format_message())
        except click.Abort:
            _say("interrupted")
            sys.exit(INTERRUPTED)
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
            name = error.filename or ("standard output" if error.errno == errno.ENOSPC else "")
            where = f"{name}: " if name else ""
            raise click.ClickException(f"{where}{error.strerror or error}") from error
        return result


def _fail(message: str) -> NoReturn:
    _say(f"error: {shown(message, LONGEST)}")
    sys.exit(BAD_INPUT)


def _say(message: str) -> None:
    with suppress(BrokenPipeError):
        click.echo(f"{NAME}: {message}", err=True)


def _discard_output() -> None:
    """Send what is still buffered nowhere, so that the interpreter's own flush does not fail."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def _terminated_cleanly() -> Iterator[None]:
    """Let SIGTERM unwind the stack, so that half-written files are removed."""

    def leave(number: int, _frame: FrameType | None) -> NoReturn:
        sys.exit(128 + number)

    before = signal.signal(signal.SIGTERM, leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
