"""What a run of SLAM on a log came to, as figures."""

import math
from collections.abc import Sequence
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.mapping.against import Against
from laserfeatures.mapping.measures import Errors
from laserfeatures.mapping.run import Run


def summary(
    run: Run, held: Against | None = None, notices: Sequence[str] = (), **facts: Any
) -> dict[str, Any]:
    """Return the figures of a run by name, in metres, radians and seconds but where it says ms.

    Parameters
    ----------
    run : Run
        What SLAM made of the scans.
    held : Against, optional
        Its errors; their keys are there without it, too, and None.
    notices : sequence of str
        What was odd about the log, and what the filter said.
    **facts
        What else is to stand in it, such as the name of the extractor; it comes first.

    Returns
    -------
    dict
        With the errors under their own names, and those of the odometry with ``odometry_`` before
        it. "steps" holds a list over the scans of each thing that one may want to plot.
    """
    kinds = [mark.kind for mark in run.map]
    milliseconds = 1e3 * run.seconds
    known = run.estimate.stamps[np.isfinite(run.estimate.stamps)]
    return {
        **facts,
        "scans": len(run.estimate),
        "seconds": float(np.ptp(known)) if known.size else None,
        "landmarks": len(kinds),
        "corners": kinds.count("corner"),
        "walls": kinds.count("wall"),
        "way": way(run.estimate.poses),
        "odometry_way": way(run.odometry.poses),
        **_errors(held),
        "median_step_ms": float(np.median(milliseconds)),
        "worst_step_ms": float(milliseconds.max()),
        "nis_per_degree": _consistency(run),
        "notices": list(notices),
        "steps": {
            "stamp": run.estimate.stamps,
            "ms": milliseconds,
            "landmarks": run.landmarks,
            "matched": run.matched,
            "nis": run.nis,
            "position_deviation": np.sqrt(np.trace(run.covariances[:, :2, :2], axis1=1, axis2=2)),
            "heading_deviation": np.sqrt(run.covariances[:, 2, 2]),
        },
    }


def way(poses: FloatArray) -> float:
    """Return the length of the way through poses (N, 2+) [m]."""
    return float(np.hypot(*np.diff(poses[:, :2], axis=0).T).sum())


def _errors(held: Against | None) -> dict[str, Any]:
    found = {
        "matched_by": held.matched_by if held else None,
        "matched_poses": held.poses if held else None,
    }
    none = dict.fromkeys(field.name for field in fields(Errors))
    slam, odometry = (asdict(held.slam), asdict(held.odometry)) if held else (none, none)
    return found | slam | {f"odometry_{name}": value for name, value in odometry.items()}


def _consistency(run: Run) -> float:
    """Return the mean NIS by degree of freedom: 1 is right, more is too sure."""
    degrees = 2 * int(run.matched.sum())
    return float(run.nis.sum()) / degrees if degrees else math.nan
