"""What the commands that read scans share: the options, the selection, the progress bar."""

import math
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, TypeVar

import click

import laserfeatures as lf
from laserfeatures.cli import values
from laserfeatures.cli.ports import ended_by_ctrl_c, warnings_told
from laserfeatures.errors import shown
from laserfeatures.sources.formats import FORMATS
from laserfeatures.sources.live import LiveSource
from laserfeatures.sources.table import ANGLE_UNITS, DELIMITERS, RANGE_UNITS

if TYPE_CHECKING:
    from laserfeatures.sources import Source

Command = TypeVar("Command", bound=Callable[..., None])

_OPTIONS = (
    click.argument("source", type=click.Path()),
    click.option(
        "--format",
        type=click.Choice(list(FORMATS)),
        metavar="NAME",
        help=f"Its format, else told by the content: {', '.join(FORMATS)}.",
    ),
    click.option("--topic", help="Topic of a bag that has several with laser scans."),
    click.option(
        "--on-error",
        type=click.Choice(["raise", "skip"]),
        default="raise",
        show_default=True,
        help="Stop at a broken record, or skip it and say at the end how many there were. A port's "
        "damaged frames are always skipped.",
    ),
    click.option(
        "--range-max",
        type=values.Quantity("m"),
        metavar="LENGTH",
        help="Range of the sensor, such as 4m: farther returns are dropped. Else the log's own.",
    ),
    click.option(
        "--field-of-view",
        type=values.QuantityOrPair("rad"),
        metavar="ANGLE",
        help="From the first to the last beam, for a log that does not tell: 180deg, or both ends "
        "as -135deg..135deg.",
    ),
    click.option(
        "--columns",
        callback=lambda _ctx, _param, text: text and [name.strip() for name in text.split(",")],
        metavar="NAMES",
        help="Of a table without a header, such as -,angle,range: angle or clockwise, range, scan, "
        "stamp; - for others.",
    ),
    click.option(
        "--angle-unit",
        type=click.Choice(list(ANGLE_UNITS)),
        help="Of a table's angles, if its header does not say.",
    ),
    click.option(
        "--range-unit",
        type=click.Choice(list(RANGE_UNITS)),
        help="Of a table's ranges, if its header does not say.",
    ),
    click.option(
        "--delimiter",
        type=click.Choice(list(DELIMITERS)),
        help="Between a table's cells; else told by its first line.",
    ),
    click.option(
        "--slice",
        "slice_band",
        type=values.Pair("m", ".."),
        metavar="LOW..HIGH",
        help="Heights of a point cloud to scan, such as 0.3m..0.5m.",
    ),
    click.option(
        "--origin",
        "slice_origin",
        type=values.Pair("m", ","),
        metavar="X,Y",
        help="Where the scanner stands in a point cloud, such as 2m,1.5m; else at 0,0.",
    ),
)


def source_options(command: Command) -> Command:
    """Give a command the argument SOURCE and the options that say how to read it."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@contextmanager
def opened(source: str, *, told: bool = True, **options: Any) -> Iterator["Source"]:
    """Open a source with those options; at the end say on standard error what was skipped.

    A port's source ends with the first Ctrl-C as a log ends. The source's notices are on standard
    error, too, unless the command has another place for them (not `told`).

    Raises
    ------
    click.UsageError
        If an option makes no sense.
    SourceError, DriverError
        If it cannot be read.
    """
    with ExitStack() as stack:
        stack.enter_context(warnings_told(notices=told))
        try:
            scans = stack.enter_context(lf.open_source(source, **options))
        except (TypeError, ValueError) as error:
            raise click.UsageError(str(error)) from error
        stack.enter_context(ended_by_ctrl_c(scans))
        yield scans
        if scans.skipped:
            what = "damaged frame" if isinstance(scans, LiveSource) else "broken record"
            click.echo(
                f"laserfeatures: skipped {scans.skipped} {what}{'s' * (scans.skipped > 1)}; "
                f"the first: {shown(scans.first_error or '', 600)}",
                err=True,
            )


def select(
    scans: Iterable[lf.LaserScan], name: str, start: int, count: int | None
) -> Iterator[tuple[int, lf.LaserScan]]:
    """Yield `count` scans from number `start` on, each with its number.

    Raises
    ------
    SourceError
        If there is no scan `start`; the message says how many there are.
    """
    total = 0
    stop = math.inf if count is None else start + count
    for index, scan in enumerate(scans):
        if index >= start:
            yield index, scan
        total = index + 1
        if total >= stop:
            return
    if total <= start:
        raise lf.SourceError(
            f"{name}: there is no scan {start}: "
            + (f"the log has {total}, 0 to {total - 1}" if total else "the log has none")
        )


@contextmanager
def progress(
    items: Iterable[Any], *, length: int | None, to_stdout: bool, label: str = "scans"
) -> Iterator[Iterable[Any]]:
    """Show a bar on a terminal, and nothing in a pipe or where it would cross the output."""
    hidden = not sys.stderr.isatty() or (to_stdout and sys.stdout.isatty())
    with click.progressbar(
        items, length=length, label=label, show_pos=True, hidden=hidden, file=sys.stderr
    ) as bar:
        yield bar
