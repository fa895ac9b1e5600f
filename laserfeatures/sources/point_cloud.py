"""3D point clouds (PCD, PLY): one scan, of the band of heights asked for.

Read with Open3D (extra `open3d`). The virtual scanner stands at the cloud's origin unless told
where; the scan has no stamp and no pose.
"""

import math
from dataclasses import replace

import numpy as np

from laserfeatures.data import Pose2D
from laserfeatures.errors import SourceError
from laserfeatures.point_clouds import read_point_cloud, slice_point_cloud
from laserfeatures.sources.log import Log, Scans


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
