"""The paper's Table II run again on real scans with known corners, and on those without."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features
from laserfeatures.errors import MissingDependencyError, PluginError, SourceError
from laserfeatures.evaluation import Score, oracle, score
from laserfeatures.noise_model import NoiseModel, RangeNoise
from laserfeatures.testbench.measuring import ORACLE, extractors_by_name
from laserfeatures.testbench.paper import TABLE2, Table2Row
from laserfeatures.testbench.real.recordings import RECORDINGS, Drawing, Known, Recording, load
from laserfeatures.testbench.real.view import View, judged
from laserfeatures.testbench.workers import Progress, in_parallel, silent

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

ARENA, LOGS = "arena", "all logs"
PAPER = {
    "blind_scans": "blind_scans", "real_features": "real_features", "features_matched": "matches",
    "features_extracted": "extracted", "tp_percent": "tp_percent", "fp_percent": "fp_percent",
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Table2Result:
    """What came out.

    Parameters
    ----------
    recordings : list of dict
        Each recording: scans, where its truth comes from, and what is known of that.
    rows : list of dict
        For each row of the paper's table, on the arena: "theta_step" [deg], "distance_step" [cm],
        "neighborhood" (cells along theta, along d), the figures of `_figures`, and under "paper"
        the paper's own.
    log_rows : list of dict
        The same on all logs with corrected poses.
    defaults, log_defaults : list of dict
        The same figures of every extractor with its defaults, and at last the oracle.
    details : list of dict
        The same figures of every row, extractor and oracle on each recording with truth.
    blind : list of dict
        Scans of each recording in which nothing was found, one row a recording; the last is all.
    maps : dict of str to Drawing
        The map of each log.
    """

    recordings: list[dict[str, Any]]
    rows: list[dict[str, Any]]
    log_rows: list[dict[str, Any]]
    defaults: list[dict[str, Any]]
    log_defaults: list[dict[str, Any]]
    details: list[dict[str, Any]]
    blind: list[dict[str, Any]]
    maps: dict[str, Drawing]


@dataclass(frozen=True, eq=False)
class Found:
    """What a method found in a recording, or in several.

    Parameters
    ----------
    score : Score
        Its score on the scans of which the truth is known.
    judged : Score
        The same without the corners of which the truth cannot say whether they are right.
    unseeing : int
        Scans with true corners, none of which was found.
    needless : int
        Of these, those in which nothing was found: blind without an excuse.
    blind : int
        Scans without a corner found, of all scans.
    seconds : (N,) array
        Time of each scan [s].
    """

    score: Score = field(default_factory=Score)
    judged: Score = field(default_factory=Score)
    unseeing: int = 0
    needless: int = 0
    blind: int = 0
    seconds: FloatArray = field(default_factory=lambda: np.empty(0))

    @classmethod
    def total(cls, parts: Sequence["Found"]) -> "Found":
        """Add up what was found."""
        return cls(
            Score.total(part.score for part in parts),
            Score.total(part.judged for part in parts),
            sum(part.unseeing for part in parts),
            sum(part.needless for part in parts),
            sum(part.blind for part in parts),
            np.concatenate([np.empty(0), *(part.seconds for part in parts)]),
        )


@dataclass(frozen=True, eq=False)
class Measured:
    """What all methods found in a recording; `found` is by name, in order."""

    facts: dict[str, Any]
    found: dict[str, Found]
    drawing: Drawing | None = None


def run(
    data_folder: Path,
    *,
    recordings: Sequence[Recording] = RECORDINGS,
    workers: int = 1,
    progress: Progress = silent,
) -> Table2Result:
    """Run Table II again.

    The counts do not depend on the number of workers; times are medians of a scan, taken while
    other workers ran. A bag is left out, and said so, where rosbags is not installed.

    Parameters
    ----------
    data_folder : Path
        The recordings.
    recordings : sequence of Recording
        Which of them.
    workers : int
        Number of processes.
    progress : Progress
        Shows how many recordings are done.

    Raises
    ------
    SourceError
        If a recording is missing or damaged.
    PluginError
        If an extractor fails.
    MissingDependencyError
        If SciPy is missing.
    """
    if not data_folder.is_dir():
        raise SourceError(
            f"{data_folder}: expected the folder of the recordings, got none; give its place "
            "(--data)"
        )
    measured = in_parallel(
        partial(measure, data_folder), recordings, workers=workers, progress=progress,
        label="table 2",
    )  # fmt: skip
    details = [
        {"recording": each.facts["recording"], "method": name} | _figures(found)
        for each in measured
        for name, found in each.found.items()
        if each.facts.get("used")
    ]
    arena, logs = (
        [each for each in measured if each.facts["truth"] == truth] for truth in ("arena", "map")
    )
    return Table2Result(
        recordings=_with_all_keys([each.facts for each in measured]),
        rows=_rows(arena),
        log_rows=_rows(logs),
        defaults=_defaults(arena),
        log_defaults=_defaults(logs),
        details=details,
        blind=_blind(measured),
        maps={each.facts["recording"]: each.drawing for each in measured if each.drawing},
    )


def measure(data_folder: Path, recording: Recording) -> Measured:
    """Return what every method finds in a recording.

    Raises
    ------
    SourceError
        If it is missing or damaged.
    PluginError
        If an extractor fails.
    MissingDependencyError
        If SciPy is missing.
    """
    try:
        known = load(data_folder, recording)
    except MissingDependencyError as error:
        if recording.truth != "none":
            raise
        return Measured({"recording": recording.name, "truth": f"left out: {error}"}, {})
    noises = list(map(NoiseModel().feed, known.scans))
    found = {
        name: _find(extractor, known, noises, recording.name)
        for name, extractor in _methods().items()
    }
    best = [_score(oracle(view.scan, view.truth), view) for view in known.views.values()]
    return Measured(known.facts, found | {ORACLE: Found.total(best)}, known.drawing)


def _methods() -> "dict[str, Pipeline]":
    return {row.name: row.extractor for row in TABLE2} | extractors_by_name()


def _find(extractor: "Pipeline", known: Known, noises: Sequence[RangeNoise], name: str) -> Found:
    extractor(known.scans[0], noise=noises[0])  # compiled
    parts = []
    for number, (scan, noise) in enumerate(zip(known.scans, noises, strict=True)):
        again = replace(scan)  # without what was computed for others
        start = time.perf_counter()
        try:
            features = extractor(again, noise=noise)
        except Exception as error:
            raise PluginError(
                f"{extractor.name} failed at scan {number} of {name}: "
                f"{type(error).__name__}: {error}"
            ) from error
        seconds = np.array([time.perf_counter() - start])
        part = _score(features, known.views[number]) if number in known.views else Found()
        parts.append(replace(part, blind=int(len(features.corners) == 0), seconds=seconds))
    return Found.total(parts)


def _score(features: Features, view: View) -> Found:
    scored = score(features, view.truth)
    unseeing = int(len(view.truth.corners) > 0 and not scored.features_matched)
    needless = unseeing * scored.blind_scans
    return Found(scored, score(judged(features, view), view.truth), unseeing, needless)


def _figures(found: Found) -> dict[str, Any]:
    scored = found.score
    return {
        "scans": scored.scans,
        "blind_scans": scored.blind_scans,
        "needlessly_blind": found.needless,
        "unseeing_scans": found.unseeing,
        "real_features": scored.features_true,
        "features_matched": scored.features_matched,
        "features_extracted": scored.features_extracted,
        "tp_percent": scored.tp_percent,
        "fp_percent": scored.fp_percent,
        "features_judged": found.judged.features_extracted,
        "fp_judged_percent": found.judged.fp_percent,
        "f1": scored.f1,
        "f1_judged": found.judged.f1,
        "median_error": scored.median_error,
        "line_recall": scored.line_recall,
        "line_precision": scored.line_precision,
        "time_ms": 1e3 * float(np.median(found.seconds)) if found.seconds.size else None,
    }


def _rows(measured: Sequence[Measured]) -> list[dict[str, Any]]:
    return [
        {
            "theta_step": row.dtheta_deg,
            "distance_step": row.dd_cm,
            "neighborhood": [row.v_theta, row.v_d],
        }
        | _figures(Found.total([each.found[row.name] for each in measured]))
        | {"paper": _papers(row)}
        for row in TABLE2
    ]


def _papers(row: Table2Row) -> dict[str, Any]:
    return {name: getattr(row, theirs) for name, theirs in PAPER.items()}


def _defaults(measured: Sequence[Measured]) -> list[dict[str, Any]]:
    return [
        {"extractor": name} | _figures(Found.total([each.found[name] for each in measured]))
        for name in [*extractors_by_name(), ORACLE]
    ]


def _blind(measured: Sequence[Measured]) -> list[dict[str, Any]]:
    """Return the blind scans of each recording and method, of all scans, and at last the sums."""
    rows = [
        {"recording": each.facts["recording"], "scans": each.facts["scans"]}
        | {name: each.found[name].blind for name in _methods()}
        for each in measured
        if each.found
    ]
    sums = {key: sum(row[key] for row in rows) for key in ("scans", *_methods())}
    return [*rows, {"recording": "all"} | sums]


def _with_all_keys(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    keys = dict.fromkeys(key for row in rows for key in row)
    return [{key: row.get(key) for key in keys} for row in rows]
