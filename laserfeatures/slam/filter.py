"""EKF-SLAM: a pose and a map of corners and walls, from odometry and the features of scans.

References
----------
Smith, Self and Cheeseman, Estimating Uncertain Spatial Relationships in Robotics, 1990.
Dissanayake et al., A Solution to the Simultaneous Localization and Map Building Problem, 2001.
"""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features
from laserfeatures.poses import relative
from laserfeatures.scan import Pose2D
from laserfeatures.slam.consistency import Watch
from laserfeatures.slam.invariance import carried_over
from laserfeatures.slam.landmarks import Landmarks
from laserfeatures.slam.map import Landmark, map_of
from laserfeatures.slam.matches import ASSOCIATIONS, Matches, matches_of, measurement_of
from laserfeatures.slam.motion import Motion
from laserfeatures.slam.observations import Observations, observations_of
from laserfeatures.slam.registration import register
from laserfeatures.slam.state import POSE, State

# A step by odometry that is less certain than this is registered first.
SURE_TURN, SURE_WAY = 0.01, 0.05  # [rad], [m]
FARTHEST = 1e7  # [m]; no robot on Earth has gone farther
JUMP = 100.0  # [m]; no robot goes so far from one scan to the next


@dataclass(frozen=True)
class Step:
    """What the filter made of a scan.

    Parameters
    ----------
    pose : Pose2D
        Where the sensor is.
    covariance : (3, 3) array
        Of x, y [m] and theta [rad].
    matched : int
        How many measurements were of known landmarks.
    nis : float
        Their normalised innovation squared; with `matched` of two degrees of freedom each, it
        follows the chi-square distribution if the filter is consistent.
    landmarks : int
        How many landmarks there are.
    notice : str or None
        Why the filter is not to be trusted from here on, where it finds that out.
    """

    pose: Pose2D
    covariance: FloatArray
    matched: int
    nis: float
    landmarks: int
    notice: str | None = None


