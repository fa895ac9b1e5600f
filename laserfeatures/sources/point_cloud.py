"""3D point clouds (PCD, PLY): one scan, of the band of heights asked for.

Read with Open3D (extra `open3d`). The virtual scanner stands at the cloud's origin unless told
where; the scan has no stamp and no pose.
"""

import math
from dataclasses import replace

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.point_clouds import read_point_cloud, slice_point_cloud
from laserfeatures.sources.log import Log, Scans

FAR = 100.0  # [m] from a cloud, at which a scanner is out of place


def read_cloud(log: Log) -> Scans:
    """Yield the scan of a cloud.

    Raises
    ------
    MissingDependencyError
        If Open3D is not installed.
    SourceError
        If the cloud cannot be read, no band is given, none of its points lies in the band, or the
        scanner stands on some.
    """
    cloud = read_point_cloud(log.path)
    if log.slice_band is None:
        heights = np.asarray(cloud.points)[:, 2]
        heights = heights[np.isfinite(heights)]
        raise SourceError(
            f"{log.path}: expected a band of heights, got none: the cloud spans "
            f"z = {heights.min():.3f} .. {heights.max():.3f} m; choose one with "
            "slice_band=(low, high) (--slice LOW..HIGH)"
        )
    if log.slice_origin is None:
        _check_near(log, np.asarray(cloud.points))
    try:
        scan = slice_point_cloud(
            cloud,
            *log.slice_band,
            origin=Pose2D(*(log.slice_origin or (0.0, 0.0)), 0.0),
            range_max=log.range_max or math.inf,
        )
    except ValueError as error:
        raise SourceError(
            f"{log.path}: {error}; choose others with slice_band= (--slice), slice_origin= "
            "(--origin)"
        ) from error
    yield replace(scan, pose=None)


def _check_near(log: Log, points: FloatArray) -> None:
    """Raise a SourceError if a scanner at 0, 0 is far from a cloud, as from one in UTM."""
    flat = points[np.isfinite(points).all(axis=1)][:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    away = float(np.hypot(*np.maximum(np.maximum(low, -high), 0.0)))
    if away > FAR and away > 3 * float(np.hypot(*(high - low))):
        (x0, y0), (x1, y1) = low.tolist(), high.tolist()
        raise SourceError(
            f"{log.path}: expected a cloud around the scanner at 0, 0, got one {away:.0f} m away: "
            f"x = {x0:.2f} .. {x1:.2f} m, y = {y0:.2f} .. {y1:.2f} m; say where the scanner "
            "stands with slice_origin=(x, y) (--origin X,Y)"
        )
