"""Examples: scans along ways through worlds of the package, for whoever has no log at hand.

They need no physics, so they are there in any installation: the scanner is put down along the way,
straight from way-point to way-point with turns on the spot, and the odometry beside its true poses
is what wheels of a slightly wrong size and some slip would make of it.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib.resources import as_file, files
from typing import NamedTuple

import numpy as np

from laserfeatures.poses import compose, relative, wrap
from laserfeatures.registry import near_names
from laserfeatures.scan import Pose2D
from laserfeatures.simulation.hallway import hallway
from laserfeatures.simulation.observation import Observation
from laserfeatures.simulation.plan_reader import read_plan
from laserfeatures.simulation.scanner import Scanner
from laserfeatures.simulation.world import World

MILLIMETRE = 0.001  # the step of the ranges, so that they are the same on any machine
TURN = math.radians(30.0)  # from scan to scan, at most
SECONDS = 1.0  # from scan to scan
WAY_SCALE, TURN_SCALE = 1.02, 0.97  # what the wheels make of a way and of a turn
WAY_SLIP, TURN_SLIP = 0.02, 0.01  # deviations: a share of the way; [rad] a scan


@dataclass(frozen=True, kw_only=True)
class Example:
    """A world, a way through it, and the scanner that is carried along.

    Parameters
    ----------
    world : callable
        Makes the world: a file of the package is not read before it is wanted.
    waypoints : sequence of (float, float)
        The way [m].
    step : float
        Way from scan to scan, at most [m].
    scanner : Scanner
        The rangefinder.
    seed : int
        Of its noise, and of the odometry's.
    """

    world: Callable[[], World]
    waypoints: Sequence[tuple[float, float]]
    step: float
    scanner: Scanner = field(default_factory=lambda: Scanner(resolution=MILLIMETRE))
    seed: int = 1


class Shot(NamedTuple):
    """A scan with what is true of it, and where the scanner was by odometry."""

    observation: Observation
    odometry: Pose2D


def example(name: str) -> Iterator[Shot]:
    """Yield the scans of the example `name`, one a second from 0 s on; always the same.

    Raises
    ------
    ValueError
        If there is no such example; the message names the near ones.
    """
    if name not in EXAMPLES:
        raise ValueError(f"there is no example {name!r}; {near_names(name, EXAMPLES)}")
    return _shots(EXAMPLES[name])


def _shots(chosen: Example) -> Iterator[Shot]:
    world, noise = chosen.world(), np.random.default_rng(chosen.seed)
    slip = noise.spawn(1)[0]
    before = odometry = None
    for number, pose in enumerate(_poses(chosen.waypoints, chosen.step)):
        if before is None or odometry is None:
            odometry = pose
        else:
            odometry = compose(odometry, _read(relative(before, pose), slip))
        stamp = number * SECONDS
        yield Shot(chosen.scanner.observe(world, pose, noise, stamp=stamp), odometry)
        before = pose


def _read(step: Pose2D, slip: np.random.Generator) -> Pose2D:
    """Return what wheels make of a step."""
    way = WAY_SCALE + WAY_SLIP * slip.standard_normal()
    turn = TURN_SCALE * step.theta + TURN_SLIP * slip.standard_normal()
    return Pose2D(step.x * way, step.y * way, turn)


def _poses(waypoints: Sequence[tuple[float, float]], step: float) -> Iterator[Pose2D]:
    """Yield poses along the way: straight to each point, with turns on the spot there."""
    heading = None
    for (x1, y1), (x2, y2) in itertools.pairwise(waypoints):
        ahead = math.atan2(y2 - y1, x2 - x1)
        turn = 0.0 if heading is None else wrap(ahead - heading)
        turns = math.ceil(abs(turn) / TURN)
        for k in range(1, turns):
            yield Pose2D(x1, y1, wrap(ahead - turn * (1 - k / turns)))
        count = math.ceil(math.dist((x1, y1), (x2, y2)) / step)
        for k in range(count):
            yield Pose2D(x1 + (x2 - x1) * k / count, y1 + (y2 - y1) * k / count, ahead)
        heading = ahead
    yield Pose2D(*waypoints[-1], heading or 0.0)


def _office() -> World:
    with as_file(files("laserfeatures.simulation") / "office.toml") as path:
        return read_plan(path).world


def _clutter() -> World:
    outline = [
        (0.0, 0.0), (9.0, 0.0), (9.0, 6.5), (5.6, 6.5), (5.6, 6.1), (4.6, 6.1), (4.6, 6.5),
        (0.0, 6.5),
    ]  # fmt: skip
    boxes = [  # x, y, length, width, heading
        (3.3, 3.1, 1.6, 0.8, 0.3), (5.9, 3.2, 0.9, 0.7, 0.8), (0.35, 3.2, 0.6, 1.2, 0.0),
        (8.65, 2.6, 0.5, 1.4, 0.0), (2.8, 6.2, 1.5, 0.5, 0.0), (4.6, 0.3, 1.1, 0.5, 0.1),
        (0.5, 6.0, 0.6, 0.6, 0.5),
    ]  # fmt: skip
    poles = [  # x, y, radius
        (2.3, 2.2, 0.03), (2.7, 2.1, 0.03), (2.3, 4.1, 0.03), (4.6, 4.2, 0.2), (6.6, 2.2, 0.15),
        (4.8, 2.2, 0.12), (6.9, 4.2, 0.03), (8.3, 5.8, 0.25),
    ]  # fmt: skip
    return World(walls=World.outline(outline).walls, boxes=np.array(boxes), poles=np.array(poles))


EXAMPLES = {
    "hallway": Example(
        world=lambda: hallway()[0],
        waypoints=[(pose.x, pose.y) for pose in hallway()[1]],
        step=0.35,
    ),
    "office": Example(
        world=_office,
        waypoints=[(4.4, 1.0), (4.4, 11.0), (15.1, 11.0), (15.1, 1.2), (4.4, 1.0)],
        step=0.9,
        scanner=Scanner(
            beams=541,
            field_of_view=math.radians(270.0),
            range_max=20.0,
            range_sigma=0.01,
            resolution=MILLIMETRE,
        ),
    ),
    "clutter": Example(
        world=_clutter,
        waypoints=[(1.3, 1.3), (7.7, 1.3), (7.7, 5.0), (1.3, 5.0), (1.3, 1.8)],
        step=0.5,
        scanner=Scanner(  # a cheap one that turns all round
            beams=720,
            field_of_view=math.radians(359.5),
            range_min=0.1,
            range_max=12.0,
            range_sigma=0.005,
            relative_sigma=0.005,
            dropouts=0.03,
            outliers=0.01,
            resolution=MILLIMETRE,
        ),
    ),
}
