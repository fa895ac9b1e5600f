"""How extractors bear more noise, more or fewer beams, and outliers."""

from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from laserfeatures.registry import get_extractor
from laserfeatures.simulation import Scanner
from laserfeatures.testbench.measuring import (
    extractors_by_name,
    measure,
    methods,
    trials_of,
)
from laserfeatures.testbench.scans import any_scans
from laserfeatures.testbench.workers import Progress, in_parallel, silent

if TYPE_CHECKING:
    from collections.abc import Mapping

    from laserfeatures.pipeline import Pipeline

SCANS = 100
PAPER = "paper"  # its literal algorithm, as the preset has it: 1 deg, 2 cm, 11 x 21


@dataclass(frozen=True)
class Axis:
    """What is varied.

    Parameters
    ----------
    name : str
        Its name in results.
    label : str
        Name and unit, for pictures and tables.
    field : str
        The parameter of `Scanner`.
    unit : float
        Size of the unit in the parameter's.
    values : tuple of float
        What it is set to, in that unit.
    """

    name: str
    label: str
    field: str
    unit: float
    values: tuple[float, ...]

    def scanner(self, value: float) -> Scanner:
        """Return the `lms200` with that value instead of its own."""
        kind = type(getattr(Scanner, self.field))
        return Scanner.model("lms200", **{self.field: kind(value * self.unit)})


AXES = (
    Axis("sigma_mm", "deviation of a range [mm]", "range_sigma", 1e-3, (0, 5, 10, 20, 30, 40, 50)),
    Axis("beams", "beams in 180°", "beams", 1, (91, 181, 361, 541, 721, 1081)),
    Axis("outliers_percent", "outliers [% of beams]", "outliers", 1e-2, (0, 2, 5, 10, 15, 20)),
)


@dataclass(frozen=True, kw_only=True)
class NoiseResult:
    """What came out.

    Parameters
    ----------
    scans, seed : int
        How many scans for each setting, and the seed that they were drawn with.
    rows : list of dict
        For each extractor at each setting: "axis", "value", "extractor", "tp_percent",
        "fp_percent", "f1", "oracle_share", "median_error", "rms_error" [m].
    """

    scans: int
    seed: int
    rows: list[dict[str, Any]]


def run(
    *, seed: int = 2, scans: int = SCANS, workers: int = 1, progress: Progress = silent
) -> NoiseResult:
    """Vary the sensor, one thing at a time, and score every extractor and the oracle.

    The worlds are those of Table I's scans, as they come; all settings have the same worlds and
    poses. No extractor is told the noise.

    Parameters
    ----------
    seed : int
        Seed of the scans.
    scans : int
        Number of scans for each setting.
    workers : int
        Number of processes.
    progress : Progress
        Shows how far it is.

    Raises
    ------
    LaserFeaturesError
        If an extractor fails or a worker is killed.
    MissingDependencyError
        If SciPy is missing.
    """
    every = extractors_by_name() | {PAPER: get_extractor("direct_hough", preset="paper")}
    settings = [(axis, value) for axis in AXES for value in axis.values]
    work = partial(_score_setting, extractors=every, seed=seed, scans=scans)
    parts = in_parallel(work, settings, workers=workers, progress=progress, label="noise")
    return NoiseResult(scans=scans, seed=seed, rows=[row for part in parts for row in part])


def _score_setting(
    setting: tuple[Axis, float], *, extractors: "Mapping[str, Pipeline]", seed: int, scans: int
) -> list[dict[str, Any]]:
    """Return a row for each extractor and the oracle."""
    axis, value = setting
    trials = trials_of(any_scans(seed, scans, axis.scanner(value)))
    found = {name: measure(each, trials).score for name, each in methods(extractors).items()}
    best = list(found.values())[-1]
    return [
        {
            "axis": axis.name,
            "value": value,
            "extractor": name,
            "tp_percent": score.tp_percent,
            "fp_percent": score.fp_percent,
            "f1": score.f1,
            "oracle_share": score.f1 / best.f1,
            "median_error": score.median_error,
            "rms_error": score.rms_error,
        }
        for name, score in found.items()
    ]
