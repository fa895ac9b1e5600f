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
        ends = in_map(state.pose, seen.extents)
        wanted = self.is_wall == (seen.kind is WALL)
        return wanted & close(ends, self.present_ends(state), slack, seen.kind)

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
        ends = in_map(state.pose, seen.extents)
        same = self.is_wall == (seen.kind is WALL)
        doubled = (same & close(ends, self.present_ends(state), DOUBLE, seen.kind)).any(axis=1)
        new = which[~doubled[which]]
        ripe = self._candidates[seen.kind].count(ends[new], seen.kind, self._scan, sightings)
        for i in new[ripe].tolist():
            placed = seen.kind.place(state.pose, seen.values[i], seen.noise[i])
            state.add(placed.value, placed.by_pose, placed.noise)
            self._add(state.pose, seen.kind, ends[i])

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
        ends = self.ends.copy()
        corners = ~self.is_wall
        ends[corners] = state.positions[corners][:, None]
        alpha, rho = state.positions[self.is_wall].T
        normal = np.stack([np.cos(alpha), np.sin(alpha)], axis=1)
        walls = ends[self.is_wall]
        off = ((walls - self.anchors[self.is_wall][:, None]) * normal[:, None]).sum(axis=2)
        ends[self.is_wall] = walls - (off - rho[:, None])[:, :, None] * normal[:, None]
        return ends

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
