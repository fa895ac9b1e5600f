"""EKF-SLAM: a pose and a map of corners and walls, from odometry and the features of scans.

References
----------
Smith, Self and Cheeseman, Estimating Uncertain Spatial Relationships in Robotics, 1990.
Dissanayake et al., A Solution to the Simultaneous Localization and Map Building Problem, 2001.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.data import Features
from laserfeatures.poses import compose, relative
from laserfeatures.scan import Pose2D
from laserfeatures.slam.association import (
    Pairs,
    distances,
    gate,
    joint_compatibility,
    nearest_neighbours,
)
from laserfeatures.slam.landmarks import Landmarks
from laserfeatures.slam.map import Landmark, map_of
from laserfeatures.slam.motion import Motion
from laserfeatures.slam.observations import Observations, observations_of
from laserfeatures.slam.state import EACH, POSE, State, View

Associate = Callable[[Pairs, float], IntArray]
ASSOCIATIONS: dict[str, Associate] = {
    "joint": joint_compatibility,
    "nearest": nearest_neighbours,
}


HEADING_STEP = math.radians(3)  # between the headings that are tried
COUNTS = 9.0  # what one more match is worth, against squared distances
ITERATIONS = 3


@dataclass(frozen=True, eq=False)
class Match:
    """Which measurements (K,) of one kind are of which landmarks (K,), and how well they fit."""

    seen: Observations
    measurement: IntArray
    landmark: IntArray
    squared: float


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
    probability : float
        That a measurement lies within the gate of its own landmark.
    sightings : int
        How often in a row of scans something new must be seen before it becomes a landmark.
    patience : int
        In how many scans a landmark that ought to be seen may be missed beyond those in which it
        was seen, before it is dropped.

    Raises
    ------
    ValueError
        If a parameter makes no sense.
    """

    motion: Motion = field(default_factory=Motion)
    corners: bool = True
    walls: bool = False
    association: Literal["joint", "nearest"] = "joint"
    probability: float = 0.99
    sightings: int = 3
    patience: int = 10
    state: State | None = field(default=None, init=False, repr=False)
    landmarks: Landmarks = field(default_factory=Landmarks, init=False, repr=False)
    _odometry: Pose2D | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not (self.corners or self.walls):
            raise ValueError("corners or walls must be landmarks, got neither")
        if self.association not in ASSOCIATIONS:
            names = " or ".join(ASSOCIATIONS)
            raise ValueError(f"association must be {names}, got {self.association!r}")
        if not 0 < self.probability < 1:
            raise ValueError(f"probability must be in (0, 1), got {self.probability}")
        for name in ("sightings", "patience"):
            if not getattr(self, name) >= 1:
                raise ValueError(f"{name} must be >= 1, got {getattr(self, name)}")

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
        """
        if self.state is None or self._odometry is None:
            self.state = State(start or Pose2D(0.0, 0.0, 0.0))
        else:
            moved = relative(self._odometry, odometry)
            self.state.move(moved, self.motion.covariance(moved))
        self._odometry = odometry
        seen = observations_of(features, corners=self.corners, walls=self.walls)
        matches = self._match(self.state, seen)
        matched = sum(len(match.measurement) for match in matches)
        nis = self._correct(self.state, matches) if matched else 0.0
        for match in matches:
            self.landmarks.saw(self.state.pose, match.seen, match.measurement, match.landmark)
        for match in matches:
            new = np.setdiff1d(np.arange(len(match.seen)), match.measurement)
            self.landmarks.propose(self.state, match.seen, new, self.sightings)
        self._tend(self.state, features)
        covariance = self.state.covariance[:POSE, :POSE].copy()
        return Step(self.state.pose, covariance, matched, nis, self.state.landmarks)

    @property
    def map(self) -> tuple[Landmark, ...]:
        """The landmarks so far."""
        return map_of(self.state, self.landmarks) if self.state else ()

    def _match(self, state: State, seen: list[Observations]) -> list[Match]:
        """Return which measurements are of which landmarks, under the heading that fits best."""
        sigma = math.sqrt(state.covariance[2, 2])
        reach = math.floor(3 * sigma / HEADING_STEP)
        offsets = HEADING_STEP * np.arange(-reach, reach + 1) if reach else np.zeros(1)
        best: tuple[float, list[Match]] | None = None
        for offset in offsets:
            view = View(state, float(offset), min(HEADING_STEP, sigma))
            matches = [self._associate(view, each) for each in seen]
            count = sum(len(match.measurement) for match in matches)
            cost = sum(match.squared for match in matches) + (offset / max(sigma, 1e-9)) ** 2
            score = COUNTS * count - cost
            if best is None or score > best[0]:
                best = score, matches
        return best[1] if best else []

    def _associate(self, view: View, seen: Observations) -> Match:
        near = self.landmarks.near(view, seen)
        measurement, landmark = np.nonzero(near)
        match = Match(seen, measurement, landmark, 0.0)
        if not len(measurement):
            return match
        innovation, jacobians, places = self._measure(view, match)
        pairs = Pairs(
            measurement, landmark, innovation, view.joint(jacobians, places), seen.noise[measurement]
        )
        good = np.flatnonzero(distances(pairs) <= gate(2, self.probability))
        pairs = _part(pairs, good)
        chosen = np.empty(0, dtype=np.int64)
        if len(good):
            chosen = ASSOCIATIONS[self.association](pairs, self.probability)
        part = _part(pairs, chosen)
        squared = 0.0
        if len(chosen):
            both = part.innovation.ravel()
            squared = float(both @ np.linalg.solve(part.covariance + _blocks(part.noise), both))
        return Match(seen, part.measurement, part.landmark, squared)

    def _measure(self, view: View, match: Match) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return innovations (C, 2), Jacobians (C, 2, 5) and places (C, 5) of matches."""
        seen, landmark = match.seen, match.landmark
        expected = seen.kind.expect(
            view.pose, view.positions[landmark], self.landmarks.anchors[landmark]
        )
        innovation, sign = seen.kind.innovate(seen.values[match.measurement], expected.values)
        jacobians = np.concatenate([expected.by_pose, expected.by_landmark], axis=2)
        jacobians[:, 1] *= sign[:, None]
        own = POSE + EACH * landmark[:, None] + np.arange(EACH)
        places = np.concatenate([np.tile(np.arange(POSE), (len(landmark), 1)), own], axis=1)
        return innovation, jacobians, places

    def _correct(self, state: State, matches: list[Match]) -> float:
        """Correct the state by all matches, linearised again where it comes to (iterated EKF)."""
        noise = _blocks(np.concatenate([match.seen.noise[match.measurement] for match in matches]))
        prior = state.mean.copy()
        point = View(state, 0.0, math.inf)
        nis = 0.0
        for i in range(ITERATIONS):
            parts = [self._measure(point, match) for match in matches]
            innovation = np.concatenate([part[0] for part in parts]).ravel()
            jacobians = np.concatenate([part[1] for part in parts])
            places = np.concatenate([part[2] for part in parts])
            jacobian, all_places = _spread(jacobians, places)
            back = prior[all_places] - point.mean[all_places]
            back[2] = math.remainder(back[2], math.tau)
            innovation = innovation - jacobian @ back
            if i == 0:
                expected = jacobian @ state.covariance[np.ix_(all_places, all_places)] @ jacobian.T
                nis = float(innovation @ np.linalg.solve(expected + noise, innovation))
            if i == ITERATIONS - 1:
                state.correct(all_places, jacobian, innovation, noise)
                break
            point = point.moved(
                state.corrected_mean(all_places, jacobian, innovation, noise)
            )
        return nis

    def _tend(self, state: State, features: Features) -> None:
        """Drop the landmarks that ought to be seen and are not."""
        kept = self.landmarks.worth_keeping(state, features.scan, self.patience)
        if not kept.all():
            state.keep(kept)
            self.landmarks.keep(kept)


