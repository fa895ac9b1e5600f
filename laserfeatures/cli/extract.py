"""``laserfeatures extract``: the features of every scan as JSON or CSV."""

import csv
import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import PurePath
from typing import IO, Any

import click

from laserfeatures.cli import extractor as extractors
from laserfeatures.cli.noises import Noises, noise_option
from laserfeatures.cli.output import complete_file
from laserfeatures.cli.scans import opened, progress, select, source_options
from laserfeatures.records import COLUMNS, to_record, to_rows

STDOUT = "-"

Write = Callable[[dict[str, Any]], None]


@click.command()
@source_options
@extractors.extractor_options
@noise_option
@click.option(
    "--start", type=click.IntRange(min=0), default=0, metavar="N", help="First scan, from 0."
)
@click.option("--count", type=click.IntRange(min=1), metavar="N", help="How many scans; else all.")
@click.option(
    "-o",
    "--output",
    type=click.Path(),
    default=STDOUT,
    help="File to write, a table if it ends in .csv; else JSON to standard output.",
)
def extract(
    source: str,
    extractor: str,
    params: tuple[str, ...],
    noise: str,
    start: int,
    count: int | None,
    output: str,
    **reading: Any,
) -> None:
    """Write the lines, segments and corners of each scan in SOURCE.

    SOURCE is a log, a bag or a folder of one, a port as urg:///dev/ttyACM0 (until Ctrl-C, which
    leaves the file complete), or a point cloud with --slice. One JSON object a scan and line, in
    metres, radians and seconds, in the sensor's frame:

    \b
    {"index": 0, "stamp": 12.5,
     "lines": [{"theta": .., "d": .., "support": .., "evidence": ..}],
     "segments": [{"line": .., "x1": .., "y1": .., "x2": .., "y2": .., "support": .., "rms": ..}],
     "corners": [{"x": .., "y": .., "lines": [i, j], "angle": .., "real": .., "cov": [[..], [..]],
                  "evidence": ..}]}

    A corner is real where both of its lines have a segment that reaches it. The evidence of a line
    says by how much the scan is likelier with it [nats], a corner's is that of its weaker line; 0
    where the extractor tells none. A file is complete or absent: it takes its name when all scans
    are done, and replaces an older file of that name.

    \b
    Examples:
      laserfeatures extract run.log.gz -o features.jsonl
      laserfeatures extract run.bag --topic /scan -p theta_step=1deg -o features.csv
      laserfeatures extract run.log.gz -p segment_filter.min_evidence=20 -o sure.jsonl
      laserfeatures extract run.log.gz --start 100 --count 5 | jq '.corners | length'
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    pipeline = extractors.make(extractor, params)
    noises = Noises(noise)
    with (
        _writer(output, source) as write,
        opened(source, **reading) as scans,
        progress(
            select(noises.told(scans), source, start, count),
            length=count,
            to_stdout=output == STDOUT,
        ) as selected,
    ):
        for index, scan in selected:
            with extractors.blamed(pipeline, index):
                features = pipeline(scan, noise=noises.now)
            write(to_record(features, index))


@contextmanager
def _writer(output: str, source: str) -> Iterator[Write]:
    if output == STDOUT:
        yield _json_writer(sys.stdout)
        return
    as_table = PurePath(output).suffix.lower() == ".csv"
    with complete_file(output, source) as file:
        yield _csv_writer(file) if as_table else _json_writer(file)


def _json_writer(file: IO[str]) -> Write:
    def write(record: dict[str, Any]) -> None:
        file.write(json.dumps(record, allow_nan=False) + "\n")

    return write


def _csv_writer(file: IO[str]) -> Write:
    table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
    table.writeheader()

    def write(record: dict[str, Any]) -> None:
        table.writerows(to_rows(record))

    return write
