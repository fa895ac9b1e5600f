"""A band of heights of a 3D point cloud as the scan of a virtual 2D scanner.

A bin of directions is a beam. The points of a bin, sorted by range, are cut into surfaces where one
is more than a gap behind the one before, and the beam returns the mean of the nearest surface. The
mean of points on a plane lies on that plane: a noisy wall stays where it is, also one seen aslant
that fills a bin over a stretch of ranges, where its nearest point would stand before it. In a bin
with an edge the mean hangs in the air between two faces: there, told by the scatter, the point
nearest to the mean stands for it.
"""

import math
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray, unmasked
from laserfeatures.point_clouds.library import of_type
from laserfeatures.scan import LaserScan, Pose2D

if TYPE_CHECKING:
    from open3d.geometry import PointCloud

ORIGIN = Pose2D(0.0, 0.0, 0.0)
ENOUGH = 5  # points of a surface that tell how much surfaces scatter
EDGE = 1.5  # times the median scatter
CLEARANCE = 0.05  # [m]; a scanner that has points nearer stands on a wall of the cloud


def slice_point_cloud(
    cloud: "PointCloud | FloatArray",
    low: float,
    high: float,
    *,
    origin: Pose2D = ORIGIN,
    beams: int = 720,
    max_gap: float = 0.05,
    min_points: int = 3,
    range_max: float = math.inf,
) -> LaserScan:
    """Scan a band of heights of a 3D cloud with a virtual scanner.

    Points that are not finite are left out.

    Parameters
    ----------
    cloud : open3d.geometry.PointCloud or (N, 3) array
        The points [m], z upward.
    low, high : float
        The band [m]: a point belongs to it if ``low <= z < high``.
    origin : Pose2D
        Where the scanner stands and looks in the cloud; the scan's `pose`.
    beams : int
        Number of beams in a full turn, at least 3. A beam that hits something points to it, one
        that does not to the middle of its bin.
    max_gap : float
        Points of a beam that lie at most this far behind one another [m] are one surface; what
        lies behind it is hidden.
    min_points : int
        A surface of fewer points is passed over as stray if a farther one in the same beam has as
        many, so that single flying points do not replace the wall behind them. 1 to believe all.
    range_max : float
        Range of the scanner [m].

    Returns
    -------
    LaserScan
        One sweep from -pi to pi, its angles irregular, without a stamp.

    Raises
    ------
    TypeError
        If `cloud` is neither.
    ValueError
        If a parameter makes no sense, the cloud holds no finite point, or none lies in the band;
        the message says which heights the cloud spans; or if the scanner stands on a surface.

    Examples
    --------
    >>> wall = np.array([[2.0, y / 100, 0.4] for y in range(-10, 11)])
    >>> scan = slice_point_cloud(wall, 0.3, 0.5, beams=8)
    >>> scan.points.round(12).tolist()
    [[2.0, -0.055], [2.0, 0.05]]
    """
    _check(low, high, beams, max_gap, min_points)
    x, y = _band(_positions(cloud), low, high)
    x, y = x - origin.x, y - origin.y
    c, s = math.cos(origin.theta), math.sin(origin.theta)
    x, y = c * x + s * y, c * y - s * x
    ranges = np.hypot(x, y)
    _check_clearance(ranges, origin, min_points)
    seen = (ranges > 0) & (ranges < range_max)
    x, y, ranges = x[seen], y[seen], ranges[seen]

    edges = np.linspace(-math.pi, math.pi, beams + 1)
    bins = np.searchsorted(edges[1:-1], np.arctan2(y, x), side="right")
    order = np.argsort(bins + ranges / (2 * ranges.max(initial=1.0)))  # by bin, then by range
    bins, ranges, x, y = bins[order], ranges[order], x[order], y[order]
    first = np.ones(bins.size, dtype=np.bool_)  # of a surface
    first[1:] = (bins[1:] != bins[:-1]) | (ranges[1:] - ranges[:-1] > max_gap)
    bins, counts = bins[first], np.diff(np.flatnonzero(first), append=bins.size)
    hit = _nearest(bins, counts, min_points)
    seen = np.repeat(hit, counts)
    bins = bins[hit]
    x, y = _returns(x[seen], y[seen], counts[hit])

    angles, distances = (edges[:-1] + edges[1:]) / 2, np.full(beams, np.inf)
    # A mean may leave its bin by rounding.
    angles[bins] = np.clip(np.arctan2(y, x), edges[bins], np.nextafter(edges[bins + 1], -np.inf))
    distances[bins] = np.hypot(x, y)
    return LaserScan(angles=angles, ranges=distances, range_max=range_max, pose=origin)


