"""The kernels that mend walls already found, as tests call them: copies in, results returned."""

import numpy as np
from kernels import _compiled, _xy

from laserfeatures.geometry import corner_points, crumbs, short_walls, walls


def counted(table, owner):
    """Return a copy of a table of walls with the numbers of points that owners imply."""
    table = table.copy()
    table[:, 5] = np.bincount(owner[owner >= 0], minlength=len(table))
    return table


def part_at_corners(points, owner, table, gate):
    """Return the owners afterwards and which walls changed."""
    owner, table, changed = owner.copy(), counted(table, owner), np.zeros(len(table), bool)
    moved = _compiled(corner_points.part_at_corners)(*_xy(points), owner, table, gate, changed)
    assert moved == changed.any()
    np.testing.assert_array_equal(table, counted(table, owner))
    return owner, changed


def add_short_walls(points, beams, owner, table, sigma, cut):
    """Return the owners and the walls afterwards."""
    owner, table = owner.copy(), counted(table, owner)
    args = *_xy(points), beams, owner, table, sigma, cut
    table = _compiled(short_walls.add_short_walls)(*args)
    np.testing.assert_array_equal(table, counted(table, owner))
    return owner, table


def drop_crumbs(points, owner, table, member, support, min_points):
    """Return whether there were crumbs, and the owners and walls afterwards."""
    owner, table = owner.copy(), counted(table, owner)
    args = *_xy(points), owner, table, member, support, min_points
    dropped = _compiled(crumbs.drop_crumbs)(*args)
    return dropped, owner, table


def widen(points, line, member, lines, covariance, sigma):
    """Return the covariances afterwards."""
    covariance = covariance.copy()
    _compiled(walls.widen)(*_xy(points), line, member, *_xy(lines), covariance, sigma)
    return covariance
