"""Which measurements of a scan are of which landmarks, and what all of them together measure."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray
from laserfeatures.slam.association import (
    DENSITY,
    Pairs,
    gate,
    joint_compatibility,
    nearest_neighbours,
)
from laserfeatures.slam.landmarks import Landmarks
from laserfeatures.slam.observations import Observations
from laserfeatures.slam.state import EACH, POSE, State

Associate = Callable[[Pairs, float, float], IntArray]
ASSOCIATIONS: dict[str, Associate] = {
    "joint": joint_compatibility,
    "nearest": nearest_neighbours,
}


@dataclass(frozen=True, eq=False)
class Matches:
    """Which measurements (K,) of one kind are of which landmarks (K,)."""

    seen: Observations
    measurement: IntArray
    landmark: IntArray

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.measurement)


@dataclass(frozen=True, eq=False)
class Measurement:
    """Some matches as one measurement of the state; the parameters are those of `State.correct`."""

    places: IntArray
    jacobian: FloatArray
    innovation: FloatArray
    noise: FloatArray


def matches_of(
    state: State, landmarks: Landmarks, seen: Observations, association: str, probability: float
) -> Matches:
    """Return which measurements are of which landmarks."""
    measurement, landmark = np.nonzero(landmarks.near(state, seen))
    if not len(measurement):
        return Matches(seen, measurement, landmark)
    innovation, jacobians, each = _linearised(
        state, landmarks, Matches(seen, measurement, landmark)
    )
    own = jacobians @ state.covariance[each[:, :, None], each[:, None, :]]
    total = own @ jacobians.transpose(0, 2, 1) + seen.noise[measurement]
    solved = np.linalg.solve(total, innovation[:, :, None])[:, :, 0]
    good = (innovation * solved).sum(axis=1) <= gate(2, probability)
    measurement, landmark = measurement[good], landmark[good]
    if not len(measurement):
        return Matches(seen, measurement, landmark)
    measured = measurement_of(state, landmarks, Matches(seen, measurement, landmark))
    expected = state.covariance[np.ix_(measured.places, measured.places)]
    pairs = Pairs(
        measurement,
        landmark,
        measured.innovation.reshape(-1, 2),
        measured.jacobian @ expected @ measured.jacobian.T,
        seen.noise[measurement],
    )
    chosen = ASSOCIATIONS[association](pairs, probability, DENSITY)
    return Matches(seen, pairs.measurement[chosen], pairs.landmark[chosen])


def measurement_of(state: State, landmarks: Landmarks, matches: Matches) -> Measurement:
    """Return what some matches measure, linearised where the state is."""
    seen, count = matches.seen, len(matches)
    innovation, jacobians, each = _linearised(state, landmarks, matches)
    places, column = np.unique(each, return_inverse=True)
    whole = np.zeros((count, 2, len(places)))
    rows = np.arange(count)[:, None]
    whole[rows, :, column.reshape(each.shape)] = jacobians.transpose(0, 2, 1)
    noise = np.zeros((count, 2, count, 2))
    noise[np.arange(count), :, np.arange(count)] = seen.noise[matches.measurement]
    return Measurement(
        places,
        whole.reshape(2 * count, len(places)),
        innovation.ravel(),
        noise.reshape(2 * count, 2 * count),
    )


def _linearised(
    state: State, landmarks: Landmarks, matches: Matches
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return innovations (K, 2), Jacobians (K, 2, 5) and the numbers (K, 5) that they are by."""
    seen, landmark = matches.seen, matches.landmark
    expected = seen.kind.expect(state.pose, state.positions[landmark], landmarks.anchors[landmark])
    innovation, sign = seen.kind.innovate(seen.values[matches.measurement], expected.values)
    jacobians = np.concatenate([expected.by_pose, expected.by_landmark], axis=2)
    jacobians[:, 1] *= sign[:, None]
    count = len(landmark)
    own = POSE + EACH * landmark[:, None] + np.arange(EACH)
    each = np.concatenate([np.tile(np.arange(POSE), (count, 1)), own], axis=1)
    return innovation, jacobians, each
