"""Trajectories to hold others against: of corrected logs, files and cameras."""

from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from laserfeatures.data import Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.mapping.brenner_reference import (
    is_brenner_reference,
    read_brenner_reference,
    reference_in,
)
from laserfeatures.mapping.corrected_table import is_corrected_table, read_corrected_table
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.mapping.tum import is_tum, read_tum
from laserfeatures.sources import open_source
from laserfeatures.sources.brenner import scan_files
from laserfeatures.sources.files import read_head

NOWHERE = Pose2D(*[float("nan")] * 3)
Read = Callable[[Path], Trajectory]
# What tells a file by its first bytes, what reads it, and what it is.
FILES: tuple[tuple[Callable[[bytes], bool], Read, str], ...] = (
    (is_tum, read_tum, "a trajectory in TUM format"),
    (is_brenner_reference, read_brenner_reference, "positions of a marker, seen from overhead"),
    (is_corrected_table, read_corrected_table, "corrected poses of a table"),
)


@dataclass(frozen=True)
class Reference:
    """A trajectory to hold others against.

    Parameters
    ----------
    trajectory : Trajectory
        It; where only positions are known, the headings are nan.
    path : Path
        Where it came from.
    what : str
        What it is, for a reader.
    """

    trajectory: Trajectory
    path: Path
    what: str


def read_reference(path: str | PathLike[str]) -> Reference:
    """Read a reference.

    Parameters
    ----------
    path : str or PathLike
        A trajectory in TUM format; a log whose poses are corrected, or a plan or example, of whose
        robot the true poses are taken; a table with corrected poses; a reference of Brenner's
        lecture, or the folder that holds it.

    Raises
    ------
    SourceError
        If it cannot be read, or its poses are raw odometry, or it has none.
    MissingDependencyError
        If it is a plan, and mujoco is not installed.
    """
    path = Path(path)
    if path.is_dir() and scan_files(path):
        path = reference_in(path)
    if path.is_file():
        head = read_head(path)
        for is_it, read, what in FILES:
            if is_it(head):
                return Reference(read(path), path, what)
    with open_source(path, poses="corrected") as log:
        scans = [(scan.stamp, scan.pose or NOWHERE) for scan in log]
        simulated = log.format in {"plan", "example"}
        what = "the true poses of a simulated robot" if simulated else "corrected poses"
    trajectory = Trajectory.of([stamp for stamp, _ in scans], [pose for _, pose in scans])
    if all(pose is NOWHERE for _, pose in scans):
        raise SourceError(f"{path}: expected poses, got none in any of {len(scans)} scans")
    return Reference(trajectory, path, what)
