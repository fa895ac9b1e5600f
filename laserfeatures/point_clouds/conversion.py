"""Scans and features as Open3D's geometries, and back.

Clouds are in the scan's frame, in metres, at one height. What lies in the plane comes back to the
last bit: Open3D keeps float64.
"""

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Features
from laserfeatures.point_clouds.library import of_type, open3d
from laserfeatures.scan import LaserScan

if TYPE_CHECKING:
    from open3d.geometry import LineSet, PointCloud

TURN = 2 * math.pi
ON_BEAM = 1e-6  # [rad]; files of float32 place a point within 1e-7


def scan_to_point_cloud(scan: LaserScan, *, height: float = 0.0) -> "PointCloud":
    """Return the returns of a scan as a cloud.

    Parameters
    ----------
    scan : LaserScan
        The scan; beams without return leave no point.
    height : float
        The points' z [m].

    Raises
    ------
    MissingDependencyError
        If Open3D is not installed.

    See Also
    --------
    point_cloud_to_points : gives `scan.points` back, bit by bit.
    point_cloud_to_scan : gives a scan back.
    """
    return open3d().geometry.PointCloud(_vectors(scan.points, height))


def features_to_line_set(features: Features, *, height: float = 0.0) -> "LineSet":
    """Return the segments of a scan's features as lines, each with two points of its own.

    Parameters
    ----------
    features : Features
        What an extractor found.
    height : float
        The lines' z [m].

    Raises
    ------
    MissingDependencyError
        If Open3D is not installed.

    See Also
    --------
    line_set_to_endpoints : gives `features.segments.endpoints` back, bit by bit.
    """
    o3d = open3d()
    ends = features.segments.endpoints.reshape(-1, 2)
    pairs = np.arange(len(ends), dtype=np.int32).reshape(-1, 2)
    return o3d.geometry.LineSet(_vectors(ends, height), o3d.utility.Vector2iVector(pairs))


def corners_to_point_cloud(features: Features, *, height: float = 0.0) -> "PointCloud":
    """Return the corners of a scan's features, real and virtual, as a cloud.

    Parameters
    ----------
    features : Features
        What an extractor found.
    height : float
        The points' z [m].

    Raises
    ------
    MissingDependencyError
        If Open3D is not installed.

    See Also
    --------
    point_cloud_to_points : gives `features.corners.positions` back, bit by bit.
    """
    return open3d().geometry.PointCloud(_vectors(features.corners.positions, height))


def point_cloud_to_points(cloud: "PointCloud") -> FloatArray:
    """Return x and y of a cloud's points, (P, 2) [m], in their order.

    Raises
    ------
    TypeError
        If `cloud` is no ``open3d.geometry.PointCloud``.
    MissingDependencyError
        If Open3D is not installed.
    """
    points: FloatArray = np.array(of_type(cloud, "PointCloud").points)[:, :2]
    return points


def line_set_to_endpoints(line_set: "LineSet") -> FloatArray:
    """Return x and y of both ends of each line, (S, 2, 2) [m], in their order.

    Raises
    ------
    TypeError
        If `line_set` is no ``open3d.geometry.LineSet``.
    ValueError
        If a line names a point that is not there.
    MissingDependencyError
        If Open3D is not installed.
    """
    line_set = of_type(line_set, "LineSet")
    points, lines = np.asarray(line_set.points), np.asarray(line_set.lines)
    if lines.size and not (lines.min() >= 0 and lines.max() < len(points)):
        raise ValueError(
            f"lines must join points 0 to {len(points) - 1} of the line set, "
            f"got {lines.min()} to {lines.max()}"
        )
    endpoints: FloatArray = points[lines][..., :2]
    return endpoints


def point_cloud_to_scan(
    cloud: "PointCloud", *, angles: ArrayLike | None = None, **rest: Any
) -> LaserScan:
    """Return a flat cloud as the scan whose returns its points are, seen from the origin.

    The inverse of `scan_to_point_cloud`. Without `angles` each point makes a beam, in (-pi, pi] and
    right within rounding (1e-12 rad and m); beams that had no return are lost. With the angles of
    the scan all its beams are there, at those very angles.

    Parameters
    ----------
    cloud : open3d.geometry.PointCloud
        The points [m] at any height; those that are not finite or right at the origin are left out.
    angles : (N,) array, optional
        The beams [rad]. Each point must lie on one of them; those without a point have no return.
    **rest
        The other fields of `LaserScan`.

    Raises
    ------
    TypeError
        If `cloud` is no ``open3d.geometry.PointCloud``.
    ValueError
        As `LaserScan`, and if a point lies on none of the beams.
    MissingDependencyError
        If Open3D is not installed.

    Notes
    -----
    Of several points on one beam the nearest counts. For a cloud of more than a plane there is
    `slice_point_cloud`, which looks for surfaces.
    """
    points = point_cloud_to_points(cloud)
    points = points[np.isfinite(points).all(axis=1) & points.any(axis=1)]
    directions = np.arctan2(points[:, 1], points[:, 0])
    if angles is None:
        beams, beam = np.unique(directions, return_inverse=True)
    else:
        beams = np.asarray(angles, dtype=np.float64)
        beam = _beam_of(directions, beams)
    ranges = np.full(beams.shape, np.inf)
    np.minimum.at(ranges, beam, np.hypot(points[:, 0], points[:, 1]))
    return LaserScan(angles=beams, ranges=ranges, **rest)


def _beam_of(directions: FloatArray, angles: FloatArray) -> IntArray:
    """Return the index of the beam that each direction [rad] lies on, whole turns apart."""
    LaserScan(angles=angles, ranges=np.zeros_like(angles))  # checks them
    if not angles.size:
        if directions.size:
            raise ValueError(f"angles must be those of {directions.size} points, got none")
        return np.empty(0, np.int64)
    angles = angles - TURN * np.round((angles[0] + angles[-1]) / (2 * TURN))
    middle = (angles[0] + angles[-1]) / 2
    turns = (directions < middle - math.pi).astype(float) - (directions > middle + math.pi)
    directions = directions + TURN * turns  # both ends of a full turn stay what they are
    beam: IntArray = np.searchsorted((angles[1:] + angles[:-1]) / 2, directions)
    off = np.abs(directions - angles[beam])
    if off.max(initial=0.0) > ON_BEAM:
        i = int(np.argmax(off))
        raise ValueError(
            f"each point must lie on one of the beams, got one at {directions[i]:.6g} rad, "
            f"{off[i]:.2g} rad off the nearest; leave out angles to make each point a beam"
        )
    return beam


def _vectors(points: FloatArray, height: float) -> Any:
    flat = np.full((len(points), 3), height, dtype=np.float64)
    flat[:, :2] = points
    return open3d().utility.Vector3dVector(flat)
