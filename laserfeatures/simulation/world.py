"""Worlds: floor plans of straight walls, boxes and poles."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from laserfeatures.arrays import FloatArray, IntArray, Record, read_only
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.distances import to_boxes, to_poles, to_walls

WHITE = 0.9  # reflectivity of a painted wall
SHORTEST = 1e-9  # [m]; what is shorter has no length
NEAREST = 1e-3  # [m]; a sensor nearer to a surface than this is taken to stand on it
HALF_SIDES = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]) / 2


@dataclass(frozen=True, eq=False, kw_only=True)
class World(Record):
    """A floor plan.

    Its surfaces are numbered: the walls come first, then four sides of each box, then the poles.

    Parameters
    ----------
    walls : (W, 2, 2) array
        Both ends of each wall [m]. A wall has no thickness.
    boxes : (B, 5) array
        Centre x, y, length along its own x axis, width [m] and heading [rad] of each box.
    poles : (P, 3) array
        Centre x, y and radius of each pole [m].
    reflectivity : (W + B + P,) array or None
        Share of the light that each wall, box and pole reflects, in (0, 1]; None: all white, 0.9.

    Raises
    ------
    ValueError
        If a shape differs, a wall has no length, a box no area or a pole no radius, or a
        reflectivity is out of its range.
    """

    walls: FloatArray = field(default_factory=lambda: np.empty((0, 2, 2)))
    boxes: FloatArray = field(default_factory=lambda: np.empty((0, 5)))
    poles: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    reflectivity: FloatArray | None = None

    def __post_init__(self) -> None:
        """Check and lock the arrays."""
        walls = read_only(self.walls, "walls", (None, 2, 2))
        boxes = read_only(self.boxes, "boxes", (None, 5))
        poles = read_only(self.poles, "poles", (None, 3))
        objects = len(walls) + len(boxes) + len(poles)
        white = np.full(objects, WHITE)
        given = white if self.reflectivity is None else self.reflectivity
        reflectivity = read_only(given, "reflectivity", (objects,))
        self._set(walls=walls, boxes=boxes, poles=poles, reflectivity=reflectivity)
        for i, (start, end) in enumerate(walls):
            if not SHORTEST <= abs(end - start).max() < math.inf:
                raise ValueError(f"wall {i} must have a finite length > 0, got {walls[i].tolist()}")
        for i, box in enumerate(boxes):
            if not (box[2:4].min() > 0 and np.isfinite(box).all()):
                raise ValueError(f"box {i} must have a finite area > 0, got {box.tolist()}")
        for i, pole in enumerate(poles):
            if not (pole[2] > 0 and np.isfinite(pole).all()):
                raise ValueError(f"pole {i} must have a finite radius > 0, got {pole.tolist()}")
        for i, share in enumerate(reflectivity):
            if not 0 < share <= 1:
                raise ValueError(f"reflectivity {i} must be in (0, 1], got {share}")

    @classmethod
    def outline(cls, *polygons: ArrayLike) -> Self:
        """Make a world of closed polygons of walls, each (n, 2) [m]."""
        walls = []
        for polygon in polygons:
            points = read_only(polygon, "polygon", (None, 2))
            walls += [(points[i - 1], points[i]) for i in range(len(points))]
        return cls(walls=np.array(walls).reshape(-1, 2, 2))

    @cached_property
    def sides(self) -> FloatArray:
        """Both ends of each straight surface [m], (S, 2, 2): the walls, then four sides a box."""
        heading = self.boxes[:, 4]
        along = np.stack([np.cos(heading), np.sin(heading)], axis=1) * self.boxes[:, 2:3]
        across = np.stack([-np.sin(heading), np.cos(heading)], axis=1) * self.boxes[:, 3:4]
        corners = (
            self.boxes[:, None, :2]
            + HALF_SIDES[None, :, :1] * along[:, None]
            + HALF_SIDES[None, :, 1:] * across[:, None]
        )
        box_sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2)
        sides: FloatArray = np.concatenate([self.walls, box_sides.reshape(-1, 2, 2)])
        sides.flags.writeable = False
        return sides

    @cached_property
    def object_of(self) -> IntArray:
        """Number of each surface's wall, box or pole, as `reflectivity` counts them."""
        walls, boxes, poles = len(self.walls), len(self.boxes), len(self.poles)
        numbers = np.arange(walls + boxes + poles)
        return np.repeat(numbers, [1] * walls + [4] * boxes + [1] * poles)

    @cached_property
    def reflectivity_of_surface(self) -> FloatArray:
        """Share of the light that each surface reflects, (surfaces,)."""
        shares: FloatArray = np.asarray(self.reflectivity)[self.object_of]
        return shares

    def distances(self, points: ArrayLike) -> FloatArray:
        """Return how far points (N, 2) are from each wall, box and pole [m], (N, W + B + P).

        It is negative inside a box or pole.
        """
        x, y = np.asarray(points, dtype=np.float64).reshape(-1, 2).T[:, :, None]
        distances = [to_walls(self.walls, x, y)]
        if self.boxes.size:
            distances.append(to_boxes(self.boxes, x, y))
        if self.poles.size:
            distances.append(to_poles(self.poles, x, y))
        return np.concatenate(distances, axis=1)

    def blocking(self, pose: Pose2D) -> int | None:
        """Return the number of the wall, box or pole that keeps a sensor from standing at `pose`.

        It is inside that box or pole, or within 1 mm of the surface.
        """
        distances = self.distances((pose.x, pose.y))[0]
        if not distances.size or distances.min() >= NEAREST:
            return None
        return int(distances.argmin())

    def check_pose(self, pose: Pose2D, who: str = "the sensor") -> None:
        """Check that a sensor can stand at `pose`; `who` is what an error calls it.

        Raises
        ------
        ValueError
            If the pose is not finite, inside a box or pole, or within 1 mm of a surface.
        """
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            raise ValueError(f"{who} must have a finite pose, got {pose}")
        at = self.blocking(pose)
        if at is None:
            return
        where = "inside" if self.distances((pose.x, pose.y))[0, at] <= -NEAREST else "on"
        for kind, objects in (("wall", self.walls), ("box", self.boxes), ("pole", self.poles)):
            if at < len(objects):
                raise ValueError(f"{who} at ({pose.x:.6g}, {pose.y:.6g}) is {where} {kind} {at}")
            at -= len(objects)