def _blocks(noise: FloatArray) -> FloatArray:
    """Return the block-diagonal matrix (2C, 2C) of C blocks."""
    count = len(noise)
    whole = np.zeros((count, 2, count, 2))
    whole[np.arange(count), :, np.arange(count)] = noise
    return whole.reshape(2 * count, 2 * count)


def _spread(jacobians: FloatArray, places: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the Jacobian (2C, k) of all pairs by the places (k,) that they touch."""
    own, index = np.unique(places, return_inverse=True)
    count = len(places)
    whole = np.zeros((count, 2, len(own)))
    rows = np.arange(count)[:, None]
    whole[rows, :, index.reshape(places.shape)] = jacobians.transpose(0, 2, 1)
    return whole.reshape(2 * count, len(own)), own


def _part(pairs: Pairs, which: IntArray) -> Pairs:
    rows = (2 * which[:, None] + np.arange(2)).ravel()
    return Pairs(
        pairs.measurement[which],
        pairs.landmark[which],
        pairs.innovation[which],
        pairs.covariance[np.ix_(rows, rows)],
        pairs.noise[which],
    )


def dead_reckoned(start: Pose2D, first: Pose2D, odometry: Pose2D) -> Pose2D:
    """Return where odometry alone takes the sensor to be that started at `start`."""
    return compose(start, relative(first, odometry))
