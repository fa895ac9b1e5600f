"""A room as a 3D point cloud, made with Open3D, and where its corners truly are."""

import numpy as np
import pytest

o3d = pytest.importorskip("open3d", reason="the extra open3d is not installed")

SENSOR = np.array([2.5, 1.5, 0.0])  # the cloud's origin, in the room
BAND = (0.3, 0.5)
# A room of 6 m x 4 m with a cupboard in a corner, which hides the corner at (6, 4).
BOXES = [
    ((6.0, 4.0, 2.5), (0.0, 0.0, 0.0)),
    ((1.8, 1.2, 2.5), (4.2, 2.8, 0.0)),
]
# Above and below the band: a table top, right over the sensor, and a box on the floor.
FURNITURE = [
    ((2.0, 1.2, 0.05), (1.5, 1.0, 0.7)),
    ((1.0, 0.6, 0.25), (0.8, 2.2, 0.0)),
]
X_WALLS, Y_WALLS = (0.0, 4.2, 6.0), (0.0, 2.8, 4.0)
REAL = {(0.0, 0.0), (6.0, 0.0), (0.0, 4.0), (4.2, 4.0), (4.2, 2.8), (6.0, 2.8)}
CROSSINGS = np.array([(x, y) for x in X_WALLS for y in Y_WALLS]) - SENSOR[:2]
IS_REAL = np.array([(x, y) in REAL for x in X_WALLS for y in Y_WALLS])


def box(size, corner):
    return o3d.geometry.TriangleMesh.create_box(*size).translate(corner)


def room(*, sigma=0.0, points_per_m2=2000.0, seed=0):
    """Return a cloud of the room's surfaces, floor and ceiling among them, seen from SENSOR."""
    o3d.utility.random.seed(seed)
    cloud = o3d.geometry.PointCloud()
    for size, corner in BOXES + FURNITURE:
        mesh = box(size, corner)
        cloud += mesh.sample_points_uniformly(int(points_per_m2 * mesh.get_surface_area()))
    points = np.asarray(cloud.points)
    points = points[~((points[:, 0] > 4.2) & (points[:, 1] > 2.8))]  # no lidar sees into it
    noise = np.random.default_rng(seed).normal(0.0, sigma, points.shape)
    return cloud_of(points - SENSOR + noise)


def cloud_of(points):
    points = np.asarray(points, dtype=float).reshape(-1, 3)
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))


def check_corners(positions, real, tolerance=0.01):
    """Check that the corners are those of the room, all of them, each once, and real or virtual."""
    off = np.hypot(*(np.asarray(positions)[:, None] - CROSSINGS[None]).transpose(2, 0, 1))
    assert sorted(off.argmin(axis=1)) == list(range(len(CROSSINGS)))
    np.testing.assert_array_equal(real, IS_REAL[off.argmin(axis=1)])
    # A virtual one is up to 4 m from the wall of 1.2 m that it prolongs.
    assert (off.min(axis=1) < np.where(real, tolerance, 3 * tolerance)).all()
