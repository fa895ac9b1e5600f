"""The figures of a comparison as text, for the terminal and the report alike."""

import math
from collections.abc import Mapping

import numpy as np

from laserfeatures.comparison.comparing import Comparison
from laserfeatures.comparison.document import Table
from laserfeatures.comparison.evidence import KEPT, Curve
from laserfeatures.comparison.growth import Growth
from laserfeatures.comparison.matching import Repeatability, Share
from laserfeatures.comparison.turns import Run

NONE = "-"


def cells(run: Run, again: Repeatability) -> dict[str, str]:
    """Return what was measured of one extractor, by a name short enough for a column."""
    return {
        "median": micros(float(np.median(run.seconds))),
        "p99": micros(float(np.quantile(run.seconds, 0.99))),
        "lines": f"{run.lines.mean():.2f}",
        "corners": f"{run.corner_counts.mean():.2f}",
        "real": f"{run.real_counts.mean():.2f}",
        "blind": str((run.corner_counts == 0).sum()),
        "again": share(again.in_view.value),
        "judged": str(again.in_view.judged or NONE),
        "in sight": share(again.in_sight.value),
    }


def result_table(comparison: Comparison) -> Table:
    """Return one row for each extractor, with what it raised if any did."""
    header = [
        "extractor", "median time [µs]", "p99 [µs]", "lines a scan", "corners a scan",
        "real corners a scan", "blind scans", "found again", "found again, in sight",
    ]  # fmt: skip
    rows = []
    for name, outcome in comparison.outcomes.items():
        row = [name, *[NONE] * (len(header) - 1)]
        if isinstance(outcome, Run):
            again = comparison.repeatability[name]
            shown = cells(outcome, again)
            row[1:7] = [
                shown[key] for key in ("median", "p99", "lines", "corners", "real", "blind")
            ]
            row[7:] = [_of(again.in_view), _of(again.in_sight)]
        if comparison.failures:
            row.append("" if isinstance(outcome, Run) else str(outcome))
        rows.append(row)
    if comparison.failures:
        header.append("error")
    return Table(header, rows, frozenset({0, 9}))


def agreement_rows(comparison: Comparison) -> list[list[str]]:
    """Return the share of each row's corners that each column has, without the diagonal."""
    rows = [[share(value) for value in row] for row in comparison.agreement]
    for i, row in enumerate(rows):
        row[i] = ""
    return rows


def agreement_table(comparison: Comparison) -> Table:
    """Return the share of each row's corners that each column has."""
    names = list(comparison.runs)
    rows = zip(names, agreement_rows(comparison), strict=True)
    return Table(["of the corners of", *names], [[name, *row] for name, row in rows])


def evidence_table(comparison: Comparison) -> Table:
    """Return one row for the real and one for the virtual corners of each extractor."""
    header = ["extractor", "corners", "all", *(f"best {100 * kept:g} %" for kept in KEPT[1:])]
    rows = [
        [name, kind, *_points(curve)]
        for name, curves in comparison.evidence.items()
        for kind, curve in curves.items()
    ]
    return Table(header, rows, frozenset({0, 1}))


def growth_table(found: Growth) -> Table:
    """Return the median time of each extractor over the number of beams."""
    header = ["beams", *(f"{count:g}" for count in found.beams)]
    return Table(header, [[name, *map(micros, row)] for name, row in found.seconds.items()])


def facts_table(facts: Mapping[str, str]) -> Table:
    """Return names and values."""
    return Table(["what", "value"], [list(fact) for fact in facts.items()], frozenset({0, 1}))


def micros(seconds: float) -> str:
    """Return a time in microseconds, three digits at least."""
    if math.isnan(seconds):
        return NONE
    value = 1e6 * seconds
    return f"{value:.1f}" if value < 99.95 else f"{value:.0f}"


def share(value: float) -> str:
    """Return a share between 0 and 1."""
    return NONE if math.isnan(value) else f"{value:.2f}"


def _points(curve: Curve) -> list[str]:
    """Return the points of a curve; a dash where one is that before it, or there is none."""
    texts, before = [], math.nan
    columns = (curve.shares, curve.corners, curve.thresholds)
    for found, corners, least in zip(*columns, strict=True):
        same = math.isnan(least) or least == before
        texts.append(NONE if same else f"{share(found)} of {corners:.2f}, ≥ {least:.3g}")
        before = least
    return texts


def _of(found: Share) -> str:
    return f"{share(found.value)} of {found.judged}" if found.judged else NONE
