"""EKF-SLAM over a sequence of scans."""

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Features, LaserScan, Pose2D
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.slam import EkfSlam, Landmark, Step


@dataclass(frozen=True, eq=False, kw_only=True)
class Run:
    """What SLAM has made of some scans.

    Parameters
    ----------
    estimate, odometry : Trajectory
        The sensor's poses (N, 3) by SLAM and by odometry alone.
    covariances : (N, 3, 3) array
        Of the poses by SLAM.
    matched, landmarks : (N,) int arrays
        In each scan, how many measurements were of known landmarks, and how many of these there
        were then.
    nis : (N,) array
        Normalised innovation squared of each scan, of two degrees of freedom a match.
    seconds : (N,) array
        How long each scan took: features, association, update [s].
    map : tuple of Landmark
        The map in the end.
    points : list of (P, 2) arrays
        Each scan's points, in the sensor's frame [m].
    notices : list of str
        Where the filter said that it was not to be trusted, and why.
    """

    estimate: Trajectory
    odometry: Trajectory
    covariances: FloatArray
    matched: IntArray
    landmarks: IntArray
    nis: FloatArray
    seconds: FloatArray
    map: tuple[Landmark, ...]
    points: list[FloatArray]
    notices: list[str]


@dataclass
class Recorder:
    """Steps a filter scan by scan and keeps what comes of it."""

    extractor: Callable[[LaserScan], Features]
    slam: EkfSlam
    _steps: list[Step] = field(default_factory=list, init=False)
    _stamps: list[float] = field(default_factory=list, init=False)
    _odometry: list[Pose2D] = field(default_factory=list, init=False)
    _seconds: list[float] = field(default_factory=list, init=False)
    _points: list[FloatArray] = field(default_factory=list, init=False)
    _notices: list[str] = field(default_factory=list, init=False)

    def add(self, scan: LaserScan, odometry: Pose2D, start: Pose2D | None = None) -> Step:
        """Take in a scan whose sensor was at `odometry`; `start` as `EkfSlam.step` has it."""
        began = time.perf_counter()
        step = self.slam.step(odometry, self.extractor(scan), start)
        self._seconds.append(time.perf_counter() - began)
        if step.notice:
            self._notices.append(f"scan {len(self._steps)}: {step.notice}")
        self._steps.append(step)
        self._stamps.append(scan.stamp)
        self._odometry.append(odometry)
        self._points.append(scan.points)
        return step

    def run(self) -> Run:
        """Return what has come of it so far."""
        return Run(
            estimate=Trajectory.of(self._stamps, [step.pose for step in self._steps]),
            odometry=Trajectory.of(self._stamps, self._odometry),
            covariances=np.array([s.covariance for s in self._steps]).reshape(-1, 3, 3),
            matched=np.array([s.matched for s in self._steps], dtype=np.int64),
            landmarks=np.array([s.landmarks for s in self._steps], dtype=np.int64),
            nis=np.array([s.nis for s in self._steps], dtype=float),
            seconds=np.array(self._seconds, dtype=float),
            map=self.slam.map,
            points=self._points,
            notices=self._notices,
        )


def run_slam(
    scans: Iterable[LaserScan], extractor: Callable[[LaserScan], Features], slam: EkfSlam
) -> Run:
    """Run a filter over scans whose poses are odometry.

    Raises
    ------
    ValueError
        If a scan has no pose.
    """
    recorder = Recorder(extractor, slam)
    for i, scan in enumerate(scans):
        if scan.pose is None:
            raise ValueError(f"scan {i} has no pose: SLAM needs odometry")
        recorder.add(scan, scan.pose)
    return recorder.run()
