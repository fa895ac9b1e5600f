"""`compare`: extractors measured on the same scans."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from laserfeatures.arrays import FloatArray
from laserfeatures.comparison.evidence import Curve, by_evidence
from laserfeatures.comparison.matching import Repeatability, agreement, repeatability
from laserfeatures.comparison.turns import Extractor, Failure, Run, run_in_turns
from laserfeatures.data import LaserScan

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise

TOLERANCE = 0.2  # [m]


@dataclass(frozen=True, eq=False, kw_only=True)
class Comparison:
    """What extractors did on the same scans.

    Parameters
    ----------
    outcomes : mapping of str to Run or Failure
        What each extractor found, or why it did not, by name.
    repeatability : mapping of str to Repeatability
        How many corners of each are found again in the next scan; none judged without poses.
    evidence : mapping of str to mapping of str to Curve
        How many of its "real" and "virtual" corners are, by least evidence.
    agreement : (R, R) array
        Row a, column b: share of the corners of run a that run b has too; nan where a has none.
    tolerance : float
        Greatest distance of corners that count as the same [m].
    noises : sequence of RangeNoise or None
        What the extractors were told of the noise of each scan.
    """

    outcomes: Mapping[str, Run | Failure]
    repeatability: Mapping[str, Repeatability]
    evidence: Mapping[str, Mapping[str, Curve]]
    agreement: FloatArray
    tolerance: float
    noises: "Sequence[RangeNoise | None]"

    @property
    def runs(self) -> dict[str, Run]:
        """The R extractors that finished, in order."""
        return {name: run for name, run in self.outcomes.items() if isinstance(run, Run)}

    @property
    def posed(self) -> bool:
        """Whether any two neighbouring scans have poses, so that corners can be found again."""
        return any(again.pairs for again in self.repeatability.values())

    @property
    def failures(self) -> dict[str, Failure]:
        """The extractors that did not, in order."""
        return {name: why for name, why in self.outcomes.items() if isinstance(why, Failure)}


def compare(
    extractors: Mapping[str, Extractor | Failure],
    scans: Iterable[LaserScan],
    *,
    noises: "Sequence[RangeNoise | None] | None" = None,
    tolerance: float = TOLERANCE,
    start: int = 0,
) -> Comparison:
    """Run extractors on the same scans, and measure what can be told without knowing the truth.

    Parameters
    ----------
    extractors : mapping of str to callable or Failure
        From a name to an extractor, or to why there is none: that is then its outcome.
    scans : iterable of LaserScan
        The scans in order, at least one. They are kept.
    noises : sequence of RangeNoise or None, optional
        The noise of each scan, such as a `NoiseModel` tells it; extractors are called with
        ``noise=`` where there is one.
    tolerance : float
        Greatest distance of corners that count as the same [m].
    start : int
        Number of the first scan, for messages.

    Raises
    ------
    ValueError
        If there is no scan, or the tolerance is not positive.
    """
    if not tolerance > 0:
        raise ValueError(f"tolerance must be > 0 m, got {tolerance!r}")
    kept: list[LaserScan] = []
    able = {name: each for name, each in extractors.items() if not isinstance(each, Failure)}
    finished = run_in_turns(able, _keeping(scans, kept), noises=noises, start=start)
    if not kept:
        raise ValueError("expected at least one scan to compare on, got none")
    unable = {name: each for name, each in extractors.items() if isinstance(each, Failure)}
    outcomes = {name: (finished | unable)[name] for name in extractors}
    runs = {name: run for name, run in outcomes.items() if isinstance(run, Run)}
    return Comparison(
        outcomes=outcomes,
        repeatability={
            name: repeatability(kept, run.positions, tolerance) for name, run in runs.items()
        },
        evidence={name: by_evidence(kept, run.corners, tolerance) for name, run in runs.items()},
        agreement=agreement([run.positions for run in runs.values()], tolerance),
        tolerance=tolerance,
        noises=[None] * len(kept) if noises is None else noises,
    )


def _keeping(scans: Iterable[LaserScan], kept: list[LaserScan]) -> Iterable[LaserScan]:
    for scan in scans:
        kept.append(scan)
        yield scan
