"""Scores of simulated drives as plain figures, one by one and of many together."""

import math
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.mapping.drive_score import DriveScore


def figures(score: DriveScore) -> dict[str, Any]:
    """Return a drive's score as plain figures under the names of its fields."""
    flat: dict[str, Any] = asdict(score)
    of_map = flat.pop("map")
    flat["landmark_error"] = of_map.pop("median_error")
    flat.update(of_map)
    return flat


def summary(scores: Sequence[DriveScore]) -> dict[str, Any]:
    """Return the figures of some drives together.

    Errors are medians of the drives, and the worst; `ratio` is the median final error over that of
    odometry, `worst_ratio` the worst drive's own. `nees_inside` is of all scans of all drives, and
    the shares of landmarks of all landmarks; a share of nothing is nan.

    Raises
    ------
    ValueError
        If there is no drive.
    """
    if not scores:
        raise ValueError("a summary is of at least one drive, got none")
    column = {
        name: np.array([figures(score)[name] for score in scores]) for name in figures(scores[0])
    }
    final, odometry = column["final_error"], column["odometry_final_error"]
    scans, landmarks = column["scans"] - 1.0, float(column["landmarks"].sum())
    return {
        "drives": len(scores),
        "length": _median(column["length"]),
        "odometry_final_error": _median(odometry),
        "final_error": _median(final),
        "worst_final_error": float(final.max()),
        "ratio": _share(_median(final), _median(odometry)),
        "worst_ratio": max(map(_share, final.tolist(), odometry.tolist())),
        "odometry_ate_rmse": _median(column["odometry_ate_rmse"]),
        "ate_rmse": _median(column["ate_rmse"]),
        "worst_ate_rmse": float(column["ate_rmse"].max()),
        "odometry_rpe_rmse": _median(column["odometry_rpe_rmse"]),
        "rpe_rmse": _median(column["rpe_rmse"]),
        "nees_inside": _share(float((column["nees_inside"] * scans).sum()), float(scans.sum())),
        "nees_mean": _share(float((column["nees_mean"] * scans).sum()), float(scans.sum())),
        "nis_per_degree": _median(column["nis_per_degree"]),
        "landmarks": _median(column["landmarks"]),
        "landmark_error": _median(column["landmark_error"]),
        "spurious": _share(float(column["spurious"].sum()), landmarks),
        "doubled": _share(float(column["doubled"].sum()), landmarks),
        "virtual": _share(float(column["virtual"].sum()), landmarks),
        "step_ms": _median(column["step_ms"]),
        "notices": int(column["notices"].sum()),
    }


def _median(values: FloatArray) -> float:
    """Return the median of what is known."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else math.nan


def _share(part: float, whole: float) -> float:
    return part / whole if whole else math.nan
