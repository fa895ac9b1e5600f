"""``laserfeatures compare``: extractors on the same scans."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path, PurePath
from typing import IO, TYPE_CHECKING, Any

import click

import laserfeatures as lf
from laserfeatures import figures
from laserfeatures.cli import extractor_list
from laserfeatures.cli.compare_table import print_tables
from laserfeatures.cli.info import Summary
from laserfeatures.cli.noises import LOG, SCAN, Noises, noise_option
from laserfeatures.cli.output import complete_file
from laserfeatures.cli.scans import opened, progress, select, source_options
from laserfeatures.cli.selection import selected, selection_options
from laserfeatures.comparison import Comparison, Failure
from laserfeatures.comparison import compare as compare_extractors
from laserfeatures.comparison.document import Document
from laserfeatures.comparison.report import report
from laserfeatures.comparison.to_html import to_html
from laserfeatures.comparison.to_markdown import to_markdown

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

POSES = {
    "none": "none",
    "odometry": "raw odometry, which drifts and slips",
    "corrected": "corrected by a SLAM program, which is no surveyed truth",
}

NOISES = {
    LOG: "told from the log up to each scan",
    SCAN: "told from each scan alone",
}

Save = Callable[[Document], None]


@click.command()
@source_options
@click.option(
    "--extractors",
    "wanted",
    metavar="A,B,..",
    shell_complete=extractor_list.complete,
    help="Their names, each with its parameters after colons: "
    "ransac,direct_hough:preset=paper:theta_step=2deg. Else all.",
)
@noise_option
@selection_options
@click.option(
    "--start", type=click.IntRange(min=0), default=0, metavar="N", help="First scan, from 0."
)
@click.option("--count", type=click.IntRange(min=1), metavar="N", help="How many scans; else all.")
@click.option(
    "--scan",
    type=click.IntRange(min=0),
    metavar="N",
    help="The scan to draw in the report; else the middle one.",
)
@click.option(
    "-o", "--output", type=click.Path(), help="Report with pictures to write: .md or .html."
)
def compare(
    source: str,
    wanted: str | None,
    noise: str,
    real_only: bool,
    max_sigma: float | None,
    min_evidence: float | None,
    start: int,
    count: int | None,
    scan: int | None,
    output: str | None,
    **reading: Any,
) -> None:
    """Compare extractors on the scans of SOURCE.

    They take turns on the same scans. A table tells of each the time, how many lines and corners it
    finds, how many of a scan's corners the next scan shows again, if the log has poses, and how
    many the other extractors find too. One that raises has that in its row; the others finish.

    A report has besides how many corners are found again the more evidence they must have, how the
    time grows with the beams, one scan as each sees it, and all that is needed to run it again.
    Beside a report.md lie its pictures, report-*.png; a report.html holds them.

    \b
    Examples:
      laserfeatures compare example:office
      laserfeatures compare run.log.gz --extractors ransac,split_and_merge --count 100
      laserfeatures compare run.log.gz --real-only --min-evidence 15
      laserfeatures compare run.log.gz -o report.html --scan 120
    """  # noqa: D301 - click's mark for lines to keep is a backspace
    if scan is not None and output is None:
        raise click.UsageError("--scan says what to draw in a report: it needs -o")
    extractors = {
        name: each
        if isinstance(each, Failure)
        else selected(each, real_only, max_sigma, min_evidence)
        for name, each in extractor_list.make_all(wanted).items()
    }
    with _report_file(output, source) as save:
        scans, noises, facts = _read(source, start, count, noise, **reading)
        if scan is not None and not start <= scan < start + len(scans):
            last = start + len(scans) - 1
            raise click.UsageError(f"--scan {scan} is none of the scans read, {start} to {last}")
        with progress(scans, length=len(scans), to_stdout=False) as bar:
            comparison = compare_extractors(extractors, bar, noises=noises, start=start)
        _check_one_finished(comparison)
        print_tables(comparison, facts["source"], len(scans))
        if save:
            made = {k: each for k, each in extractors.items() if not isinstance(each, Failure)}
            save(report(comparison, made, scans, source=facts, start=start, shown=scan))


def _read(
    source: str, start: int, count: int | None, noise: str, **reading: Any
) -> tuple[list[lf.LaserScan], list["RangeNoise | None"], dict[str, str]]:
    """Return the scans, their noises, and what is to be said about them."""
    told = Noises(noise)
    summary = Summary()
    with opened(source, **reading) as log:
        scans, noises = [], []
        for _, scan in select(told.told(log), source, start, count):
            summary.add(scan)
            scans.append(scan)
            noises.append(told.now)
        facts = {"source": PurePath(source).name, "format": log.format, **dict(summary.rows())}
        facts |= {"first scan": str(start), "poses": POSES[log.poses], "noise": NOISES[noise]}
        return scans, noises, facts


def _check_one_finished(comparison: Comparison) -> None:
    if not comparison.runs:
        name, failure = next(iter(comparison.failures.items()))
        count = len(comparison.failures)
        of = f"none of {count} extractors finished; the first, {name}," if count > 1 else name
        raise lf.PluginError(f"{of} {failure}")


@contextmanager
def _report_file(output: str | None, source: str) -> Iterator[Save | None]:
    """Yield what saves a report as the ending of `output` says, complete or not at all."""
    if output is None:
        yield None
        return
    ending = PurePath(output).suffix.lower()
    if ending not in {".md", ".html"}:
        raise click.UsageError(f"-o: a report's name must end in .md or .html; got {output!r}")
    figures.new_figure()  # says now if there is no matplotlib
    with ExitStack() as files:
        page = files.enter_context(complete_file(output, source))
        if ending == ".html":
            yield lambda document: _write(page, to_html(document))
        else:
            yield lambda document: _save_markdown(document, page, output, files)


def _save_markdown(document: Document, page: IO[str], output: str, files: ExitStack) -> None:
    """Write a report and, beside it, its pictures; they take their names before it takes its."""
    stem = PurePath(output).stem
    for picture in document.pictures:
        path = Path(output).with_name(f"{stem}-{picture.name}.png")
        _write(files.enter_context(complete_file(str(path), binary=True)), picture.png)
    _write(page, to_markdown(document, lambda picture: f"{stem}-{picture.name}.png"))


def _write(file: IO[Any], content: str | bytes) -> None:
    file.write(content)
    file.flush()  # a full disk shows while nothing has its name yet
