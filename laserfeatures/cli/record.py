"""``laserfeatures record``: what goes over a port, and the scans, in one file."""

import click

from laserfeatures.cli import values
from laserfeatures.cli.ports import ended_by_ctrl_c, warnings_told, with_query
from laserfeatures.cli.scans import progress
from laserfeatures.drivers.host_clock import now
from laserfeatures.drivers.recorder import Recorder
from laserfeatures.growing_file import GrowingFile
from laserfeatures.sources.port import PortSource, driver_of


@click.command()
@click.argument("port")
@click.option("-o", "--output", type=click.Path(), required=True, help="File to write.")
@click.option("--seconds", type=values.Quantity("s"), help="How long; else to Ctrl-C.")
@click.option("--scans", type=click.IntRange(min=1), metavar="N", help="How many; else to Ctrl-C.")
@click.option("--reconnect", is_flag=True, help="Wait for a device that is unplugged, and go on.")
@click.option("--force", is_flag=True, help="Replace FILE if it is there already.")
def record(
    port: str, output: str, seconds: float | None, scans: int | None, reconnect: bool, force: bool
) -> None:
    """Record the bytes that go over PORT, with their times, and the scans.

    PORT is an address as urg:///dev/ttyACM0. The recording is a source as any log, read through the
    same decoder as the port; replay:FILE plays it in its own time.

    FILE grows line by line. What is written stays, also after Ctrl-C, SIGTERM or a terminal that
    closes, which end the recording, or after a loss of power, which takes a second of it at most.
    As it cannot be made again, an older one is replaced with --force only.

    \b
    Examples:
      laserfeatures record urg:///dev/ttyACM0 -o run.rec
      laserfeatures record "lms:///dev/ttyUSB0?baud=38400" -o run.rec --seconds 60
      laserfeatures extract run.rec -o features.jsonl
      laserfeatures live "replay:run.rec?speed=2"
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    address = with_query(port, seconds=seconds, scans=scans, reconnect=reconnect)
    driver, limits = driver_of(address)
    with (
        warnings_told(),
        GrowingFile(output, replace=force) as file,
        Recorder(file, driver) as recorder,
        PortSource(driver, limits, name=port) as source,
        ended_by_ctrl_c(source),
        progress(source, length=scans, to_stdout=False) as bar,
    ):
        began = now()
        for scan in bar:
            recorder.add(scan)
        took = now() - began
    click.echo(
        f"laserfeatures: {recorder.scans} scans in {took:.1f} s, {file.size / 1000:.0f} kB in "
        f"{output}; lost: {driver.losses}",
        err=True,
    )
