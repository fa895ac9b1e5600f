"""The results of the testbench as pages with their pictures, and as tables of plain figures."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from laserfeatures.comparison.document import (
    Block,
    Document,
    Gallery,
    Heading,
    Paragraph,
    Picture,
    Table,
)
from laserfeatures.comparison.machine import machine
from laserfeatures.comparison.tables import facts_table
from laserfeatures.comparison.to_markdown import to_markdown
from laserfeatures.testbench import noise, table1
from laserfeatures.testbench.neighborhoods import SCENES, Panel, of_figure
from laserfeatures.testbench.output import Row, cell, to_csv, to_table
from laserfeatures.testbench.pictures import neighborhood_png, noise_png
from laserfeatures.testbench.trends import trends

TABLE1 = """{scans} simulated scans of the paper's sensor (181 beams over 180 degrees, 10 m, 5 mm),
drawn with seed {seed}. They have {real_lines} true lines and {real_features} true corners; the
paper's 250 have 1700 and 2950. Each figure stands before the paper's own, in brackets. A corner
counts as found within 0.2 m, one to one. Filtered lines are those that pass the filter. Times are
medians of a scan; the paper's are of MATLAB on a laptop of 2010."""

RESOLUTION = """The resolution of the first block is cut off in our copy of the paper; its times fit
1 degree, 2 cm."""

TRENDS = """The change of the percentages from one window to the next larger one, in the paper and
in ours, and which of the two go the same way."""

REASONS = """True lines: weak are those with fewer beams than the threshold of the peaks
asks for (Eq. 2), shadowed those that are not, but lie in the window of a true line with more beams.
Lines before and after the filter: true if half of their points are on one wall, copies if another
line is on that wall already, false otherwise. False corners: shallow are crossings at less than
15 degrees, which the truth does not count; stray are those of a copy or a false line; off are those
of two true lines, more than 0.2 m from where these cross. Grid: TP and FP in the same worlds and
places with headings at multiples of 30 degrees, so that walls lie on the grid of theta."""

DEFAULTS = """The same scans with this project's defaults, and the oracle: the crossings of
least-squares lines through exactly the beams of each wall. Nobody is told the noise."""

MORE = """Share of the oracle: of its F1. Errors are those of corners found, lines those with half
of their points on a wall of their own. Consistent: share inside the own 95 % ellipse, of corners
and of lines."""

NOISE = """{scans} scans for each setting, of worlds like those of table 1, seed {seed}; the sensor
is the paper's but for what is varied. Nobody is told the noise. The paper's literal algorithm is
the preset "paper" of direct_hough: 1 degree, 2 cm, a window of 11 x 21 cells."""

SIZES = """One scan of the simulated hallway each, at {theta:g} degree and {d:g} cm, with a small, a
middle and a large neighbourhood. Black points are raw measurements, grey lines those that the
filter removed, blue lines those that passed, grey circles all true features, blue squares those
detected; the red triangle is the laser."""


@dataclass(frozen=True)
class Page:
    """A page and what goes with it.

    Parameters
    ----------
    name : str
        Name of its file, without ending.
    document : Document
        Its content.
    figures : mapping of str to sequence of mappings
        Tables of plain figures by the name of their file, without ending.
    """

    name: str
    document: Document
    figures: Mapping[str, Sequence[Row]]

    @property
    def files(self) -> dict[str, bytes]:
        """Content of all files, by name; pictures and figures come before the page."""
        files = {f"{picture.name}.png": picture.png for picture in self.document.pictures}
        files |= {f"{name}.csv": to_csv(rows).encode() for name, rows in self.figures.items()}
        page = to_markdown(self.document, lambda picture: f"{picture.name}.png")
        return files | {f"{self.name}.md": page.encode()}


def table1_page(result: table1.Table1Result) -> Page:
    """Return the page of Table I."""
    counted = ["extractor", *table1.FIGURES]
    blocks: list[Block] = [
        paragraph(TABLE1.format(**vars(result))),
        _beside_the_paper(result.rows),
        paragraph(RESOLUTION),
        Heading("Larger neighbourhoods"),
        paragraph(TRENDS),
        table_of(trends(result.rows), text=3),
        Heading("Why it comes out so"),
        paragraph(REASONS),
        table_of(result.reasons),
        Heading("With this project's defaults"),
        paragraph(DEFAULTS),
        table_of([{key: row[key] for key in counted} for row in result.defaults]),
        table_of([_in_units(row) for row in result.defaults]),
        paragraph(MORE),
        Heading("Measured on"),
        facts_table(machine()),
    ]
    figures = {
        "table1": result.rows,
        "table1_trends": trends(result.rows),
        "table1_reasons": result.reasons,
        "table1_defaults": result.defaults,
    }
    return Page("table1", Document("Table I of the paper, run again", blocks), figures)


