"""``laserfeatures demo``: the extractor at work in a simulated hallway."""

from typing import TYPE_CHECKING

import click
import numpy as np

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.demo_picture import demo_figure
from laserfeatures.cli.output import complete_file
from laserfeatures.cli.scans import progress
from laserfeatures.cli.tour import Visit, tour
from laserfeatures.cli.warm_up import prepared_aside
from laserfeatures.simulation import hallway

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

FAR_OFF = 0.10  # error [m] from which a corner counts as off


@click.command()
@click.option(
    "-o",
    "--output",
    type=click.Path(),
    default="laserfeatures-demo.png",
    show_default=True,
    help="Picture to write.",
)
@extractors.extractor_options
def demo(output: str, extractor: str, params: tuple[str, ...]) -> None:
    """Try the extractor in a simulated hallway, without any data.

    A table is printed and a picture drawn. A simulated SICK LMS200 (181 beams over 180 degrees,
    5 mm noise) scans the hallway from several poses. A corner's error is its distance from the
    nearest crossing of two walls in view.
    """
    with prepared_aside():
        _demo(output, extractors.make(extractor, params))


def _demo(output: str, pipeline: "Pipeline") -> None:
    try:
        ending = figures.picture_format(output)
    except ValueError as error:
        raise click.UsageError(f"-o: {error}") from error
    except lf.MissingDependencyError as error:
        click.echo(f"laserfeatures: no picture is drawn: {error}", err=True)
        print_table(_visit_all(pipeline))
        return
    with complete_file(output, binary=True) as file:
        visits = _visit_all(pipeline)
        print_table(visits)
        figures.save(demo_figure(pipeline, visits), file, ending)
    click.echo(f"The picture is in {output}")


def _visit_all(extractor: "Pipeline") -> list[Visit]:
    world, path = hallway()
    with progress(tour(extractor, world, path), length=len(path), to_stdout=False) as bar:
        return list(bar)


def print_table(visits: list[Visit]) -> None:
    """Print a row for each pose and one for all."""
    click.echo(
        "scan  x [m]  y [m]  heading [deg]  beams  lines  real  virtual  error [mm]  off  time [us]"
    )
    for i, visit in enumerate(visits):
        pose = visit.pose
        click.echo(
            f"{i:4}  {pose.x:5.2f}  {pose.y:5.2f}  {np.degrees(pose.theta):13.1f}  " + _row([visit])
        )
    click.echo(f"{'all':<33}" + _row(visits))
    click.echo(
        "error: median distance of the corners from the nearest crossing of two walls in view; "
        f"off: corners farther than {FAR_OFF * 100:g} cm from any"
    )


def _row(visits: list[Visit]) -> str:
    beams = sum(len(visit.features.scan.points) for visit in visits)
    lines = sum(len(visit.features.lines) for visit in visits)
    real = np.concatenate([visit.features.corners.real for visit in visits])
    errors = np.concatenate([visit.errors for visit in visits])
    median = f"{np.median(errors) * 1000:.1f}" if errors.size else "-"
    off = int((errors > FAR_OFF).sum())
    micros = np.median([visit.seconds for visit in visits]) * 1e6
    return (
        f"{beams:5}  {lines:5}  {real.sum():4}  {(~real).sum():7}  {median:>10}  {off:3}  "
        f"{micros:9.0f}"
    )
