"""Furniture for random worlds: boxes and poles where there is a place for them."""

import math
from collections.abc import Iterable

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.simulation.world import World


def piece(rng: np.random.Generator, at: FloatArray, heading: float) -> FloatArray:
    """Return a random box (5,) or, one time in four, a pole (3,) with its middle `at` (2,) [m].

    Half of the boxes are aligned with `heading` [rad] one way or the other, the rest turned anyhow.
    """
    kind, length, width, radius = rng.uniform((0, 0.4, 0.3, 0.05), (1, 1.4, 0.8, 0.2))
    turned = heading + rng.choice([0.0, math.pi / 2, *rng.uniform(0, math.pi, 2)])
    return np.array([*at, radius] if kind < 0.25 else [*at, length, width, turned])


def furnish(
    rng: np.random.Generator,
    walls: FloatArray,
    pieces: Iterable[FloatArray],
    *,
    way: FloatArray,
    clearance: float,
    most: int,
) -> World:
    """Return a world of walls (W, 2, 2) and those pieces that have a place.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the reflectivities, 20 % to 90 %.
    walls : (W, 2, 2) array
        Both ends of each wall [m].
    pieces : iterable of array
        Boxes (5,) and poles (3,) as `World` has them, each kept if it touches nothing.
    way : (n, 2) array
        Points that each piece must be clear of [m].
    clearance : float
        By how much [m].
    most : int
        How many are kept at most.
    """
    boxes: list[FloatArray] = []
    poles: list[FloatArray] = []
    world = World(walls=walls)
    for new in pieces:
        if len(boxes) + len(poles) >= most:
            break
        reach = new[2] if new.size == 3 else float(np.hypot(new[2], new[3])) / 2
        alone = _world([new] * (new.size == 5), [new] * (new.size == 3))
        if world.distances(new[:2]).min() > reach and alone.distances(way).min() > clearance:
            (poles if new.size == 3 else boxes).append(new)
            world = _world(boxes, poles, walls)
    return World(
        walls=walls,
        boxes=world.boxes,
        poles=world.poles,
        reflectivity=rng.uniform(0.2, 0.9, len(walls) + len(boxes) + len(poles)),
    )


def _world(
    boxes: list[FloatArray], poles: list[FloatArray], walls: FloatArray | None = None
) -> World:
    return World(
        walls=np.empty((0, 2, 2)) if walls is None else walls,
        boxes=np.array(boxes).reshape(-1, 5),
        poles=np.array(poles).reshape(-1, 3),
    )
