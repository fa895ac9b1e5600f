"""How the time of extractors grows with the number of beams, told from the log itself."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.comparison.turns import Extractor, Run, run_in_turns
from laserfeatures.data import LaserScan

STEPS = (8, 4, 2, 1)
SAMPLE = 64  # scans


@dataclass(frozen=True, eq=False, kw_only=True)
class Growth:
    """Time over beams.

    Parameters
    ----------
    beams : (K,) array
        Median number of beams of the scans, thinned to every 8th, 4th, 2nd and all beams.
    seconds : mapping of str to (K,) array
        Median time of each extractor on them [s]; nan where it raised.
    scans : int
        Number of scans that were timed.
    """

    beams: FloatArray
    seconds: Mapping[str, FloatArray]
    scans: int


def growth(extractors: Mapping[str, Extractor], scans: Sequence[LaserScan]) -> Growth:
    """Time extractors on every 8th, 4th, 2nd and all beams of some scans.

    Parameters
    ----------
    extractors : mapping of str to callable
        From a name to an extractor.
    scans : sequence of LaserScan
        The log, at least one scan; 64 of them, spread evenly over it, are timed.

    Raises
    ------
    ValueError
        If there is no scan.
    """
    if not scans:
        raise ValueError("expected at least one scan to time on, got none")
    chosen = np.linspace(0, len(scans) - 1, min(SAMPLE, len(scans))).round().astype(int)
    sample = [scans[i] for i in chosen]
    beams, columns = [], []
    for step in STEPS:
        thin = list(_thinned(sample, step))
        beams.append(np.median([len(scan) for scan in thin]))
        columns.append(run_in_turns(extractors, thin))
    return Growth(
        beams=np.array(beams),
        seconds={
            name: np.array([
                np.median(run.seconds) if isinstance(run, Run) else np.nan
                for run in (column[name] for column in columns)
            ])
            for name in extractors
        },
        scans=len(sample),
    )  # fmt: skip


def _thinned(scans: Sequence[LaserScan], step: int) -> Iterator[LaserScan]:
    """Yield the scans with every `step`-th beam; those that share their angles still do."""
    shared: dict[int, FloatArray] = {}
    for scan in scans:
        angles = shared.setdefault(id(scan.angles), scan.angles[::step].copy())
        angles.flags.writeable = False
        yield replace(scan, angles=angles, ranges=scan.ranges[::step])
