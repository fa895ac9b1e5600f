"""Plans for a simulated robot (`.toml`): it drives while the scans are read (extra `sim`).

The scans are those that the robot of `simulation.robot` makes on its way along the way-points of
the plan's [drive] table; their poses are the scanner's by wheel odometry, or its true ones where
corrected poses are asked for.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from os import PathLike

from laserfeatures.errors import SourceError
from laserfeatures.simulation import Scanner, read_plan
from laserfeatures.simulation.robot import DriveError, Reading, drive
from laserfeatures.sources.log import Log, Scans

# A table of a plan, or any table of TOML where the file starts with one: that may be misspelt.
TABLE = re.compile(
    rb"^[ \t]*\[\[?[ \t]*(wall|outline|box|pole|drive|scanner)[ \t]*\]\]?[ \t]*(#.*)?\r?$"
    rb"|\A(\s|#.*\n)*\[\[?[ \t]*[\w-]+[ \t]*\]\]?[ \t]*(#.*)?\r?$",
    re.MULTILINE,
)


def is_plan(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a plan."""
    return TABLE.search(head) is not None


def read_simulated(log: Log) -> Scans:
    """Yield the scans of the robot that drives as a plan says.

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    SourceError
        As `readings_of`.
    """
    log.poses = log.wanted or "odometry"
    for reading in readings_of(log.path):
        scan = reading.scan
        if log.poses == "corrected":
            scan = replace(scan, pose=reading.observation.pose)
        yield scan if log.range_max is None else replace(scan, range_max=log.range_max)


def readings_of(
    path: str | PathLike[str], *, seed: int | None = None, scanner: Scanner | None = None
) -> Iterator[Reading]:
    """Yield what a robot reads that drives as the plan at `path` says.

    Parameters
    ----------
    path : str or PathLike
        The plan.
    seed : int, optional
        In place of the plan's own.
    scanner : Scanner, optional
        In place of the plan's own.

    Raises
    ------
    MissingDependencyError
        If mujoco is not installed.
    SourceError
        If the plan cannot be read or has no drive, or the robot cannot make it.
    """
    plan = read_plan(path)
    if plan.drive is None:
        raise SourceError(
            f"{path}: expected a plan with a drive, got a world only; to drive a robot through it, "
            "add a table [drive] with waypoints = [[x, y], [x, y], ...]"
        )
    wanted = replace(
        plan.drive,
        seed=plan.drive.seed if seed is None else seed,
        scanner=scanner or plan.drive.scanner,
    )
    try:
        yield from drive(replace(plan, drive=wanted))
    except (DriveError, ValueError) as error:
        raise SourceError(f"{path}: {error}") from error
