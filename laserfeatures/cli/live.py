"""``laserfeatures live``: corners in real time."""

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from laserfeatures.cli import extractor as extractors
from laserfeatures.cli import values
from laserfeatures.cli.live_display import Block, Lines, Tally
from laserfeatures.cli.noises import Noises, noise_option
from laserfeatures.cli.ports import with_query
from laserfeatures.cli.scans import opened
from laserfeatures.drivers.host_clock import now
from laserfeatures.growing_file import GrowingFile
from laserfeatures.records import to_record
from laserfeatures.simulation import Scanner, hallway
from laserfeatures.sources.live import LiveSource

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

STDOUT = "-"

Write = Callable[[dict[str, Any]], None]


@click.command()
@click.argument("port")
@extractors.extractor_options
@noise_option
@click.option("-o", "--output", type=click.Path(), help="Write the features of each scan, as JSON.")
@click.option("--force", is_flag=True, hidden=True, expose_value=False)  # it is the rule by now
@click.option("--seconds", type=values.Quantity("s"), help="How long; else to Ctrl-C.")
@click.option("--reconnect", is_flag=True, help="Wait for a device that is unplugged, and go on.")
def live(
    port: str,
    extractor: str,
    params: tuple[str, ...],
    noise: str,
    output: str | None,
    seconds: float | None,
    reconnect: bool,
) -> None:
    """Show the corners that the rangefinder at PORT sees, as it turns.

    PORT is an address as urg:///dev/ttyACM0, or replay:FILE for a recording. Shown are the rate,
    the latency from a scan's first byte to its features, what was lost, and the nearest corners; in
    a pipe, a line of it each second. --output writes what 'extract' writes, and replaces an older
    file of that name as 'extract' does, but line by line: what is written stays. Ctrl-C ends it, as
    do SIGTERM and a terminal that closes: all of them stop the sweep.

    \b
    Examples:
      laserfeatures live urg:///dev/ttyACM0
      laserfeatures live "lms:///dev/ttyUSB0?baud=38400" -e split_and_merge
      laserfeatures live ld19:///dev/ttyUSB0 --reconnect -o corners.jsonl
      laserfeatures live "replay:run.rec?speed=4"
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    pipeline = extractors.make(extractor, params)
    _warm_up(pipeline, Noises(noise))
    replayed = port.startswith("replay:")
    address = with_query(port, seconds=seconds, reconnect=reconnect and not replayed)
    with _writer(output) as write, opened(address) as source:
        if not isinstance(source, LiveSource):
            raise click.UsageError(
                f"{port} is no port: expected an address as urg:///dev/ttyACM0, or "
                f"replay:{port} if it is a recording; 'extract' reads other logs"
            )
        tally = Tally(source.losses)
        try:
            _run(source, pipeline, Noises(noise), tally, write, _display(output))
        finally:  # the figures of a run that ends with an error count, too
            if tally.scans:
                click.echo(f"laserfeatures: {tally.summary()}", err=True)


def _warm_up(pipeline: "Pipeline", noises: Noises) -> None:
    """Compile everything before the first scan comes."""
    world, path = hallway()
    rng = np.random.default_rng(0)
    scans = [Scanner().scan(world, pose, rng) for pose in path]
    for index, scan in enumerate(noises.told(scans)):
        with extractors.blamed(pipeline, index):
            pipeline(scan, noise=noises.now)


def _run(
    source: LiveSource,
    pipeline: "Pipeline",
    noises: Noises,
    tally: Tally,
    write: Write,
    show: Block | Lines,
) -> None:
    for index, scan in enumerate(noises.told(source)):
        with extractors.blamed(pipeline, index):
            features = pipeline(scan, noise=noises.now)
        tally.add(source.arrival, now())
        write(to_record(features, index))
        show(tally, features)


def _display(output: str | None) -> Block | Lines:
    stream = sys.stderr if output == STDOUT else sys.stdout
    return Block(stream) if stream.isatty() else Lines(stream)


@contextmanager
def _writer(output: str | None) -> Iterator[Write]:
    if output is None:
        yield lambda _record: None
    elif output == STDOUT:
        yield lambda record: click.echo(_line(record))
    else:
        with GrowingFile(output, replace=True) as file:
            yield lambda record: file.write(_line(record).encode() + b"\n")


def _line(record: dict[str, Any]) -> str:
    return json.dumps(record, allow_nan=False)
