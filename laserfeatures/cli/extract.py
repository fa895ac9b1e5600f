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
from laserfeatures.cli.output import STDOUT, complete_file, counted, tell_written
from laserfeatures.cli.scans import opened, progress, select, source_options
from laserfeatures.cli.selection import selected, selection_options
from laserfeatures.records import COLUMNS, to_record, to_rows

CORNERS = "corners"

Write = Callable[[dict[str, Any]], None]


@click.command()
@source_options
@extractors.extractor_options
@noise_option
@selection_options
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
@click.option(
    "--rows",
    type=click.Choice(list(COLUMNS)),
    help="What the rows of a table are; else corners.",
)
def extract(
    source: str,
    extractor: str,
    params: tuple[str, ...],
    noise: str,
    real_only: bool,
    max_sigma: float | None,
    min_evidence: float | None,
    start: int,
    count: int | None,
    output: str,
    rows: str | None,
    **reading: Any,
) -> None:
    """Write the lines, segments and corners of each scan in SOURCE.

    SOURCE is a log, a bag or a folder of one, a port as urg:///dev/ttyACM0 (until Ctrl-C, which
    leaves the file complete), a point cloud with --slice, or example:hallway, example:office or
    example:clutter, which need no file. One JSON object a scan and line, in metres, radians and
    seconds, in the sensor's frame:

    \b
    {"index": 0, "stamp": 12.5,
     "lines": [{"theta": .., "d": .., "support": .., "evidence": ..}],
     "segments": [{"line": .., "x1": .., "y1": .., "x2": .., "y2": .., "support": .., "rms": ..}],
     "corners": [{"x": .., "y": .., "lines": [i, j], "angle": .., "real": .., "cov": [[..], [..]],
                  "evidence": ..}]}

    A corner is real where both of its lines have a segment that reaches it. The evidence of a line
    says by how much the scan is likelier with it [nats], a corner's how much likelier it is at its
    place than anywhere in view, and the logarithms of its lines', that of the surer one half; 0
    where the extractor tells none. A file is complete or absent: it takes its name when all scans
    are done, and replaces an older file of that name.

    \b
    A name that ends in .csv makes a table of corners, or of what --rows says: a header, then a row
    for each. These are its columns, after index and stamp of the scan and the id in it, from 0:
      corners   x, y, line_1, line_2, angle, real, cov_xx, cov_xy, cov_yy, evidence
      segments  line, x1, y1, x2, y2, support, rms
      lines     theta, d, support, evidence
    line, line_1 and line_2 are ids of lines in the same scan. What is not known is left empty.

    \b
    Examples:
      laserfeatures extract example:hallway -o features.jsonl
      laserfeatures extract example:hallway --rows segments -o segments.csv
      laserfeatures extract run.bag --topic /scan -p theta_step=1deg -o corners.csv
      laserfeatures extract run.log.gz --real-only --min-evidence 15 -o sure.jsonl
      laserfeatures extract run.log.gz --start 100 --count 5 | jq '.corners | length'
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    as_table = PurePath(output).suffix.lower() == ".csv"
    if rows and not as_table:
        raise click.UsageError(f"--rows is for a table: -o must end in .csv, got {output!r}")
    pipeline = selected(extractors.make(extractor, params), real_only, max_sigma, min_evidence)
    noises, tally = Noises(noise), Tally((rows or CORNERS) if as_table else None)
    with (
        _writer(output, source, tally.kind) as write,
        opened(source, **reading) as scans,
        progress(
            select(noises.told(scans), source, start, count),
            length=count,
            to_stdout=output == STDOUT,
        ) as selection,
    ):
        for index, scan in selection:
            with extractors.blamed(pipeline, index):
                features = pipeline(scan, noise=noises.now)
            record = to_record(features, index)
            write(record)
            tally.add(record)
    tell_written(str(tally), output)


class Tally:
    """What has been written so far, of all kinds or of one."""

    def __init__(self, kind: str | None = None) -> None:
        self.kind = kind
        self._scans = self._real = 0
        self._counts = dict.fromkeys(COLUMNS, 0)

    def add(self, record: dict[str, Any]) -> None:
        """Count what a scan has."""
        self._scans += 1
        self._real += sum(corner["real"] for corner in record[CORNERS])
        for kind in self._counts:
            self._counts[kind] += len(record[kind])

    def __str__(self) -> str:
        """Return the counts in words."""
        scans = counted(self._scans, "scan")
        if self.kind:
            return f"{self._words()[self.kind]} of {scans}"
        return f"{scans} with {self.found}"

    @property
    def found(self) -> str:
        """All but the scans, in words."""
        return "{lines}, {segments} and {corners}".format(**self._words())

    def _words(self) -> dict[str, str]:
        words = {kind: counted(n, kind.removesuffix("s")) for kind, n in self._counts.items()}
        words[CORNERS] += f" ({self._real} real)"
        return words


@contextmanager
def _writer(output: str, source: str, rows: str | None) -> Iterator[Write]:
    if output == STDOUT:
        yield _json_writer(sys.stdout)
        return
    with complete_file(output, source) as file:
        yield _csv_writer(file, rows) if rows else _json_writer(file)


def _json_writer(file: IO[str]) -> Write:
    def write(record: dict[str, Any]) -> None:
        file.write(json.dumps(record, allow_nan=False) + "\n")

    return write


def _csv_writer(file: IO[str], kind: str) -> Write:
    table = csv.DictWriter(file, COLUMNS[kind], lineterminator="\n")
    table.writeheader()

    def write(record: dict[str, Any]) -> None:
        table.writerows(to_rows(record, kind))

    return write
