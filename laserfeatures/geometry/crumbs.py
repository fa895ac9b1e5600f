"""Points that a wall has far from the rest of it, too few to be a piece of it."""

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.geometry.compiled import helper
from laserfeatures.geometry.fit import fit_line
from laserfeatures.geometry.walls import FREE, gather, keep_wall


@helper
def drop_crumbs(
    x: FloatArray,
    y: FloatArray,
    owner: IntArray,
    walls: FloatArray,
    member: IntArray,
    support: FloatArray,
    min_points: int,
) -> bool:
    """Free the points of segments that are too small to count, and refit their walls, in place.

    Such points are what a piece that was merged by chance leaves; so far off, one of them turns the
    line. `support` are the segments' numbers of points, whose `member` follow each other. Returns
    whether there were any.
    """
    small = False
    for points in support:
        small |= points < min_points
    if not small:
        return False
    mark = np.zeros(walls.shape[0], np.bool_)
    at = 0
    for points in support:
        end = at + int(points)
        if points < min_points:
            mark[owner[member[at]]] = True
            for i in member[at:end]:
                owner[i] = FREE
        at = end
    mine = np.empty(x.size, np.int64)
    for k in range(walls.shape[0]):
        if mark[k]:
            count = gather(owner, k, mine)
            walls[k, 5] = count
            if count >= min_points:
                keep_wall(walls[k], fit_line(x, y, mine[:count], walls[k, 0]), count)
    return True
