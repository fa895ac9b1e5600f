"""Rays against a floor plan."""

import math

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.simulation.world import World


def cast(world: World, position: FloatArray, angles: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return how far each ray goes [m] (inf: to no end) and the surface it hits (or -1).

    Parameters
    ----------
    world : World
        The floor plan; it counts the surfaces.
    position : (2,) array
        Where the rays start [m].
    angles : (N,) array
        Direction of each ray in the world [rad].
    """
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    sides, poles = len(world.sides), len(world.poles)
    ranges = np.full((angles.size, sides + poles + 1), math.inf)  # the last stands for none
    _to_sides(world.sides - position, direction, ranges[:, :sides])
    if poles:
        _to_poles(world.poles - (*position, 0.0), direction, ranges[:, sides:-1])
    surface = np.argmin(ranges, axis=1)
    nearest = ranges[np.arange(angles.size), surface]
    return nearest, np.where(np.isfinite(nearest), surface, -1)


def cos_incidence(
    world: World, position: FloatArray, angles: FloatArray, surface: IntArray
) -> FloatArray:
    """Return the cosine of the angle between each ray and its surface's normal, (N,); 1 for none.

    Parameters
    ----------
    world, position, angles
        As `cast` takes them.
    surface : (N,) int array
        The surface that each ray hits, as `cast` returns it.
    """
    direction = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    cosine = np.ones(angles.size)
    sides = len(world.sides)
    flat = (surface >= 0) & (surface < sides)
    start, end = np.moveaxis(world.sides[surface[flat]], 1, 0)
    along = (end - start) / np.hypot(*(end - start).T)[:, None]
    cosine[flat] = abs(direction[flat, 0] * along[:, 1] - direction[flat, 1] * along[:, 0])
    round_ = surface >= sides
    centre = world.poles[surface[round_] - sides]
    x, y = (centre[:, :2] - position).T
    sine = (direction[round_, 0] * y - direction[round_, 1] * x) / centre[:, 2]
    cosine[round_] = np.sqrt(np.maximum(1.0 - sine**2, 0.0))
    return cosine


def _to_sides(sides: FloatArray, direction: FloatArray, nearest: FloatArray) -> None:
    """Set the range [m] at which each ray from the origin meets each side, (N, S)."""
    start, along = sides[:, 0], sides[:, 1] - sides[:, 0]
    # Solve range * direction = start + u * along for each beam (rows) and side (columns). A ray
    # along a side divides by zero and does not meet it.
    with np.errstate(divide="ignore", invalid="ignore"):
        det = direction[:, :1] * along[:, 1] - direction[:, 1:] * along[:, 0]
        ranges = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / det
        u = (start[:, 0] * direction[:, 1:] - start[:, 1] * direction[:, :1]) / det
    np.copyto(nearest, ranges, where=(ranges > 0) & (u >= 0) & (u <= 1))


def _to_poles(poles: FloatArray, direction: FloatArray, nearest: FloatArray) -> None:
    """Set the range [m] at which each ray from the origin meets each pole, (N, P)."""
    ahead = direction @ poles[:, :2].T
    aside = direction[:, :1] * poles[:, 1] - direction[:, 1:] * poles[:, 0]
    half_chord = np.sqrt(np.maximum(poles[:, 2] ** 2 - aside**2, 0.0))
    ranges = ahead - half_chord
    np.copyto(nearest, ranges, where=(abs(aside) < poles[:, 2]) & (ranges > 0))
