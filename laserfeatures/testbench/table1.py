"""The paper's Table I run again, then this project's defaults and the oracle on the same scans."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures.comparison.turns import Failure, run_in_turns
from laserfeatures.data import LaserScan
from laserfeatures.testbench.measuring import (
    ORACLE,
    details,
    extractors_by_name,
    measure,
    methods,
    trials_of,
)
from laserfeatures.testbench.paper import SCANS, TABLE1, Table1Row
from laserfeatures.testbench.reasons import reasons_of
from laserfeatures.testbench.scans import on_grid, paper_scans
from laserfeatures.testbench.workers import Progress, in_parallel, silent

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

HEADINGS = math.radians(30)  # of the second set of scans: a multiple of every theta step
TIMED = 100  # scans, spread over all
FIGURES = (
    "lines_detected", "lines_filtered", "features_matched", "features_extracted", "tp_percent",
    "fp_percent", "time_ms",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Table1Result:
    """What came out.

    Parameters
    ----------
    scans, seed : int
        How many scans, and the seed that they were drawn with.
    real_lines, real_features : int
        True lines and corners in them.
    rows : list of dict
        For each row of the paper's table: "theta_step" [deg], "distance_step" [cm], "neighborhood"
        (cells along theta, along d), the figures of `FIGURES`, and under "paper" the paper's own.
    reasons : list of dict
        For each row, what `reasons_of` says of it.
    defaults : list of dict
        The same figures, and more, of every extractor with its defaults, and at last the oracle.
    """

    scans: int
    seed: int
    real_lines: int
    real_features: int
    rows: list[dict[str, Any]]
    reasons: list[dict[str, Any]]
    defaults: list[dict[str, Any]]


def run(
    *, seed: int = 1, scans: int = SCANS, workers: int = 1, progress: Progress = silent
) -> Table1Result:
    """Run Table I again.

    The counts do not depend on the number of workers. The times are taken when the workers have
    ended, in this process: all rows and extractors in turns, as `run_in_turns` does it.

    Parameters
    ----------
    seed : int
        Seed of the scans.
    scans : int
        Number of scans.
    workers : int
        Number of processes for all but the times.
    progress : Progress
        Shows how far it is.

    Raises
    ------
    LaserFeaturesError
        If there are no such scans, an extractor fails or a worker is killed.
    MissingDependencyError
        If SciPy is missing.
    """
    observations = paper_scans(seed, scans)
    trials = trials_of(observations)
    literal = {row.name: row.extractor for row in TABLE1}
    defaults = extractors_by_name()
    every = [*literal.values(), *methods(defaults).values()]
    measured = in_parallel(
        partial(measure, trials=trials), every, workers=workers, progress=progress, label="table 1"
    )
    gridded = trials_of(on_grid(observations, seed, HEADINGS))
    reasons = in_parallel(
        partial(reasons_of, trials=trials, on_grid=gridded),
        TABLE1,
        workers=workers,
        progress=progress,
        label="reasons",
    )
    found, (*ours, best) = measured[: len(TABLE1)], measured[len(TABLE1) :]
    times = _times({**literal, **defaults}, [scan for scan, _ in trials], progress)
    return Table1Result(
        scans=scans,
        seed=seed,
        real_lines=best.score.lines_true,
        real_features=best.score.features_true,
        rows=[
            _settings(row)
            | each.counts
            | {"time_ms": times[row.name], "paper": {key: getattr(row, key) for key in FIGURES}}
            for row, each in zip(TABLE1, found, strict=True)
        ],
        reasons=reasons,
        defaults=[
            {"extractor": name}
            | each.counts
            | {"time_ms": times.get(name)}
            | details(each.score, best.score)
            for name, each in zip([*defaults, ORACLE], [*ours, best], strict=True)
        ],
    )


def _settings(row: Table1Row) -> dict[str, Any]:
    return {
        "theta_step": row.dtheta_deg,
        "distance_step": row.dd_cm,
        "neighborhood": [row.v_theta, row.v_d],
    }


def _times(
    extractors: "Mapping[str, Pipeline]", scans: Sequence[LaserScan], progress: Progress
) -> dict[str, float]:
    """Return the median time of each extractor on some scans spread over all [ms]."""
    chosen = np.linspace(0, len(scans) - 1, min(TIMED, len(scans))).round().astype(int)
    with progress((scans[i] for i in chosen), length=len(chosen), label="times") as sample:
        runs = run_in_turns(extractors, sample)
    return {
        name: float("nan") if isinstance(own, Failure) else 1e3 * float(np.median(own.seconds))
        for name, own in runs.items()
    }
