"""A run of SLAM held against a reference."""

from dataclasses import dataclass

from laserfeatures.arrays import FloatArray
from laserfeatures.mapping.matching import Matched
from laserfeatures.mapping.measures import Errors, alignment, errors
from laserfeatures.mapping.reference import Reference
from laserfeatures.mapping.run import Run


@dataclass(frozen=True, eq=False, kw_only=True)
class Against:
    """How far a run is from a reference.

    Parameters
    ----------
    matched_by : str
        How the poses were matched: by "stamp" or by "scan".
    poses : int
        How many of the run's poses have one of the reference.
    slam, odometry : Errors
        Of the poses by SLAM and by odometry.
    way : (K, 2) array
        Positions of the reference [m], aligned to those by SLAM, in the frame of the map.
    """

    matched_by: str
    poses: int
    slam: Errors
    odometry: Errors
    way: FloatArray


def against(run: Run, reference: Reference, pairs: Matched) -> Against:
    """Hold a run against a reference, given which poses go together.

    Raises
    ------
    ValueError, MissingDependencyError
        As `laserfeatures.mapping.measures.errors`.
    """
    estimate, truth = pairs.pairs(run.estimate, reference.trajectory)
    odometry, _ = pairs.pairs(run.odometry, reference.trajectory)
    turn, shift = alignment(truth, estimate)
    return Against(
        matched_by=pairs.by,
        poses=len(estimate),
        slam=errors(estimate, truth),
        odometry=errors(odometry, truth),
        way=truth.poses[:, :2] @ turn.T + shift,
    )
