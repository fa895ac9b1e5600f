"""The demo's tour: what the extractor finds in a simulated hallway, and what there was to find."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

import laserfeatures as lf
from laserfeatures.arrays import FloatArray
from laserfeatures.cli.extractor import blamed
from laserfeatures.simulation import Scanner, World

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

SEED = 7
REPEATS = 20  # of each scan, to time it
LEAST_BEAMS = 4  # that must hit a wall for it to count as seen
LEAST_SINE = np.sin(np.radians(15))  # flatter crossings are no features
FARTHEST = 20.0  # from the sensor [m], the paper's limit


@dataclass(frozen=True)
class Visit:
    """What was found from one pose, and what there was to find."""

    pose: lf.Pose2D
    features: lf.Features
    truth: FloatArray  # crossings of the walls in view, in the plan's frame [m], (T, 2)
    seconds: float  # to extract

    @property
    def errors(self) -> FloatArray:
        """Distance of each corner found from the nearest true one [m], (F,)."""
        found = self.pose.transform(self.features.corners.positions)
        away = np.linalg.norm(found[:, None] - self.truth[None], axis=2)
        errors: FloatArray = away.min(axis=1, initial=np.inf)
        return errors


def tour(extractor: "Pipeline", world: World, path: list[lf.Pose2D]) -> Iterator[Visit]:
    """Scan a world from each pose of a path and extract the features."""
    scanner = Scanner()
    rng = np.random.default_rng(SEED)
    for index, pose in enumerate(path):
        scan = scanner.scan(world, pose, rng)
        with blamed(extractor, index):
            features = extractor(scan)  # the first call compiles
            start = time.perf_counter()
            for _ in range(REPEATS):
                extractor(scan)
            seconds = (time.perf_counter() - start) / REPEATS
        yield Visit(pose, features, crossings_in_view(world, scanner, pose), seconds)


def crossings_in_view(world: World, scanner: Scanner, pose: lf.Pose2D) -> FloatArray:
    """Return where the lines of the walls that a scan sees cross, in the plan's frame [m]."""
    ranges, wall = scanner.cast(world, pose)
    hits = np.bincount(wall[ranges < scanner.range_max], minlength=len(world.walls))
    start, end = world.walls[hits >= LEAST_BEAMS].swapaxes(0, 1)
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    # One sign for a line's two normals, and collinear walls are one line.
    normal *= np.where(normal @ (1.0, 1e-3) < 0, -1.0, 1.0)[:, None]
    lines = np.column_stack([normal, (normal * start).sum(axis=1)])
    lines = np.unique(lines.round(9) + 0.0, axis=0)
    i, j = np.triu_indices(len(lines), k=1)
    sine = lines[i, 0] * lines[j, 1] - lines[i, 1] * lines[j, 0]
    pairs = np.stack([lines[i], lines[j]], axis=1)[np.abs(sine) >= LEAST_SINE]
    crossings = np.linalg.solve(pairs[:, :, :2], pairs[:, :, 2:])[:, :, 0]
    distance = np.linalg.norm(crossings - (pose.x, pose.y), axis=1)
    near: FloatArray = crossings[distance <= FARTHEST]
    return near
