"""What an extractor finds in scans of which the truth is known."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features, LaserScan, LineSegments, PointFeatures
from laserfeatures.errors import PluginError
from laserfeatures.evaluation import Score, Truth, oracle, score, truth_of
from laserfeatures.registry import get_extractor, list_extractors
from laserfeatures.simulation import Observation

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

ORACLE = "oracle"

Trial = tuple[LaserScan, Truth]


@dataclass(frozen=True, eq=False)
class Measured:
    """What was found in some scans.

    Parameters
    ----------
    score : Score
        Its score.
    lines_detected, lines_filtered : int
        Lines before the filter, and those that it leaves.
    """

    score: Score
    lines_detected: int
    lines_filtered: int

    @property
    def counts(self) -> dict[str, Any]:
        """What the paper's Table I says of a row, but the time."""
        return {
            "lines_detected": self.lines_detected,
            "lines_filtered": self.lines_filtered,
            "features_matched": self.score.features_matched,
            "features_extracted": self.score.features_extracted,
            "tp_percent": self.score.tp_percent,
            "fp_percent": self.score.fp_percent,
        }


def extractors_by_name() -> "dict[str, Pipeline]":
    """Return every registered extractor with its defaults."""
    return {name: get_extractor(name) for name in list_extractors()}


def trials_of(observations: Iterable[Observation]) -> list[Trial]:
    """Return each scan with its truth."""
    return [(observation.scan, truth_of(observation)) for observation in observations]


def measure(extractor: "Pipeline | None", trials: Sequence[Trial]) -> Measured:
    """Return what an extractor finds, or the oracle where that is None.

    Raises
    ------
    PluginError
        If the extractor fails.
    """
    if extractor is None:
        of_oracle = Score.total(score(oracle(scan, truth), truth) for scan, truth in trials)
        return Measured(of_oracle, of_oracle.lines_true, of_oracle.lines_true)
    scores, detected, filtered = [], 0, 0
    for number, trial in enumerate(trials):
        found, features = extract(extractor, trial, number)
        detected += len(found.lines)
        filtered += len(features.lines)
        scores.append(score(features, trial[1]))
    return Measured(Score.total(scores), detected, filtered)


def extract(extractor: "Pipeline", trial: Trial, number: int) -> tuple[LineSegments, Features]:
    """Return what the detector finds in a scan, and what the stages after it make of that.

    Raises
    ------
    PluginError
        If the extractor fails; the message has the scan's number.
    """
    scan = trial[0]
    try:
        detected, features = extractor.detector(scan), extractor(scan)
    except Exception as error:
        raise PluginError(
            f"{extractor.name} failed at scan {number}: {type(error).__name__}: {error}"
        ) from error
    if isinstance(detected, PointFeatures):
        return LineSegments.none(len(scan)), features
    return detected, features


def details(measured: Score, best: Score) -> dict[str, Any]:
    """Return what there is to say of an extractor beside the paper's figures.

    Parameters
    ----------
    measured : Score
        Its score.
    best : Score
        The oracle's on the same scans. It has no covariances, so that nothing is consistent.
    """
    told = measured is not best
    return {
        "f1": measured.f1,
        "oracle_share": measured.f1 / best.f1,
        "blind_scans": measured.blind_scans,
        "median_error": measured.median_error,
        "rms_error": measured.rms_error,
        "line_recall": measured.line_recall,
        "line_precision": measured.line_precision,
        "duplicates": measured.duplicates,
        "angle_rms": _rms(measured.angle_errors),
        "distance_rms": _rms(measured.distance_errors),
        "corner_consistency": measured.corner_consistency if told else None,
        "line_consistency": measured.line_consistency if told else None,
        "confusion": measured.confusion,
    }


def methods(extractors: "Mapping[str, Pipeline]") -> "dict[str, Pipeline | None]":
    """Return extractors by name, and the oracle, None, after them."""
    return {**extractors, ORACLE: None}


def _rms(errors: FloatArray) -> float:
    return float(np.sqrt(np.mean(errors**2))) if errors.size else float("nan")
