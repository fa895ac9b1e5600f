"""Open3D in and out: scans and features as clouds and back, and 3D clouds as scans.

Open3D (extra `open3d`) is imported when one of these functions needs it, not before.
"""

from laserfeatures.point_clouds.conversion import (
    corners_to_point_cloud,
    features_to_line_set,
    line_set_to_endpoints,
    point_cloud_to_points,
    point_cloud_to_scan,
    scan_to_point_cloud,
)
from laserfeatures.point_clouds.files import read_point_cloud
from laserfeatures.point_clouds.header import is_point_cloud
from laserfeatures.point_clouds.slicing import slice_point_cloud

__all__ = [
    "corners_to_point_cloud",
    "features_to_line_set",
    "is_point_cloud",
    "line_set_to_endpoints",
    "point_cloud_to_points",
    "point_cloud_to_scan",
    "read_point_cloud",
    "scan_to_point_cloud",
    "slice_point_cloud",
]