def _check(low: float, high: float, beams: int, max_gap: float, min_points: int) -> None:
    if not low < high:
        raise ValueError(f"the band must be low < high [m], got {low!r} and {high!r}")
    if not beams >= 3:
        raise ValueError(f"beams must be >= 3, got {beams!r}")
    if not max_gap > 0:
        raise ValueError(f"max_gap must be > 0 m, got {max_gap!r}")
    if not min_points >= 1:
        raise ValueError(f"min_points must be >= 1, got {min_points!r}")


def _check_clearance(ranges: FloatArray, origin: Pose2D, min_points: int) -> None:
    near = int((ranges < CLEARANCE).sum())
    if near >= min_points:
        raise ValueError(
            f"expected the scanner to stand clear, got {near} points of the band within "
            f"{CLEARANCE} m of x, y = {origin.x:g}, {origin.y:g} m, where it stands: a wall, "
            "or the floor if the band reaches down to it"
        )


def _positions(cloud: "PointCloud | FloatArray") -> FloatArray:
    """Return the finite points of a cloud or array, (N, 3)."""
    if not isinstance(cloud, np.ndarray):
        cloud = np.asarray(of_type(cloud, "PointCloud", " or (N, 3) array").points)
    cloud = np.asarray(unmasked(cloud))
    if cloud.ndim != 2 or cloud.shape[1] != 3:
        raise ValueError(f"points must have shape (n, 3), got {cloud.shape}")
    finite: FloatArray = cloud[np.isfinite(cloud).all(axis=1)].astype(np.float64, copy=False)
    if not finite.size:
        raise ValueError(f"expected finite points, got none among {len(cloud)} points")
    return finite


def _band(points: FloatArray, low: float, high: float) -> tuple[FloatArray, FloatArray]:
    """Return x and y of the points in the band of heights."""
    x, y, z = points.T
    inside = (z >= low) & (z < high)
    if not inside.any():
        raise ValueError(
            f"expected points with {low:g} <= z < {high:g} m, got none: "
            f"the {len(z)} points of the cloud span z = {z.min():.3f} .. {z.max():.3f} m"
        )
    return x[inside], y[inside]


def _nearest(bins: IntArray, counts: IntArray, min_points: int) -> BoolArray:
    """Return which surfaces their bins show: the nearest that are not stray."""
    largest = np.zeros(bins.max(initial=-1) + 1, dtype=np.int64)
    np.maximum.at(largest, bins, counts)
    solid = np.flatnonzero(counts >= np.minimum(min_points, largest[bins]))
    _, nearest = np.unique(bins[solid], return_index=True)
    hit = np.zeros(bins.size, dtype=np.bool_)
    hit[solid[nearest]] = True
    return hit


def _returns(x: FloatArray, y: FloatArray, counts: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the point that stands for each surface, of so many of the points each."""
    starts = np.cumsum(counts) - counts
    mean_x, mean_y = np.add.reduceat(x, starts) / counts, np.add.reduceat(y, starts) / counts
    dx, dy = x - np.repeat(mean_x, counts), y - np.repeat(mean_y, counts)
    xx, xy, yy = (np.add.reduceat(part, starts) / counts for part in (dx * dx, dx * dy, dy * dy))
    scatter = (xx + yy) / 2 - np.hypot((xx - yy) / 2, xy)  # variance across the surface
    many = counts >= ENOUGH
    usual = np.median(scatter[many]) if many.any() else math.inf
    for i in np.flatnonzero(scatter > EDGE**2 * usual):
        own = slice(starts[i], starts[i] + counts[i])
        nearest = starts[i] + np.argmin(dx[own] ** 2 + dy[own] ** 2)
        mean_x[i], mean_y[i] = x[nearest], y[nearest]
    return mean_x, mean_y
