"""What the device of ``laserfeatures emulate`` sees."""

import math
from collections.abc import Iterator

import click
import numpy as np

import laserfeatures as lf
from laserfeatures.cli import values
from laserfeatures.emulators import Feed, ScansFeed, WorldFeed
from laserfeatures.simulation import Scanner, hallway, read_plan
from laserfeatures.sources.simulated import readings_of

BEAMS = 1440  # a turn, of the scanner that is driven


class Place(click.ParamType[tuple[float, float, float]]):
    """An option's type: x, y [m] and a heading, in degrees unless it has another unit [rad]."""

    name = "place"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, float, float]:
        """Return x, y [m] and heading [rad]."""
        parts = [part.strip() for part in str(value).split(",")]
        if len(parts) != 3:
            self.fail(f"must be X,Y,DEG as in 2m,1.5m,90, got {value!r}", param, ctx)
        heading = parts[2] if parts[2][-1:].isalpha() else f"{parts[2]}deg"
        try:
            x, y = (float(str(values.parse(part, float, "m"))) for part in parts[:2])
            return x, y, float(str(values.parse(heading, float, "rad")))
        except ValueError as error:
            self.fail(str(error), param, ctx)


def make_feed(
    plan_file: str | None, at: tuple[float, float, float] | None, log: str | None, seed: int
) -> Feed:
    """Return what the device sees; it has been tried once.

    Raises
    ------
    click.UsageError
        If the options do not go together, or it cannot stand there.
    LaserFeaturesError
        If the plan or log cannot be read or driven.
    """
    if log is not None:
        if plan_file is not None or at is not None:
            raise click.UsageError("--log is instead of --world and --at")
        return _tried(ScansFeed(lambda: lf.open_source(log)))
    if plan_file is None:
        world, path = hallway()
        place = path[0]
    else:
        plan = read_plan(plan_file)
        world = plan.world
        if at is None and plan.drive is not None:
            return _tried(ScansFeed(lambda: _driven(plan_file)))
        if at is None:
            raise click.UsageError(f"{plan_file} has no way-points: say with --at where it stands")
    if at is not None:
        place = lf.Pose2D(*at)
    try:
        return WorldFeed(world, place, seed=seed)
    except ValueError as error:
        raise click.UsageError(f"--at: {error}") from error


def _driven(plan_file: str) -> Iterator[lf.LaserScan]:
    """Yield the scans of a robot that drives, all round."""
    around = Scanner(
        beams=BEAMS, field_of_view=math.tau * (1 - 1 / BEAMS), range_max=30.0, range_sigma=0.01
    )
    return (reading.scan for reading in readings_of(plan_file, scanner=around))


def _tried(feed: ScansFeed) -> Feed:
    feed(np.zeros(1))
    return feed
