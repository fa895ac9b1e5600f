"""How well SLAM did on a simulated drive, whose true poses are known.

Start and frame are given, so that no trajectory is aligned to the truth before it is compared.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.mapping import measures
from laserfeatures.mapping.landmark_score import LandmarkScore, score_landmarks
from laserfeatures.mapping.run import Run
from laserfeatures.mapping.simulated_drive import SimulatedDrive
from laserfeatures.mapping.trajectory import Trajectory

NEES_BAND = (0.215795, 9.348404)
"""Quantiles 0.025 and 0.975 of the chi-square distribution of 3 degrees of freedom."""


@dataclass(frozen=True, kw_only=True)
class DriveScore:
    """Errors of the sensor's pose, and of the map; what cannot be told is nan.

    Parameters
    ----------
    scans : int
        How many there were.
    length : float
        Of the true way [m].
    final_error, odometry_final_error : float
        Distance between the last pose and the last true one [m], by SLAM and by odometry.
    ate_rmse, odometry_ate_rmse : float
        Root mean square of the distances between poses and true poses [m], not aligned.
    rpe_rmse, odometry_rpe_rmse : float
        Root mean square of the errors of the step over 1 m of the true way [m], by evo.
    nees_inside : float
        Share of scans whose NEES of the pose lies in its 95 % band.
    nees_mean : float
        Mean NEES; 3 is right, more is too sure.
    nis_per_degree : float
        Mean NIS over its degrees of freedom; 1 is right, more is too sure.
    step_ms : float
        Median time of a scan [ms]: features, association, update.
    notices : int
        How often the filter said that it is not to be trusted.
    map : LandmarkScore
        Of the landmarks in the end.
    """

    scans: int
    length: float
    final_error: float
    odometry_final_error: float
    ate_rmse: float
    odometry_ate_rmse: float
    rpe_rmse: float
    odometry_rpe_rmse: float
    nees_inside: float
    nees_mean: float
    nis_per_degree: float
    step_ms: float
    notices: int
    map: LandmarkScore


def score_drive(run: Run, drive: SimulatedDrive) -> DriveScore:
    """Return how well a run on a drive did.

    Raises
    ------
    MissingDependencyError
        If evo is not installed.
    """
    errors = position_errors(run.estimate, drive.truth)
    odometry_errors = position_errors(run.odometry, drive.truth)
    normalised = nees(run, drive.truth)
    low, high = NEES_BAND
    degrees = 2 * int(run.matched.sum())
    return DriveScore(
        scans=len(drive.truth),
        length=float(drive.way[-1]),
        final_error=float(errors[-1]),
        odometry_final_error=float(odometry_errors[-1]),
        ate_rmse=_rms(errors),
        odometry_ate_rmse=_rms(odometry_errors),
        rpe_rmse=_rpe(run.estimate, drive.truth),
        odometry_rpe_rmse=_rpe(run.odometry, drive.truth),
        nees_inside=_mean((normalised >= low) & (normalised <= high)),
        nees_mean=_mean(normalised),
        nis_per_degree=float(run.nis.sum()) / degrees if degrees else math.nan,
        step_ms=1e3 * float(np.median(run.seconds)),
        notices=len(run.notices),
        map=score_landmarks(run.map, drive.map),
    )


def position_errors(poses: Trajectory, truth: Trajectory) -> FloatArray:
    """Return the distance of each pose from the true one [m], (N,)."""
    distances: FloatArray = np.linalg.norm(poses.poses[:, :2] - truth.poses[:, :2], axis=1)
    return distances


def nees(run: Run, truth: Trajectory) -> FloatArray:
    """Return the normalised estimation error squared of each pose but the first, (N - 1,).

    The first is given and has no error. If the filter is consistent, NEES follows the chi-square
    distribution of 3 degrees of freedom.

    References
    ----------
    Bar-Shalom, Li and Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001,
    section 5.4.
    """
    errors = (run.estimate.poses - truth.poses)[1:]
    errors[:, 2] = np.remainder(errors[:, 2] + math.pi, math.tau) - math.pi
    solved = np.linalg.solve(run.covariances[1:], errors[:, :, None])[:, :, 0]
    squared: FloatArray = (errors * solved).sum(axis=1)
    return squared


def _rpe(poses: Trajectory, truth: Trajectory) -> float:
    try:
        error = measures.errors(poses, truth).rpe_translation
    except ValueError:  # a drive of a few scans, or none away from the start
        return math.nan
    return math.nan if error is None else error


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _mean(values: Any) -> float:
    return float(np.mean(values)) if len(values) else math.nan