@dataclass(kw_only=True)
class EkfSlam:
    """The filter.

    Parameters
    ----------
    motion : Motion
        How uncertain the odometry is.
    corners, walls : bool
        Which features are landmarks.
    association : "joint" or "nearest"
        Joint compatibility, or each measurement's nearest neighbour.
    roughness : float
        How far real walls and corners are off lines and points [m].
    registered : bool
        Whether steps of which the odometry is not sure are made better by laying each scan over
        the one before.
    probability : float
        That a measurement lies within the gate of its own landmark.
    sightings : int
        How often in a row of scans something new must be seen before it becomes a landmark; in the
        first scan, whose pose is certain, once is enough.
    patience : int
        In how many scans a landmark that ought to be seen may be missed beyond those in which it
        was seen, before it is dropped.
    most : int
        How many landmarks there may be: memory and time grow with their square.

    Raises
    ------
    ValueError
        If a parameter makes no sense.
    """

    motion: Motion = field(default_factory=Motion)
    corners: bool = True
    walls: bool = True
    association: Literal["joint", "nearest"] = "joint"
    roughness: float = 0.03
    registered: bool = True
    probability: float = 0.99
    sightings: int = 3
    patience: int = 10
    most: int = 2000
    state: State | None = field(default=None, init=False, repr=False)
    landmarks: Landmarks = field(default_factory=Landmarks, init=False, repr=False)
    _odometry: Pose2D | None = field(default=None, init=False, repr=False)
    _points: FloatArray = field(default_factory=lambda: np.empty((0, 2)), init=False, repr=False)
    _was_full: bool = field(default=False, init=False, repr=False)
    _watch: Watch = field(default_factory=Watch, init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not (self.corners or self.walls):
            raise ValueError("corners or walls must be landmarks, got neither")
        if self.association not in ASSOCIATIONS:
            names = " or ".join(ASSOCIATIONS)
            raise ValueError(f"association must be {names}, got {self.association!r}")
        if not 0 <= self.roughness < math.inf:
            raise ValueError(f"roughness must be >= 0 m and finite, got {self.roughness}")
        if not 0 < self.probability < 1:
            raise ValueError(f"probability must be in (0, 1), got {self.probability}")
        for name in ("sightings", "patience", "most"):
            if not getattr(self, name) >= 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")

    @property
    def map(self) -> tuple[Landmark, ...]:
        """The landmarks so far."""
        return map_of(self.state, self.landmarks) if self.state else ()

    def step(self, odometry: Pose2D, features: Features, start: Pose2D | None = None) -> Step:
        """Take in a scan.

        Parameters
        ----------
        odometry : Pose2D
            The sensor's pose by odometry, at the time of the scan.
        features : Features
            What an extractor has found in it.
        start : Pose2D, optional
            With the first scan: where the sensor is in the frame of the map, its origin if left
            out.

        Raises
        ------
        ValueError
            If a pose is not finite or farther than any robot goes; nothing is taken in then.
        """
        for name, pose in (("odometry", odometry), ("start", start)):
            if pose and not max(abs(pose.x), abs(pose.y), abs(pose.theta)) <= FARTHEST:
                raise ValueError(
                    f"{name} must be finite and within {FARTHEST:g} m, got x = {pose.x:g} m, "
                    f"y = {pose.y:g} m, theta = {pose.theta:g} rad"
                )
        first = self.state is None
        state = State(start or Pose2D(0.0, 0.0, 0.0)) if self.state is None else self.state
        self.state = state
        jumped = self._move(state, odometry, features.scan.points)
        seen = observations_of(
            features, corners=self.corners, walls=self.walls, roughness=self.roughness
        )
        matches, nis = [], 0.0
        for each in seen:
            found, squared = self._take_in(state, each)
            matches.append(found)
            nis += squared
        for found in matches:
            self.landmarks.saw(state.pose, found.seen, found.measurement, found.landmark)
        for found in matches if not self._watch.doubts else ():
            new = np.setdiff1d(np.arange(len(found.seen)), found.measurement, assume_unique=True)
            new = new[: self.most - state.landmarks]
            self.landmarks.propose(state, found.seen, new, 1 if first else self.sightings)
        oddity = self._tend(state, features)
        matched = sum(map(len, matches))
        return Step(
            state.pose,
            state.covariance[:POSE, :POSE].copy(),
            matched,
            nis,
            state.landmarks,
            jumped or self._watch.notice(matched, nis, oddity) or self._full(state),
        )

    def _move(self, state: State, odometry: Pose2D, points: FloatArray) -> str | None:
        """Predict the pose at a scan of those points (P, 2); return that the odometry jumps."""
        before, self._odometry = self._odometry, odometry
        points_before, self._points = self._points, points
        if before is None:
            return None
        moved = relative(before, odometry)
        covariance = self.motion.covariance(moved)
        x, y, turn = np.diag(covariance)
        if self.registered and (turn > SURE_TURN**2 or x + y > SURE_WAY**2):
            moved, covariance = register(points_before, points, moved, covariance)
        state.move(moved, covariance)
        way = math.hypot(moved.x, moved.y)
        return f"odometry jumps by {way:.5g} m since the scan before" if way > JUMP else None

    def _take_in(self, state: State, seen: Observations) -> tuple[Matches, float]:
        """Correct the state by all that is recognised; return that, and its squared innovation."""
        found = matches_of(state, self.landmarks, seen, self.association, self.probability)
        if not len(found):
            return found, 0.0
        measured = measurement_of(state, self.landmarks, found)
        nis = state.correct(
            measured.places,
            measured.jacobian,
            measured.innovation,
            measured.noise,
            lambda before, after: carried_over(
                before, after, self.landmarks.is_wall, self.landmarks.anchors
            ),
        )
        return found, nis

    def _tend(self, state: State, features: Features) -> float:
        """Drop landmarks that ought to be seen and are not; return how odd that is, just now."""
        kept, oddity = self.landmarks.worth_keeping(state, features.scan, self.patience)
        if not kept.all():
            state.keep(kept)
            self.landmarks.keep(kept)
        return oddity

    def _full(self, state: State) -> str | None:
        """Return that there is no room for more landmarks, when that begins."""
        before, self._was_full = self._was_full, state.landmarks >= self.most
        if before or not self._was_full:
            return None
        return f"the map is full: it has {self.most} landmarks, and nothing new is added"
