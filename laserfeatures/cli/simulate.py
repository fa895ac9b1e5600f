"""``laserfeatures simulate``: a log of a simulated robot."""

import math
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO

import click

import laserfeatures as lf
from laserfeatures.cli.output import STDOUT, complete_file, counted, tell_written
from laserfeatures.cli.scans import progress
from laserfeatures.simulation import Scanner
from laserfeatures.simulation.robot import Reading
from laserfeatures.sources.carmen_writer import write_carmen
from laserfeatures.sources.simulated import readings_of


@click.command()
@click.argument("plan", type=click.Path())
@click.option(
    "-o",
    "--output",
    type=click.Path(),
    default=STDOUT,
    help="CARMEN log to write; else standard output.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    metavar="N",
    help="Of the noise, the wheels and the floor; else the plan's.",
)
@click.option(
    "--scanner",
    type=click.Choice(sorted(Scanner.MODELS)),
    help="The rangefinder; else the plan's.",
)
def simulate(plan: str, output: str, seed: int | None, scanner: str | None) -> None:
    """Drive a robot as PLAN says and write a CARMEN log.

    PLAN is a TOML file with a world and a table [drive] with way-points. A small robot with two
    wheels drives past them in MuJoCo, and scans on the way. Its wheels slip and are not quite of
    the size that its odometry takes them for. The log has the true pose of the laser where
    recorded logs have the corrected one, and the odometry beside it.

    PLAN itself is a source as any log: the other commands drive the robot while they read.

    \b
    Examples:
      laserfeatures simulate office.toml -o office.log
      laserfeatures simulate office.toml --seed 7 --scanner urg04lx_ug01 -o office7.log
      laserfeatures extract office.toml -o corners.jsonl
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    carried = Scanner.model(scanner) if scanner else None
    tally = Tally()
    with (
        _file(output, plan) as file,
        progress(
            readings_of(plan, seed=seed, scanner=carried), length=None, to_stdout=output == STDOUT
        ) as readings,
    ):
        try:
            write_carmen(file, tally.told(readings))
        except ValueError as error:  # a scanner whose ranges such a log cannot hold
            raise lf.SourceError(f"{plan}: {error}") from error
    tell_written(str(tally), output)


@dataclass
class Tally:
    """What the robot has done so far."""

    scans: int = 0
    way: float = 0.0
    last: Reading | None = None

    def told(self, readings: Iterable[Reading]) -> Iterator[Reading]:
        """Yield readings and count them."""
        for reading in readings:
            self.scans += 1
            if self.last:
                before, after = self.last.truth, reading.truth
                self.way += math.dist((before.x, before.y), (after.x, after.y))
            self.last = reading
            yield reading

    def __str__(self) -> str:
        """Return the counts in words."""
        seconds = self.last.scan.stamp if self.last else 0.0
        return f"{counted(self.scans, 'scan')} along {self.way:.1f} m in {seconds:.1f} s"


@contextmanager
def _file(output: str, plan: str) -> Iterator[IO[str]]:
    if output == STDOUT:
        yield sys.stdout
        return
    with complete_file(output, plan) as file:
        yield file
