"""The real recordings of table 2, and where their truth comes from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import LaserScan
from laserfeatures.errors import SourceError
from laserfeatures.evaluation import match_corners
from laserfeatures.evaluation.true_lines import cross
from laserfeatures.sources import open_source
from laserfeatures.testbench.real import arena
from laserfeatures.testbench.real.survey import Survey, survey
from laserfeatures.testbench.real.view import View


@dataclass(frozen=True)
class Recording:
    """A log of real scans.

    Parameters
    ----------
    name : str
        What it is called here.
    path : str
        Where it is in the folder of recordings.
    truth : {"arena", "map", "none"}
        Where its truth comes from: the known square, a plan of all its scans, or nowhere.
    """

    name: str
    path: str
    truth: str


RECORDINGS = (
    Recording("arena", "urg/brenner_robot4", "arena"),
    Recording("flirt", "sick/flirt_mit-cscail.log.gz", "map"),
    Recording("csail", "sick/csail-corrected.log.gz", "map"),
    Recording("aces", "sick/aces-corrected.log.gz", "map"),
    Recording("freiburg-101", "sick/freiburg-101-corrected.log.gz", "map"),
    Recording("belgioioso", "sick/belgioioso-corrected.log.gz", "map"),
    Recording("seattle", "sick/seattle-corrected.log.gz", "map"),
    Recording("orebro", "sick/orebro-corrected.log.gz", "map"),
    Recording("breezy", "urg/breezy_exp1.dat.gz", "none"),
    Recording("legtracker", "rosbag/legtracker_demo_stationary_simple_environment.bag", "none"),
    Recording("cartographer", "rosbag/cartographer_data_hokuyo.bag", "none"),
    *(Recording(f"frm {k}", f"urg/frm_g5_Scan{k}.csv.gz", "none") for k in (1, 2, 3)),
)


@dataclass(frozen=True, eq=False)
class Drawing:
    """What a picture of a map shows, all in the map's frame [m].

    Parameters
    ----------
    points : (P, 2) array
        The points of the scans where they fit.
    walls : (W, 2, 2) array
        Both ends of each wall.
    corners : (K, 2) array
        The real corners that some scan shows.
    """

    points: FloatArray
    walls: FloatArray
    corners: FloatArray


@dataclass(frozen=True, eq=False)
class Known:
    """A recording and what is known of it.

    Parameters
    ----------
    scans : list of LaserScan
        All its scans.
    views : dict of int to View
        What is true of each scan by its number, where that is known.
    facts : dict
        What a reader wants to know of the truth.
    drawing : Drawing or None
        The map, where there is one.
    """

    scans: list[LaserScan]
    views: dict[int, View]
    facts: dict[str, Any]
    drawing: Drawing | None = None


def load(folder: Path, recording: Recording) -> Known:
    """Read a recording and find out what is true of its scans.

    Raises
    ------
    SourceError
        If it cannot be read, or has no corrected poses where these are needed.
    MissingDependencyError
        If it is a bag and rosbags is not installed, or SciPy is missing.
    """
    path = folder / recording.path
    with open_source(path) as source:
        scans = list(source)
        poses = source.poses
    facts: dict[str, Any] = {
        "recording": recording.name, "truth": recording.truth, "scans": len(scans)
    }  # fmt: skip
    if recording.truth == "none":
        return Known(scans, {}, facts)
    if recording.truth == "arena":
        views = dict(enumerate(arena.views(path, scans)))
        return Known(scans, views, facts | _facts(list(views.values())))
    if poses != "corrected":
        raise SourceError(f"{path}: expected corrected poses to draw a map from, got {poses!r}")
    drawn = survey(scans)
    fitting = [number for number, fit in enumerate(drawn.fits) if fit]
    views = dict(zip(fitting, drawn.views, strict=True))
    facts |= _facts(drawn.views) | {
        "walls": len(drawn.plan.ends),
        "residual": float(np.median([fit.residual for fit in drawn.fits if fit] or [np.nan])),
    }
    return Known(scans, views, facts | _held_out(scans, views), _drawing(drawn))


def _facts(views: Sequence[View]) -> dict[str, Any]:
    returns = sum(int(view.scan.valid.sum()) for view in views)
    return {
        "used": len(views),
        "without_corners": sum(not len(view.truth.corners) for view in views),
        "true_lines": sum(view.truth.theta.size for view in views),
        "true_corners": sum(len(view.truth.corners) for view in views),
        "real_corners": sum(int(view.truth.real.sum()) for view in views),
        "unsure_corners": sum(len(view.unsure) for view in views),
        "known_share": sum(int(view.known.sum()) for view in views) / max(returns, 1),
    }


def _held_out(scans: Sequence[LaserScan], views: dict[int, View]) -> dict[str, Any]:
    """Return what becomes of the truth of the odd scans where the map is of the even ones alone.

    "held_out_again" is the share of its corners within 0.2 m of a crossing in the map of all.
    """
    other = survey(scans[1::2], drawn=scans[::2])
    numbers = [1 + 2 * k for k, fit in enumerate(other.fits) if fit]
    true = again = 0
    gaps = [np.empty(0)]
    for number, view in zip(numbers, other.views, strict=True):
        if number in views:
            full = views[number].truth
            one, two = view.truth.corners, cross(full.theta, full.d)[0]
            first, second = match_corners(one, two)
            gaps.append(np.hypot(*(one[first] - two[second]).T))
            true += len(one)
            again += first.size
    apart = np.concatenate(gaps)
    return {
        "held_out_used": len(numbers) / max(len(scans) // 2, 1),
        "held_out_again": again / true if true else np.nan,
        "held_out_median": float(np.median(apart)) if apart.size else np.nan,
    }


def _drawing(drawn: Survey) -> Drawing:
    poses = [fit.pose for fit in drawn.fits if fit]
    placed = list(zip(poses, drawn.views, strict=True))
    none = np.empty((0, 2))
    points = [pose.transform(view.scan.points) for pose, view in placed]
    corners = [pose.transform(view.truth.corners[view.truth.real]) for pose, view in placed]
    return Drawing(
        points=np.concatenate([none, *points]),
        walls=drawn.plan.ends,
        corners=np.unique(np.concatenate([none, *corners]).round(3), axis=0),
    )
