"""The report of a comparison: what was run, what was measured and how, and pictures."""

from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from laserfeatures.comparison.comparing import Comparison
from laserfeatures.comparison.document import (
    Block,
    Code,
    Document,
    Gallery,
    Heading,
    Paragraph,
)
from laserfeatures.comparison.growth import SAMPLE, growth
from laserfeatures.comparison.machine import machine
from laserfeatures.comparison.pictures import evidence_picture, growth_picture, scan_pictures
from laserfeatures.comparison.tables import (
    agreement_table,
    evidence_table,
    facts_table,
    growth_table,
    result_table,
)
from laserfeatures.comparison.turns import TURN
from laserfeatures.data import LaserScan

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

TIMED = f"""Times are of whole calls, from ranges to corners: each extractor took every scan once,
made anew so that nothing of it was computed yet, in turns of {TURN} scans with the others, in one
process, without garbage collection. The first turn ran twice and counts once, and each later one
began with the scan before it, not counted: neither compiling nor the caches that the others left
behind are in the figures. p99 is the time that one scan of a hundred exceeds."""

COUNTED = """A corner is real where surfaces were seen to reach it. A blind scan is one without a
corner. """

REPEATED = """Found again: of a scan's corners that, moved into the next scan by the log's poses,
lie between its first and last beam and within its range, the share with a corner of the next scan
within {tolerance:g} m. In sight: of those among them that nothing hides, which is to say that a
beam of the next scan passes within {tolerance:g} m of it and measures at least as far, less
{tolerance:g} m. The error of the poses counts against all extractors alike."""

NO_POSES = """No two scans in a row have poses, so it is not known which corners are found again."""

EVIDENT = """From right to left, each point of a curve counts only corners of more evidence, much as
--min-evidence with the number after the sign ≥ leaves them: where a curve climbs,
evidence tells corners that last from those that do not, of two curves the higher is the better one
at as many corners a scan, and an extractor that tells no evidence is a single point."""

EVIDENT_CELLS = """In the table: share found again, of whatever evidence, of the corners in the next
scan's view; of so many corners a scan, with at least so much evidence [nats]. A dash: the same
corners as in the column before, or none at all."""

AGREED = """Share of the corners of the row's extractor that the column's has within
{tolerance:g} m in the same scan, over all scans. It tells who goes with whom, not who is right."""

GREW = f"""Median times on every 8th, 4th and 2nd beam and on all of them, of {{scans}} scans spread
over the log (at most {SAMPLE}), taken as above. A dash: the extractor does not work on so few."""

DRAWN = """Scan {number} in the sensor's frame, without its farthest returns. Points are black,
segments thick and light blue, the lines they lie on thin and blue; lines that the filter removed
are grey and dashed. Corners are squares with their 95 % ellipse, filled where real and hollow where
virtual. The sensor is the red triangle."""


def report(
    comparison: Comparison,
    extractors: Mapping[str, "Pipeline"],
    scans: Sequence[LaserScan],
    *,
    source: Mapping[str, str],
    start: int = 0,
    shown: int | None = None,
) -> Document:
    """Return the report of a comparison; for that, measure how times grow with the beams.

    Parameters
    ----------
    comparison : Comparison
        What `compare` returned.
    extractors : mapping of str to Pipeline
        What it compared; those that failed may be missing.
    scans : sequence of LaserScan
        The scans it compared them on.
    source : mapping of str to str
        What to say about the scans: "source", their name, and whatever else.
    start : int
        Number of the first scan in the log.
    shown : int, optional
        Number of the scan to draw; the middle one if left out.

    Raises
    ------
    IndexError
        If there is no scan `shown`.
    MissingDependencyError
        If matplotlib is not installed.
    """
    able = {name: extractors[name] for name in comparison.runs}
    number = start + len(scans) // 2 if shown is None else shown
    if not 0 <= number - start < len(scans):
        raise IndexError(
            f"there is no scan {number} to draw, only {start} to {start + len(scans) - 1}"
        )
    blocks = [
        *_measured(comparison),
        *_grown(able, scans),
        Heading("The same scan, seen by each"),
        Paragraph(_flat(DRAWN.format(number=number))),
        Gallery(
            scan_pictures(
                able, scans[number - start], number, noise=comparison.noises[number - start]
            )
        ),
        Heading("What was run"),
        facts_table({**source, **machine(), "date": f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"}),
        *(Code(name, repr(extractor)) for name, extractor in extractors.items()),
    ]
    return Document(f"Extractors compared on {source['source']}", blocks)


def _measured(comparison: Comparison) -> Iterator[Block]:
    tolerance = comparison.tolerance
    yield Heading("Measured")
    yield result_table(comparison)
    yield Paragraph(_flat(TIMED))
    repeated = REPEATED if comparison.posed else NO_POSES
    yield Paragraph(_flat(COUNTED + repeated.format(tolerance=tolerance)))
    if comparison.posed:
        yield Heading("Corners found again by evidence")
        yield Gallery([evidence_picture(comparison.evidence)])
        yield Paragraph(_flat(EVIDENT))
        yield evidence_table(comparison)
        yield Paragraph(_flat(EVIDENT_CELLS))
    yield Heading("Agreement")
    yield agreement_table(comparison)
    yield Paragraph(_flat(AGREED.format(tolerance=tolerance)))


def _grown(extractors: Mapping[str, "Pipeline"], scans: Sequence[LaserScan]) -> Iterator[Block]:
    found = growth(extractors, scans)
    yield Heading("Time over beams")
    yield Gallery([growth_picture(found)])
    yield growth_table(found)
    yield Paragraph(_flat(GREW.format(scans=found.scans)))


def _flat(text: str) -> str:
    return " ".join(text.split())
