"""Where in a plan a scan was taken: its raw points laid on the walls."""

import math
from typing import NamedTuple

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import LaserScan, Pose2D
from laserfeatures.testbench.real.cloud import near_points, tree_of
from laserfeatures.testbench.real.plan import Plan

GATES = (0.3, 0.3, 0.2, 0.2, 0.1, 0.1, 0.1)  # [m], of points from walls, one step after the other
NOISE = 0.02  # [m], of a point from its wall
TRUST = np.array((0.1, 0.1, math.radians(1)))  # [m, m, rad], standard deviation of the given pose
MOST = 0.3, math.radians(3)  # [m, rad], of a correction
NEAR = 0.05  # [m]; a point this near to its wall fits
LEAST_SHARE = 0.4  # of the points that must fit
LEAST_POINTS = 30


class Fit(NamedTuple):
    """A scan laid on a plan.

    Parameters
    ----------
    pose : Pose2D
        Where it was taken.
    residual : float
        Median distance of the points that fit from their walls [m].
    """

    pose: Pose2D
    residual: float


class Locator:
    """Lays scans on a plan.

    Parameters
    ----------
    plan : Plan
        The plan.

    Raises
    ------
    MissingDependencyError
        If SciPy is missing.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._tree = tree_of(plan.cells)
        self._normal = np.stack([np.cos(plan.theta), np.sin(plan.theta)], axis=1)

    def locate(self, scan: LaserScan, pose: Pose2D) -> Fit | None:
        """Return where a scan fits, near a pose; None if it does not within 0.3 m and 3 degrees.

        Points are drawn to the lines of the walls beside them, with a Cauchy loss of 2 cm. The pose
        that came counts as a measurement (10 cm, 1 degree), so that a corridor, which says nothing
        of the way along it, leaves that as it is.

        References
        ----------
        Chen and Medioni 1992, *Object modelling by registration of multiple range images*.
        """
        points = near_points(scan)
        if len(points) < LEAST_POINTS or not self.plan.theta.size:
            return None
        start = np.array((pose.x, pose.y, pose.theta))
        now = start.copy()
        for gate in GATES:
            now += self._step(now, start, points, gate)
        moved = now - start
        if math.hypot(*moved[:2]) > MOST[0] or abs(moved[2]) > MOST[1]:
            return None
        at = Pose2D(*now.tolist())
        wall, off = self.nearest(at.transform(points), GATES[-1])
        off = abs(off[(wall >= 0) & (abs(off) < NEAR)])
        if off.size < LEAST_SHARE * len(points):
            return None
        return Fit(at, float(np.median(off)))

    def nearest(self, points: FloatArray, gate: float) -> tuple[IntArray, FloatArray]:
        """Return the wall within `gate` metres of each point of the map's frame, or -1.

        Also the distance of each point from the line of that wall, signed [m].
        """
        away, cell = self._tree.query(points, distance_upper_bound=gate)
        wall = np.where(np.isfinite(away), np.append(self.plan.wall, -1)[cell], -1)
        line = self.plan.line[wall]
        return wall, (points * self._normal[line]).sum(axis=1) - self.plan.d[line]

    def _step(
        self, now: FloatArray, start: FloatArray, points: FloatArray, gate: float
    ) -> FloatArray:
        world = Pose2D(*now.tolist()).transform(points)
        wall, off = self.nearest(world, gate)
        on = wall >= 0
        normal = self._normal[self.plan.line[wall[on]]]
        arm = world[on] - now[:2]
        turning = normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]
        jacobian = np.column_stack([normal, turning])
        weighted = jacobian.T / (NOISE**2 + off[on] ** 2)
        prior = np.diag(TRUST**-2.0)
        pull = weighted @ off[on] + prior @ (now - start)
        step: FloatArray = -np.linalg.solve(weighted @ jacobian + prior, pull)
        return step
