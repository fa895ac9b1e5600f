"""``laserfeatures plot``: a picture of one scan."""

from pathlib import PurePath
from typing import Any

import click

from laserfeatures import figures
from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.noises import Noises, noise_option
from laserfeatures.cli.output import complete_file
from laserfeatures.cli.scans import opened, select, source_options


@click.command()
@source_options
@extractors.extractor_options
@noise_option
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
    """
    try:
        ending = figures.picture_format(output)
    except ValueError as error:
        raise click.UsageError(f"-o: {error}") from error
    pipeline = extractors.make(extractor, params)
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
