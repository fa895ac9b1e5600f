"""The oracle: what least squares finds that is told which beams belong to which wall."""

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.data import Features, LaserScan, Lines, LineSegments, PointFeatures
from laserfeatures.evaluation.true_lines import cross, normalised
from laserfeatures.evaluation.truth import Truth


def oracle(scan: LaserScan, truth: Truth) -> Features:
    """Return the total-least-squares line through exactly the beams of each true line, crossed.

    All crossings count that count as corners in the truth; none is withheld. There are no
    covariances (nan). `segments` holds one segment a line, of all its beams.
    """
    fits = [_fit(_points_of(scan, truth.line == k)) for k in range(truth.theta.size)]
    columns = np.array(fits).reshape(-1, 7)
    theta, d = normalised(columns[:, 0], columns[:, 1])
    count = len(fits)
    members = truth.line[None] == np.arange(count)[:, None]
    support = members.sum(axis=1).astype(np.float64)
    segments = LineSegments(
        lines=Lines(theta=theta, d=d, support=support, covariance=np.full((count, 2, 2), np.nan)),
        line=np.arange(count),
        endpoints=columns[:, 3:].reshape(-1, 2, 2),
        support=support,
        rms=columns[:, 2],
        points=members,
    )
    return Features(scan=scan, segments=segments, corners=_corners(theta, d))


def _corners(theta: FloatArray, d: FloatArray) -> PointFeatures:
    positions, pairs = cross(theta, d)
    turn = abs(theta[pairs[:, 0]] - theta[pairs[:, 1]])
    return PointFeatures(
        positions=positions,
        covariance=np.full((len(positions), 2, 2), np.nan),
        lines=pairs,
        angles=np.minimum(turn, np.pi - turn),
        real=np.zeros(len(positions), np.bool_),
    )


def _points_of(scan: LaserScan, beams: BoolArray) -> FloatArray:
    points: FloatArray = scan.ranges[beams, None] * scan.directions[beams]
    return points


def _fit(points: FloatArray) -> FloatArray:
    """Return theta, d, rms, and both ends of the total-least-squares line through points."""
    centre = points.mean(axis=0)
    _, spread, axes = np.linalg.svd(points - centre, full_matrices=False)
    along, normal = axes
    ends = centre + np.outer(((points - centre) @ along)[[0, -1]], along)
    rms = spread[-1] / np.sqrt(len(points))
    line = [np.arctan2(normal[1], normal[0]), centre @ normal, rms]
    return np.concatenate([line, ends.ravel()])
