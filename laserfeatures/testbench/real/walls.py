"""Straight walls in a cloud of cells, grown from cell to cell.

References
----------
Region growing on local directions: Rabbani, van den Heuvel and Vosselman 2006, *Segmentation of
point clouds using smoothness constraint*; here in the plane, with one line for all of a region.
"""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.testbench.real.cloud import CELL, Cloud

OFF = 0.04  # [m], of a wall's cell from its line
TURN = math.cos(math.radians(20))  # of the surface at a wall's cell from its line
MIN_LENGTH = 0.4  # [m]
MIN_CELLS = 8
MIN_FILLED = 0.6  # of a wall's length: cells
MIN_SCANS = 4  # that see a wall: who stands still for one scan is none
ROUGH = 0.02  # [m], root mean square distance of a wall's points from its line: clutter has more
RADIUS = 15.0  # [m]; what bends more is no straight wall
SAGITTA = 0.015  # [m], that a bend must have to be told from noise


def grow(cloud: Cloud) -> list[IntArray]:
    """Return the cells of each straight wall, the longest wall first."""
    starts, neighbours = _adjacency(cloud)
    free = np.ones(len(cloud.points), np.bool_)
    found = []
    for seed in np.lexsort((-cloud.weight, np.round(cloud.spread, 3))):
        if not free[seed]:
            continue
        members = _grown(cloud, int(seed), free, starts, neighbours)
        free[members] = False
        if members.size >= MIN_CELLS and _is_wall(cloud, members):
            edge = _edge(cloud, members, free, starts, neighbours)
            free[edge] = False
            found.append(np.concatenate([members, edge]))
    return sorted(found, key=lambda members: -float(np.ptp(along_and_across(cloud, members)[0])))


def fit(cloud: Cloud, members: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the centre of cells and the normal of the line of least squares through them."""
    weight = cloud.weight[members]
    points = cloud.points[members]
    centre = weight @ points / weight.sum()
    away = points - centre
    return centre, np.linalg.eigh((away.T * weight) @ away)[1][:, 0]


def along_and_across(cloud: Cloud, members: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the coordinates of cells along their line, from its centre, and across it [m]."""
    centre, normal = fit(cloud, members)
    away = cloud.points[members] - centre
    return away @ (-normal[1], normal[0]), away @ normal


def _adjacency(cloud: Cloud) -> tuple[IntArray, IntArray]:
    """Return where the neighbours of each cell start, and all neighbours."""
    cell, other = np.concatenate([cloud.links, cloud.links[:, ::-1]]).T
    order = np.argsort(cell, kind="stable")
    starts = np.searchsorted(cell[order], np.arange(len(cloud.points) + 1))
    return starts, other[order]


def _grown(
    cloud: Cloud, seed: int, free: BoolArray, starts: IntArray, neighbours: IntArray
) -> IntArray:
    """Return the free cells that belong to the wall of a seed, which is refitted as it grows."""
    mine = np.zeros(free.size, np.bool_)
    mine[seed] = True
    front = np.array([seed])
    centre, normal = cloud.points[seed], cloud.normal[seed]
    while front.size:
        around = [neighbours[starts[cell] : starts[cell + 1]] for cell in front]
        near = np.unique(np.concatenate(around))
        near = near[free[near] & ~mine[near]]
        off = abs((cloud.points[near] - centre) @ normal)
        front = near[(off < OFF) & (abs(cloud.normal[near] @ normal) > TURN)]
        mine[front] = True
        centre, normal = fit(cloud, np.flatnonzero(mine)) if front.size else (centre, normal)
    mine &= abs((cloud.points - centre) @ normal) < OFF
    mine[seed] = True  # so that it is done with
    return np.flatnonzero(mine)


def _edge(
    cloud: Cloud, members: IntArray, free: BoolArray, starts: IntArray, neighbours: IntArray
) -> IntArray:
    """Return the free cells beside a wall and on its line.

    Beside a corner, the surface has no clear direction: the last cells join without one.
    """
    centre, normal = fit(cloud, members)
    around = [neighbours[starts[cell] : starts[cell + 1]] for cell in members]
    near = np.unique(np.concatenate(around))
    near = near[free[near]]
    return near[abs((cloud.points[near] - centre) @ normal) < OFF]


def _is_wall(cloud: Cloud, members: IntArray) -> bool:
    """Tell whether cells are long, flat, straight, without gaps, and seen by several scans."""
    along, across = along_and_across(cloud, members)
    weight = cloud.weight[members]
    length = float(np.ptp(along))
    if length < MIN_LENGTH or members.size * CELL < MIN_FILLED * length:
        return False
    if np.average(across**2, weights=weight) > ROUGH**2 or cloud.scans_on(members) < MIN_SCANS:
        return False
    bend = abs(float(np.polyfit(along, across, 2, w=np.sqrt(weight))[0]))
    return bend <= 0.5 / RADIUS or bend * (length / 2) ** 2 <= SAGITTA
