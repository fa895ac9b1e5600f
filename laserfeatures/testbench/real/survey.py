"""From the scans of a log with corrected poses to what is true of each."""

from collections.abc import Sequence
from dataclasses import dataclass

from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.testbench.real.alignment import Fit, Locator
from laserfeatures.testbench.real.mapped import view_in
from laserfeatures.testbench.real.plan import Plan, plan_of
from laserfeatures.testbench.real.view import View

ROUNDS = 3  # plans drawn: each but the first with the scans where they fit the one before


@dataclass(frozen=True, eq=False)
class Survey:
    """A plan and the scans that were laid on it.

    Parameters
    ----------
    plan : Plan
        The plan.
    fits : list of Fit or None
        Where each scan fits; None where it does not.
    views : list of View
        What is true of the scans that fit, in their order.
    """

    plan: Plan
    fits: list[Fit | None]
    views: list[View]


def survey(scans: Sequence[LaserScan], drawn: Sequence[LaserScan] | None = None) -> Survey:
    """Draw the plan of a building from all its scans, and lay each scan on it.

    The plan is drawn from raw points at the poses of the log; no extractor has a part in it. Each
    scan is then laid on it, the plan drawn again from the scans where they fit, and each scan laid
    on that.

    Parameters
    ----------
    scans : sequence of LaserScan
        All scans, with corrected poses.
    drawn : sequence of LaserScan, optional
        The scans that the plan is drawn from, if not from all: to hold some out.

    Raises
    ------
    ValueError
        If a scan has no pose.
    MissingDependencyError
        If SciPy is missing.

    Notes
    -----
    The plan has what is straight, at least 0.4 m long, flat to 2 cm and seen by at least four
    scans: the flat side of a cupboard is a wall too. It lacks people, clutter, glass, what was seen
    from one or two places only, and curved walls; of these, chords shorter than a metre may remain.
    Walls that end within 4 cm of one line are one line, so that shallow recesses are lost. How the
    scans before bent the map stays in it; a scan's own view of it is right to some centimetres.
    """
    drawn = scans if drawn is None else drawn
    poses = [_pose_of(scan) for scan in drawn]
    for _ in range(ROUNDS - 1):
        fits = _located(Locator(plan_of(drawn, poses)), drawn)
        poses = [fit.pose if fit else pose for fit, pose in zip(fits, poses, strict=True)]
    locator = Locator(plan_of(drawn, poses))
    fits = _located(locator, scans)
    views = [view_in(locator, scan, fit.pose) for scan, fit in zip(scans, fits, strict=True) if fit]
    return Survey(locator.plan, fits, views)


def _located(locator: Locator, scans: Sequence[LaserScan]) -> list[Fit | None]:
    return [locator.locate(scan, _pose_of(scan)) for scan in scans]


def _pose_of(scan: LaserScan) -> Pose2D:
    if scan.pose is None:
        raise ValueError(
            "every scan of a survey needs its pose in the map, got a scan whose pose is None"
        )
    return scan.pose
