"""The page of Table II."""

from collections.abc import Sequence

from laserfeatures.comparison.document import Block, Document, Gallery, Heading, Picture, Table
from laserfeatures.comparison.machine import machine
from laserfeatures.comparison.tables import facts_table
from laserfeatures.testbench.output import Row, cell, to_table
from laserfeatures.testbench.pages import Page, paragraph, table_of
from laserfeatures.testbench.real.map_picture import map_png
from laserfeatures.testbench.table2 import Table2Result

SHOWN_MAPS = ("csail", "belgioioso")
SHARED = (
    "blind_scans", "real_features", "features_matched", "features_extracted", "tp_percent",
    "fp_percent",
)  # fmt: skip
TOLD = (
    *SHARED, "needlessly_blind", "features_judged", "fp_judged_percent", "f1_judged",
    "median_error", "time_ms",
)  # fmt: skip

ARENA = """All scans of a URG-04LX in an arena of 2 m x 2 m whose four corners are known. Figures
stand before the paper's own, in brackets; the paper's come from 40 and some scans in a hallway. A
blind scan is one in which nothing is found, needlessly so if there is a true corner in it. Real
features are all crossings of the sides that at least four beams measure; one counts as found within
0.2 m, one to one. Six round poles stand in the arena, and four beams on one of them look like a
short wall. Extractors are told the noise that the scans so far show, as the commands do by default;
the rows of the paper know none."""

LOGS = """The scans of seven logs with corrected poses. Their truth is a map made of all the scans
of a log; what the map does not know (furniture, people, walls seen too rarely) makes crossings that
count as false here. Judged are the corners of which the map can say whether they are right."""

BLIND = """Scans in which a method finds nothing, of all scans of a recording."""

TRUTH = """Where the truth comes from. Used: scans that fit the map. Known share: of their points
that lie on a wall of the map. Residual: median distance of these from it [m]. Held out: a map of
every second scan, on the others: share of these that fit, share of the corners of the one map that
the other has, and how far apart they are [m]."""


def table2_page(result: Table2Result) -> Page:
    """Return the page of Table II.

    Raises
    ------
    MissingDependencyError
        If matplotlib is not installed.
    """
    blocks: list[Block] = [
        paragraph(ARENA),
        _beside_the_paper(result.rows),
        table_of(_told(result.defaults)),
        Heading("On logs with corrected poses"),
        paragraph(LOGS),
        _beside_the_paper(result.log_rows),
        table_of(_told(result.log_defaults)),
        Heading("Blind scans"),
        paragraph(BLIND),
        to_table(result.blind),
        Heading("The truth of real scans"),
        paragraph(TRUTH),
        table_of(result.recordings, text=2),
        *(Gallery([_map(result, name)]) for name in SHOWN_MAPS if name in result.maps),
        Heading("Measured on"),
        facts_table(machine()),
    ]
    figures = {
        "table2": result.rows,
        "table2_logs": result.log_rows,
        "table2_defaults": [
            {"scans_of": name} | row
            for name, rows in (("arena", result.defaults), ("logs", result.log_defaults))
            for row in rows
        ],
        "table2_recordings": result.details,
        "table2_blind": result.blind,
        "table2_truth": result.recordings,
    }
    return Page("table2", Document("Table II of the paper, run again", blocks), figures)


def _beside_the_paper(rows: Sequence[Row]) -> Table:
    header = [
        "Δθ [deg]", "Δd [cm]", "window", "blind scans", "real features", "matched", "extracted",
        "TP [%]", "FP [%]", "needlessly blind", "FP, judged [%]", "time [ms]",
    ]  # fmt: skip
    cells = [
        [
            f"{row['theta_step']:g}",
            f"{row['distance_step']:g}",
            "{} x {}".format(*row["neighborhood"]),
        ]
        + [f"{cell(row[key], key)} ({row['paper'][key]})" for key in SHARED]
        + [cell(row["needlessly_blind"])]
        + [cell(row["fp_judged_percent"], "percent"), cell(row["time_ms"])]
        for row in rows
    ]
    return Table(header, cells, frozenset({2}))


def _told(rows: Sequence[Row]) -> list[Row]:
    return [{"extractor": row["extractor"]} | {key: row[key] for key in TOLD} for row in rows]


def _map(result: Table2Result, name: str) -> Picture:
    alt = f"The map of {name}: points of all scans, walls, and real corners"
    return Picture(f"table2_map_{name}", "", alt, map_png(result.maps[name]))
