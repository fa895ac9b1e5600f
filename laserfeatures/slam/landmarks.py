"""What is known of the landmarks besides their numbers: where they were seen, and how often."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.scan import LaserScan, Pose2D
from laserfeatures.slam.candidates import DOUBLE, Candidates
from laserfeatures.slam.closeness import close, in_map
from laserfeatures.slam.kinds import CORNER, WALL, Kind
from laserfeatures.slam.observations import Observations
from laserfeatures.slam.state import State

REACH = 0.5  # [m] beyond three deviations; farther apart, two things are not one
DEPTH = 0.3  # [m] that a beam may end before or behind a landmark that it should meet


class Landmarks:
    """The landmarks' kinds, anchors, extents and counts, in the order of the state.

    Attributes
    ----------
    anchors : (L, 2) array
        From where each was first seen [m].
    ends : (L, 2, 2) array
        Both ends of what was seen of each so far [m], in the frame of the map.
    hits, misses : (L,) arrays
        In how many scans it was seen, and in how many it ought to have been.
    """

    def __init__(self) -> None:
        self.is_wall: BoolArray = np.empty(0, dtype=bool)
        self.anchors = np.empty((0, 2))
        self.ends = np.empty((0, 2, 2))
        self.hits = np.empty(0)
        self.misses = np.empty(0)
        self._seen_now: BoolArray = np.empty(0, dtype=bool)
        self._candidates = {CORNER: Candidates(), WALL: Candidates()}
        self._scan = 0

    def near(self, state: State, seen: Observations) -> BoolArray:
        """Return which landmarks each measurement may be of, (N, L)."""
        slack = REACH + 3 * math.sqrt(max(np.linalg.eigvalsh(state.covariance[:2, :2])[-1], 0.0))
        slack += 3 * math.sqrt(state.covariance[2, 2]) * _farthest(seen)
        return self._close(state, in_map(state.pose, seen.extents), slack, seen.kind)

    def saw(
        self, pose: Pose2D, seen: Observations, measurements: IntArray, landmarks: IntArray
    ) -> None:
        """Take note that measurements were of landmarks."""
        self.hits[landmarks] += 1
        self._seen_now[landmarks] = True
        if seen.kind is WALL:
            for landmark, ends in zip(
                landmarks, in_map(pose, seen.extents[measurements]), strict=True
            ):
                self.ends[landmark] = _joined(self.ends[landmark], ends)

    def propose(self, state: State, seen: Observations, which: IntArray, sightings: int) -> None:
        """Count what is new, and make landmarks of what was seen often enough."""
        if not len(which):
            return
        ends = in_map(state.pose, seen.extents[which])
        doubled = self._close(state, ends, DOUBLE, seen.kind).any(axis=1)
        new, ends = which[~doubled], ends[~doubled]
        ripe = self._candidates[seen.kind].count(ends, seen.kind, self._scan, sightings)
        for i, both_ends in zip(new[ripe].tolist(), ends[ripe], strict=True):
            placed = seen.kind.place(state.pose, seen.values[i], seen.noise[i])
            state.add(placed.value, placed.by_pose, placed.noise)
            self._add(state.pose, seen.kind, both_ends)

    def worth_keeping(
        self, state: State, scan: LaserScan, patience: int
    ) -> tuple[BoolArray, float]:
        """Return which landmarks (L,) to keep, and how odd it is what the scan missed.

        That is minus the logarithm of the chance to miss all of it, by how often each landmark was
        recognised so far where it ought to be. Ends the scan.
        """
        missed = self._expected(state, scan) & ~self._seen_now
        rate = self.hits[missed] / (self.hits[missed] + self.misses[missed] + 1.0)
        self.misses += missed
        self._seen_now[:] = False
        self._scan += 1
        kept: BoolArray = self.misses <= self.hits + patience
        return kept, float(-np.log1p(-rate).sum())

    def keep(self, which: BoolArray) -> None:
        """Keep those landmarks (L,) bool, and forget the others."""
        for name in ("is_wall", "anchors", "ends", "hits", "misses", "_seen_now"):
            setattr(self, name, getattr(self, name)[which])

    def _add(self, pose: Pose2D, kind: Kind, ends: FloatArray) -> None:
        self.is_wall = np.append(self.is_wall, kind is WALL)
        self.anchors = np.concatenate([self.anchors, [(pose.x, pose.y)]])
        self.ends = np.concatenate([self.ends, ends[None]])
        self.hits, self.misses = np.append(self.hits, 1.0), np.append(self.misses, 0.0)
        self._seen_now = np.append(self._seen_now, True)

    def present_ends(self, state: State) -> FloatArray:
        """Return both ends of each landmark, put onto where the landmark is now, (L, 2, 2)."""
        ends = np.repeat(state.positions[:, None], 2, axis=1)
        ends[self.is_wall] = self._present_walls(state, np.flatnonzero(self.is_wall))
        return ends

    def _present_walls(self, state: State, walls: IntArray) -> FloatArray:
        alpha, rho = state.positions[walls].T
        normal = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)[:, None]
        ends, anchors = self.ends[walls], self.anchors[walls][:, None]
        off = ((ends - anchors) * normal).sum(axis=2) - rho[:, None]
        return ends - off[:, :, None] * normal

    def _close(self, state: State, ends: FloatArray, slack: float, kind: Kind) -> BoolArray:
        """Return which things of a kind (N, 2, 2) are near which landmarks of that kind, (N, L)."""
        own = np.flatnonzero(self.is_wall == (kind is WALL))
        if kind is WALL:
            others = self._present_walls(state, own)
        else:
            others = np.repeat(state.positions[own][:, None], 2, axis=1)
        near = np.zeros((len(ends), len(self.is_wall)), dtype=bool)
        near[:, own] = close(ends, others, slack, kind)
        return near

    def _expected(self, state: State, scan: LaserScan) -> BoolArray:
        """Return which landmarks (L,) the scan looks at: a beam ends there, or behind."""
        if not len(scan) or not len(self.hits):
            return np.zeros(len(self.hits), dtype=bool)
        middle = self.present_ends(state).mean(axis=1)
        local = CORNER.expect(state.pose, middle, self.anchors).values
        distance, bearing = np.hypot(*local.T), np.arctan2(local[:, 1], local[:, 0])
        beam = np.searchsorted(scan.angles, bearing).clip(0, len(scan) - 1)
        within = (bearing >= scan.angles[0]) & (bearing <= scan.angles[-1])
        ranges = np.where(scan.valid, scan.ranges, math.inf)
        looked: BoolArray = within & (ranges[beam] > distance - DEPTH) & (distance < scan.range_max)
        return looked


def _farthest(seen: Observations) -> float:
    return float(np.linalg.norm(seen.extents, axis=2).max(initial=0.0))


def _joined(ends: FloatArray, more: FloatArray) -> FloatArray:
    """Return the farthest two of four points along a wall."""
    points = np.concatenate([ends, more])
    place = points @ (ends[1] - ends[0])
    return points[[int(np.argmin(place)), int(np.argmax(place))]]