def noise_page(result: noise.NoiseResult) -> Page:
    """Return the page of the noise.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    png = noise_png(result.rows)
    alt = "True positives, false positives and errors over noise, beams and outliers"
    blocks: list[Block] = [
        paragraph(NOISE.format(scans=result.scans, seed=result.seed)),
        Gallery([Picture("noise", "", alt, png)]),
    ]
    for axis in noise.AXES:
        rows = [row for row in result.rows if row["axis"] == axis.name]
        blocks.append(Heading(f"Over {axis.label}"))
        blocks.append(_over(rows, axis))
    blocks.append(paragraph("TP [%] / FP [%] / median error of corners [mm]."))
    return Page("noise", Document("Noise, beams, outliers", blocks), {"noise": result.rows})


def figures_page(panels: Sequence[Panel]) -> Page:
    """Return the page of the paper's Figs. 6 and 7.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    row = panels[0].row
    pictures = [
        Picture(
            name,
            f"Fig. {name[-1]}",
            f"A scan at three sizes of the neighbourhood, as the paper's Fig. {name[-1]}",
            neighborhood_png(of_figure(panels, name)),
        )
        for name in SCENES
    ]
    blocks: list[Block] = [
        paragraph(SIZES.format(theta=row.dtheta_deg, d=row.dd_cm)),
        *(Gallery([picture]) for picture in pictures),
        table_of([panel.counts for panel in panels]),
    ]
    counts = [panel.counts for panel in panels]
    return Page("figures", Document("Figs. 6 and 7 of the paper", blocks), {"figures": counts})


def _beside_the_paper(rows: Sequence[Row]) -> Table:
    header = [
        "Δθ [deg]", "Δd [cm]", "window", "lines detected", "filtered", "corners matched",
        "extracted", "TP [%]", "FP [%]", "time [ms]",
    ]  # fmt: skip
    cells = [
        [
            f"{row['theta_step']:g}",
            f"{row['distance_step']:g}",
            "{} x {}".format(*row["neighborhood"]),
        ]
        + [f"{cell(row[key], key)} ({row['paper'][key]})" for key in table1.FIGURES]
        for row in rows
    ]
    return Table(header, cells, frozenset({2}))


def _in_units(row: Row) -> dict[str, Any]:
    """Return what is told of an extractor beside the paper's figures, in handy units."""
    return {
        "extractor": row["extractor"],
        "F1": row["f1"],
        "share of the oracle": row["oracle_share"],
        "blind scans": row["blind_scans"],
        "median error [mm]": 1e3 * row["median_error"],
        "rms error [mm]": 1e3 * row["rms_error"],
        "line recall": row["line_recall"],
        "line precision": row["line_precision"],
        "duplicates": row["duplicates"],
        "corners consistent": row["corner_consistency"],
        "lines consistent": row["line_consistency"],
        "virtual as real": row["confusion"][0][1],
        "real as virtual": row["confusion"][1][0],
    }


def _over(rows: Sequence[Row], axis: noise.Axis) -> Table:
    names = list(dict.fromkeys(row["extractor"] for row in rows))
    header = [axis.name.replace("_", " "), *names]
    cells = []
    for value in axis.values:
        at = {row["extractor"]: row for row in rows if row["value"] == value}
        cells.append([f"{value:g}", *(_three(at[name]) for name in names)])
    return Table(header, cells)


def _three(row: Row) -> str:
    error = 1e3 * row["median_error"]
    return " / ".join(f"{part:.1f}" for part in (row["tp_percent"], row["fp_percent"], error))


def table_of(rows: Sequence[Row], text: int = 1) -> Table:
    """Return rows as a table, with headings for a reader in place of their keys."""
    table = to_table(rows, text)
    return Table([heading(name) for name in table.header], table.rows, table.text)


def heading(name: str) -> str:
    """Return what stands above the figures that go by a name."""
    words = name.replace("_percent", " [%]").replace("_ms", " [ms]").replace("_error", "_error [m]")
    words = re.sub(r"(?<![a-z])(tp|fp|f1)(?![a-z])", lambda found: found[0].upper(), words)
    return words.replace("_", " ")


def paragraph(text: str) -> Paragraph:
    """Return text as a paragraph, its lines joined."""
    return Paragraph(" ".join(text.split()))
