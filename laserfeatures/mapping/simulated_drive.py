"""SLAM on the drive of a simulated robot, whose true poses are known."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features, LaserScan
from laserfeatures.errors import PluginError
from laserfeatures.mapping.landmark_truth import TrueMap, true_map
from laserfeatures.mapping.run import Recorder, Run
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.simulation import World
from laserfeatures.simulation.robot import Reading
from laserfeatures.slam import EkfSlam


@dataclass(frozen=True, eq=False, kw_only=True)
class SimulatedDrive:
    """What a robot read on its way, and what is true of it.

    Parameters
    ----------
    readings : sequence of Reading
        All of them, in order.
    truth : Trajectory
        The sensor's true poses.
    map : TrueMap
        What there truly was to see.
    """

    readings: Sequence[Reading]
    truth: Trajectory
    map: TrueMap

    @classmethod
    def of(cls, readings: Sequence[Reading]) -> "SimulatedDrive":
        """Return the drive of some readings.

        Raises
        ------
        ValueError
            If there is none.
        """
        observations = [reading.observation for reading in readings]
        stamps = [observation.scan.stamp for observation in observations]
        return cls(
            readings=readings,
            truth=Trajectory.of(stamps, [observation.pose for observation in observations]),
            map=true_map(observations),
        )

    @property
    def world(self) -> World:
        """Where it was."""
        return self.readings[0].observation.world

    @property
    def way(self) -> FloatArray:
        """How far the sensor has truly come at each scan [m], (N,)."""
        steps = np.linalg.norm(np.diff(self.truth.poses[:, :2], axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    def run(self, extractor: Callable[[LaserScan], Features], slam: EkfSlam) -> Run:
        """Run a new filter over the drive; it is told the first true pose, and then odometry.

        Raises
        ------
        ValueError
            If a reading has no odometry.
        PluginError
            If the extractor fails; the message has the number of the scan.
        """
        recorder = Recorder(Blamed(extractor), slam)
        start = self.readings[0].observation.pose
        for i, reading in enumerate(self.readings):
            odometry = reading.scan.pose
            if odometry is None:
                raise ValueError(f"reading {i} has no pose: SLAM needs odometry")
            recorder.add(reading.scan, odometry, start if i == 0 else None)
        return recorder.run()


@dataclass
class Blamed:
    """An extractor whose own errors are told from those of what it is used by."""

    extractor: Callable[[LaserScan], Features]
    scans: int = 0

    def __call__(self, scan: LaserScan) -> Features:
        """Extract."""
        self.scans += 1
        try:
            return self.extractor(scan)
        except Exception as error:
            name = getattr(self.extractor, "name", "extractor")
            raise PluginError(
                f"{name} failed at scan {self.scans - 1}: {type(error).__name__}: {error}"
            ) from error
