"""The demo's tour: what the extractor finds in a simulated hallway, and what there was to find."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

import laserfeatures as lf
from laserfeatures.arrays import FloatArray
from laserfeatures.cli.extractor import blamed
from laserfeatures.evaluation import Truth, truth_of
from laserfeatures.simulation import Scanner, World

if TYPE_CHECKING:
    from laserfeatures.pipeline import Pipeline

SEED = 7
REPEATS = 20  # of each scan, to time it


@dataclass(frozen=True)
class Visit:
    """What was found from one pose, and what there was to find."""

    pose: lf.Pose2D
    features: lf.Features
    truth: Truth
    seconds: float  # to extract

    @property
    def errors(self) -> FloatArray:
        """Distance of each corner found from the nearest true one [m], (F,)."""
        found = self.features.corners.positions
        away = np.linalg.norm(found[:, None] - self.truth.corners[None], axis=2)
        errors: FloatArray = away.min(axis=1, initial=np.inf)
        return errors


def tour(extractor: "Pipeline", world: World, path: list[lf.Pose2D]) -> Iterator[Visit]:
    """Scan a world from each pose of a path and extract the features."""
    scanner = Scanner()
    rng = np.random.default_rng(SEED)
    for index, pose in enumerate(path):
        observation = scanner.observe(world, pose, rng)
        with blamed(extractor, index):
            features = extractor(observation.scan)  # the first call compiles
            start = time.perf_counter()
            for _ in range(REPEATS):
                extractor(observation.scan)
            seconds = (time.perf_counter() - start) / REPEATS
        yield Visit(pose, features, truth_of(observation), seconds)
