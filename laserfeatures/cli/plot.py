"""``laserfeatures plot``: a picture of one scan."""

from pathlib import PurePath
from typing import Any

import click

from laserfeatures import figures
from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.extract import Tally
from laserfeatures.cli.noises import Noises, noise_option
from laserfeatures.cli.output import complete_file, tell_written
from laserfeatures.cli.scans import opened, select, source_options
from laserfeatures.cli.selection import selected, selection_options
from laserfeatures.records import to_record


@click.command()
@source_options
@extractors.extractor_options
@noise_option
@selection_options
@click.option(
    "--scan", type=click.IntRange(min=0), required=True, metavar="N", help="Its number, from 0."
)
@click.option("-o", "--output", type=click.Path(), required=True, help="Picture: .png, .pdf, ..")
@click.option("--accumulator", is_flag=True, help="Draw the votes over theta and d beside it.")
def plot(
    source: str,
    extractor: str,
    params: tuple[str, ...],
    noise: str,
    real_only: bool,
    max_sigma: float | None,
    min_evidence: float | None,
    scan: int,
    output: str,
    accumulator: bool,
    **reading: Any,
) -> None:
    """Draw scan N of SOURCE with its lines, segments and corners.

    Points are black, lines that the filter removed grey and dashed, kept lines blue, thick where
    points support them. Corners are squares: filled where real (both lines have a segment that
    reaches them), hollow where virtual, with their 95 % ellipse. The sensor is a red triangle.
    Axes are in metres in the sensor's frame.

    \b
    Examples:
      laserfeatures plot example:clutter --scan 20 -o scan.png
      laserfeatures plot example:clutter --scan 20 --real-only --min-evidence 15 -o sure.png
      laserfeatures plot run.log.gz --scan 0 --accumulator -o votes.pdf
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    try:
        ending = figures.picture_format(output)
    except ValueError as error:
        raise click.UsageError(f"-o: {error}") from error
    pipeline = selected(extractors.make(extractor, params), real_only, max_sigma, min_evidence)
    noises = Noises(noise)
    with complete_file(output, source, binary=True) as file:
        with opened(source, **reading) as scans:
            index, chosen = next(select(noises.told(scans), source, scan, 1))
        votes = figures.accumulator_of(pipeline, chosen) if accumulator else None
        with extractors.blamed(pipeline, index):
            features = pipeline(chosen, noise=noises.now)
            removed = figures.removed_lines(pipeline, features, noise=noises.now)
        figure = figures.scan_figure(
            features,
            removed=removed,
            accumulator=votes,
            title=f"{PurePath(source).name}, scan {index}, {extractor}",
        )
        figures.save(figure, file, ending)
    tally = Tally()
    tally.add(to_record(features, index))
    tell_written(f"scan {index} with {tally.found}", output)
