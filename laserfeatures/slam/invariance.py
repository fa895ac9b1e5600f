"""What a correction does to errors that no measurement can tell: of where the map's frame is.

A plain EKF linearises each measurement where the estimate is just then. The Jacobians of different
moments do not agree on which motion of pose and map together cannot be seen, and the filter thinks
that it learns the heading out of nothing. Here the covariance is that of errors in which such a
motion is the same wherever the estimate is, those of the right-invariant EKF: position and corners
turn with the heading. It is kept in the usual numbers, and carried over after each correction.

References
----------
Huang, Mourikis and Roumeliotis, Observability-Based Rules for Designing Consistent EKF SLAM
Estimators, IJRR 29(5), 2010.
Barrau and Bonnabel, An EKF-SLAM Algorithm with Consistency Properties, arXiv:1510.06263, 2015.
"""

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.slam.state import EACH, POSE


def carried_over(
    before: FloatArray, after: FloatArray, is_wall: BoolArray, anchors: FloatArray
) -> FloatArray:
    """Return D (n, 3): an error e of the state before is e + D e[:3] after.

    Parameters
    ----------
    before, after : (n,) arrays
        The state's mean.
    is_wall : (L,) bool array
        Which landmarks are walls.
    anchors : (L, 2) array
        The landmarks' anchors.

    Notes
    -----
    An error t, a of position and heading moves the frame's points x by t + a J (x - p), where p is
    the position. A corner l's and the pose's own part is left as they move by l', p':
    a J (l' - l). A wall's rho changes with its anchor q by n (t + a J (q - p)): the part left is
    that of n' - n.
    """
    change = np.zeros((len(before), POSE))
    moved = after - before
    change[0, 2], change[1, 2] = -moved[1], moved[0]
    first = POSE + EACH * np.arange(len(is_wall))
    corner = first[~is_wall]
    change[corner, 2], change[corner + 1, 2] = -moved[corner + 1], moved[corner]
    wall = first[is_wall]
    normal = _normals(after[wall]) - _normals(before[wall])
    x, y = (anchors[is_wall] - before[:2]).T
    change[wall + 1, :2] = normal
    change[wall + 1, 2] = normal[:, 1] * x - normal[:, 0] * y
    return change


def _normals(alpha: FloatArray) -> FloatArray:
    return np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
