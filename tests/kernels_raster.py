"""The raster's kernels as tests call them: points as one array, results returned."""

import math
from itertools import pairwise

import numpy as np
from kernels import _compiled, _xy
from laserfeatures_plugins.raster import drawing, shape, surfaces, walls

from laserfeatures.engine.partition import Limits
from laserfeatures.engine.segments import line_segments
from laserfeatures.engine.walls import WALL


def is_near(a, b, incidence):
    """Tell whether two returns are near for a surface met at `incidence` [rad]."""
    return _compiled(surfaces.is_near)(*a, *b, math.tan(incidence))


def behind(points, m, way, other, sigma, baseline):
    """Return how far a point lies behind the surface beside point m, and the doubt."""
    live = np.arange(len(points))
    return _compiled(surfaces.behind)(*_xy(points), live, m, way, other, sigma, baseline)


def contours(points, beams, live, incidence, sigma, baseline, max_missed):
    """Return the chains, as lists of points."""
    chained, ends = _compiled(surfaces.contours)(
        *_xy(points), beams, live, math.tan(incidence), sigma, baseline, max_missed
    )
    return [chained[a:b].tolist() for a, b in pairwise(ends)]


def place(points, chosen, resolution, margin):
    """Return x, y, width, height and the pixels."""
    return _compiled(drawing.place)(*_xy(points), chosen, resolution, margin)


def lines(found, origin, rows):
    """Return what the kernels take as lines."""
    theta = np.arange(rows) * math.pi / rows
    return np.asarray(found, np.float32).reshape(-1, 2), tuple(origin), np.cos(theta), np.sin(theta)


def to_metres(line, origin, rows, resolution):
    """Return theta, cos(theta), sin(theta) and d."""
    return _compiled(walls.to_metres)(lines(line, origin, rows), 0, resolution)


def propose(points, found, resolution, noise, bounds):
    """Return what raster_hough proposes, (K, COLUMNS)."""
    return walls.propose(np.array(points), found, resolution, noise, bounds).T


def bins_on(points, beams, found, resolution, noise, bounds):
    """Return the bins that are lines, as `LineSegments`."""
    return line_segments(walls.bins_on(np.array(points), beams, found, resolution, noise, bounds))


def seed_on(points, beams, free, line, gate, bounds):
    """Return the seed, -1 for none."""
    theta, d = line
    near = np.empty(len(points), np.int64)
    args = math.cos(theta), math.sin(theta), d, gate, Limits(*bounds), near
    return _compiled(walls.seed_on)(*_xy(points), beams.astype(float), free, *args)


def keep_free(taken, places):
    """Return those of `places` that are not taken."""
    places = places.copy()
    return places[: _compiled(walls.keep_free)(taken, places)]


def repeats(theta, point, lines, step, resolution):
    """Tell whether a line of points around a point repeats one of `lines`."""
    table = np.zeros(len(lines), WALL)
    for row, (angle, d) in zip(table, lines, strict=True):
        row["c"], row["s"], row["d"] = math.cos(angle), math.sin(angle), d
    return _compiled(walls.repeats)(theta, *point, table, step, resolution)


def turns(image, points, ridge):
    """Return the turn at each point (column, row)."""
    return _compiled(shape.turns)(image, *_xy(points), ridge)


def turn_of(ring, least):
    """Return the turn that the maxima of a ring make."""
    return _compiled(shape.turn_of)(ring, least)


def brightness(image, u, v):
    """Return the brightness between pixels."""
    return _compiled(shape.brightness)(image, u, v)


def structure(image, points):
    """Return the structure tensor at each point (column, row)."""
    return _compiled(shape.structure)(image, *_xy(points))


def distinct(points, reach):
    """Return which points to keep."""
    return _compiled(shape.distinct)(*_xy(points), reach)
