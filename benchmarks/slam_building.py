"""A building of many furnished rooms, for maps of as many landmarks as one likes."""

import math
from itertools import pairwise

import numpy as np

import laserfeatures as lf
from laserfeatures.simulation import World

COLUMNS, CELL = 6, np.array([6.5, 5.5])  # rooms in a row, and what each takes up [m]
DOOR = 1.2  # [m]
STEP = 0.05  # [m] from scan to scan: half a metre a second, ten scans a second
BARE = 3  # rooms without furniture, the first ones: maps of few landmarks


class Building:
    """Rooms in rows, each its own size, with furniture, and a way through all of them."""

    def __init__(self, rng, rooms):
        self._rng = rng
        self._walls, self._boxes, self._points = [], [], []
        cells = [self._cell(number) for number in range(rooms)]
        sides = rng.uniform(0.1, 0.5, (rooms, 4))  # how thick the wall is to each side
        low = [CELL * cell + side[:2] for cell, side in zip(cells, sides, strict=True)]
        high = [CELL * (cell + 1) - side[2:] for cell, side in zip(cells, sides, strict=True)]
        self._doors = [[] for _ in range(rooms)]
        for k, (cell, other) in enumerate(pairwise(cells)):
            self._door(k, cell, other, low, high)
        for k in range(rooms):
            self._room(low[k], high[k], self._doors[k])
            if k >= BARE:
                self._furnish(CELL * (cells[k] + 0.5))
        self.world = World(walls=np.array(self._walls), boxes=np.array(self._boxes))
        self.way = _smooth(np.array([CELL * (cells[0] + 0.5), *self._points]))

    @staticmethod
    def _cell(number):
        row, column = divmod(number, COLUMNS)
        return np.array([column if row % 2 == 0 else COLUMNS - 1 - column, row])

    def _door(self, k, cell, other, low, high):
        """Join a room and the next one, and lead the way through."""
        axis = int(cell[1] != other[1])  # 0: side by side
        ahead = (other - cell)[axis] > 0
        start, end = (high[k], low[k + 1]) if ahead else (low[k], high[k + 1])
        middle = CELL * (cell + 0.5)
        place = middle[1 - axis] + self._rng.uniform(-0.4, 0.4)
        for side in (-DOOR / 2, DOOR / 2):
            ends = np.empty((2, 2))
            ends[:, axis], ends[:, 1 - axis] = (start[axis], end[axis]), place + side
            self._walls.append(ends)
        self._doors[k].append((axis, start[axis], place))
        self._doors[k + 1].append((axis, end[axis], place))
        through = np.empty(2)
        through[axis], through[1 - axis] = (start[axis] + end[axis]) / 2, place
        self._points += [through, CELL * (other + 0.5)]

    def _room(self, low, high, doors):
        """Build a room's four walls, but for its doors."""
        for axis in range(2):
            for at in (low[axis], high[axis]):
                cuts = [low[1 - axis], high[1 - axis]]
                for door_axis, door_at, place in doors:
                    if door_axis == axis and door_at == at:
                        cuts += [place - DOOR / 2, place + DOOR / 2]
                for piece in np.sort(cuts).reshape(-1, 2):
                    ends = np.empty((2, 2))
                    ends[:, axis], ends[:, 1 - axis] = at, piece
                    self._walls.append(ends)

    def _furnish(self, middle):
        quarters = np.array([(-1.9, -1.5), (1.9, -1.5), (1.9, 1.5), (-1.9, 1.5)])
        for quarter in quarters[self._rng.permutation(4)[:2]]:
            size, off = self._rng.uniform(0.4, 0.9, 2), self._rng.uniform(-0.15, 0.15, 2)
            self._boxes.append((*(middle + quarter + off), *size, self._rng.uniform(0, math.pi)))


def _smooth(points):
    """Return poses along a way of points, which looks ahead and cuts its corners."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    at = np.arange(0.5, along[-1] - 0.5, STEP)
    back, ahead = (
        np.stack([np.interp(at + s, along, column) for column in points.T], axis=1)
        for s in (-0.4, 0.4)
    )
    middle, step = (back + ahead) / 2, ahead - back
    headings = np.arctan2(step[:, 1], step[:, 0])
    return [lf.Pose2D(*xy, theta) for xy, theta in zip(middle.tolist(), headings, strict=True)]
