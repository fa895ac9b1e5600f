"""How far a trajectory is from a reference, by evo (extra `slam`).

References
----------
Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012: ATE and RPE.
Umeyama, Least-Squares Estimation of Transformation Parameters Between Two Point Patterns, IEEE
Transactions on Pattern Analysis and Machine Intelligence 13(4), 1991: the alignment.
Grupp, evo: Python Package for the Evaluation of Odometry and SLAM, 2017.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.optional import optional

FEWEST = 3  # poses; two can always be aligned
METRE = 1.0  # [m] of the reference's way, of which the RPE is given


@dataclass(frozen=True, kw_only=True)
class Errors:
    """How far a trajectory is from a reference.

    Parameters
    ----------
    ate_rmse, ate_median, ate_max : float
        Absolute trajectory error: distances of positions after the trajectory was turned and
        shifted in the plane, but not scaled, to fit the reference best [m].
    rpe_translation : float or None
        Relative pose error, root mean square: how wrong the step over 1 m of the reference's way
        is [m]. Where the reference has no headings, how wrong its length is. None where its way is
        shorter.
    rpe_rotation : float or None
        How wrong its turn is [rad]; None without headings, too.
    rpe_scan_translation, rpe_scan_rotation : float or None
        The same from each matched scan to the next.
    """

    ate_rmse: float
    ate_median: float
    ate_max: float
    rpe_translation: float | None
    rpe_rotation: float | None
    rpe_scan_translation: float | None
    rpe_scan_rotation: float | None


def errors(estimate: Trajectory, reference: Trajectory) -> Errors:
    """Measure how far a trajectory is from a reference.

    Parameters
    ----------
    estimate, reference : Trajectory
        Poses that go together in pairs; headings of nan are not known.

    Raises
    ------
    ValueError
        If there are fewer than 3 pairs, a position is not finite, or one side stands still.
    MissingDependencyError
        If evo is not installed.
    """
    aligned = align(estimate, reference)
    ate = _evo("metrics").APE(_evo("metrics").PoseRelation.translation_part)
    headings = bool(np.isfinite([aligned.poses, reference.poses]).all())
    paths = _path(reference, headings=headings), _path(aligned, headings=headings)
    ate.process_data(paths)
    statistics = ate.get_all_statistics()
    metre, metre_turn = _relative(paths, METRE, "meters", headings=headings)
    scan, scan_turn = _relative(paths, 1, "frames", headings=headings)
    return Errors(
        ate_rmse=float(statistics["rmse"]),
        ate_median=float(statistics["median"]),
        ate_max=float(statistics["max"]),
        rpe_translation=metre,
        rpe_rotation=metre_turn,
        rpe_scan_translation=scan,
        rpe_scan_rotation=scan_turn,
    )


def align(estimate: Trajectory, reference: Trajectory) -> Trajectory:
    """Turn and shift a trajectory in the plane so that it fits a reference best.

    It is aligned as 2D points: in space the best turn could be about an axis of the plane, which
    would mirror the trajectory.

    Raises
    ------
    ValueError, MissingDependencyError
        As `errors`.
    """
    turn, shift = alignment(estimate, reference)
    poses = np.column_stack(
        [
            estimate.poses[:, :2] @ turn.T + shift,
            estimate.poses[:, 2] + math.atan2(turn[1, 0], turn[0, 0]),
        ]
    )
    return Trajectory(stamps=estimate.stamps, poses=poses)


def alignment(estimate: Trajectory, reference: Trajectory) -> tuple[FloatArray, FloatArray]:
    """Return the rotation (2, 2) and shift (2,) [m] that take a trajectory to a reference.

    Raises
    ------
    ValueError, MissingDependencyError
        As `errors`.
    """
    ways = {"trajectory": estimate.poses[:, :2], "reference": reference.poses[:, :2]}
    if len(estimate) != len(reference):
        raise ValueError(f"expected poses in pairs, got {len(estimate)} and {len(reference)}")
    if len(estimate) < FEWEST:
        raise ValueError(f"expected at least {FEWEST} matched poses, got {len(estimate)}")
    for name, way in ways.items():
        if not np.isfinite(way).all():
            raise ValueError(f"expected a {name} of finite positions, got nan or inf")
        if np.ptp(way, axis=0).max() < 1e-9:
            raise ValueError(f"expected a {name} that moves, got {len(way)} times the same place")
    turn, shift, _ = _evo("geometry").umeyama_alignment(*(way.T for way in ways.values()))
    return turn, shift


def _relative(
    paths: tuple[Any, Any], delta: float, unit: str, *, headings: bool
) -> tuple[float | None, float | None]:
    """Return the root mean square errors of steps in translation [m] and rotation [rad]."""
    metrics = _evo("metrics")
    relation = metrics.PoseRelation
    wanted = [relation.translation_part if headings else relation.point_distance]
    wanted += [relation.rotation_angle_rad] * headings
    found: list[float | None] = []
    for each in wanted:
        error = metrics.RPE(each, delta, metrics.Unit[unit], pairs_from_reference=True)
        try:
            error.process_data(paths)
        except _evo("filters").FilterException:  # the reference's way is shorter than one step
            found.append(None)
        else:
            found.append(float(error.get_statistic(metrics.StatisticsType.rmse)))
    return found[0], found[1] if headings else None


def _path(trajectory: Trajectory, *, headings: bool) -> Any:
    """Return a path of evo in the plane z = 0; without headings, one that looks along x."""
    poses = np.tile(np.eye(4), (len(trajectory), 1, 1))
    poses[:, :2, 3] = trajectory.poses[:, :2]
    if headings:
        c, s = np.cos(trajectory.poses[:, 2]), np.sin(trajectory.poses[:, 2])
        poses[:, :2, :2] = np.stack([c, -s, s, c], axis=1).reshape(-1, 2, 2)
    return _evo("trajectory").PosePath3D(poses_se3=list(poses))


def _evo(module: str) -> Any:
    return optional(f"evo.core.{module}", "errors of trajectories need evo", "slam")
