"""What is known of the landmarks besides their numbers: where they were seen, and how often."""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.scan import LaserScan, Pose2D
from laserfeatures.slam.kinds import CORNER, WALL, Kind
from laserfeatures.slam.observations import Observations
from laserfeatures.slam.state import State

REACH = 0.5  # [m] beyond three deviations; farther apart, two things are not one
TILT = math.radians(15)  # walls
APART = 1.0  # [m] along a wall between what was seen of it and what is seen now
DOUBLE = 0.25  # [m]; what appears this near to a landmark is not another one
RECENT = 4  # scans after which what was seen once is forgotten
DEPTH = 0.3  # [m] that a beam may end before or behind a landmark that it should meet


@dataclass(eq=False)
class Candidate:
    """Something that may become a landmark."""

    kind: Kind
    points: FloatArray  # both ends (2, 2) [m], in the frame of the map
    count: int
    last: int  # scan


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
        self._candidates: list[Candidate] = []
        self._scan = 0

    def near(self, state: State, seen: Observations) -> BoolArray:
        """Return which landmarks each measurement may be of, (N, L)."""
        slack = REACH + 3 * math.sqrt(max(np.linalg.eigvalsh(state.covariance[:2, :2])[-1], 0.0))
        slack += 3 * math.sqrt(state.covariance[2, 2]) * _farthest(seen)
        ends = _in_map(state.pose, seen.extents)
        wanted = self.is_wall == (seen.kind is WALL)
        return wanted & _close(ends, self.present_ends(state), slack, seen.kind)

    def saw(
        self, pose: Pose2D, seen: Observations, measurements: IntArray, landmarks: IntArray
    ) -> None:
        """Take note that measurements were of landmarks."""
        self.hits[landmarks] += 1
        self._seen_now[landmarks] = True
        if seen.kind is WALL:
            for landmark, ends in zip(
                landmarks, _in_map(pose, seen.extents[measurements]), strict=True
            ):
                self.ends[landmark] = _joined(self.ends[landmark], ends)

    def propose(self, state: State, seen: Observations, which: IntArray, sightings: int) -> None:
        """Count what is new, and make landmarks of what was seen often enough."""
        ends = _in_map(state.pose, seen.extents)
        same = self.is_wall == (seen.kind is WALL)
        doubled = (same & _close(ends, self.present_ends(state), DOUBLE, seen.kind)).any(axis=1)
        for i in which.tolist():
            if doubled[i]:
                continue
            candidate = self._candidate(seen.kind, ends[i])
            candidate.count += candidate.last != self._scan
            candidate.last, candidate.points = self._scan, ends[i]
            if candidate.count >= sightings:
                self._candidates.remove(candidate)
                placed = seen.kind.place(state.pose, seen.values[i], seen.noise[i])
                state.add(placed.value, placed.by_pose, placed.noise)
                self._add(state.pose, seen.kind, ends[i])

    def worth_keeping(self, state: State, scan: LaserScan, patience: int) -> BoolArray:
        """Return which landmarks (L,) to keep, and end the scan."""
        self.misses += self._expected(state, scan) & ~self._seen_now
        self._seen_now[:] = False
        self._candidates = [c for c in self._candidates if self._scan - c.last < RECENT]
        self._scan += 1
        kept: BoolArray = self.misses <= self.hits + patience
        return kept

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

    def _candidate(self, kind: Kind, ends: FloatArray) -> Candidate:
        for candidate in self._candidates:
            if (
                candidate.kind is kind
                and _close(ends[None], candidate.points[None], DOUBLE, kind).any()
            ):
                return candidate
        self._candidates.append(Candidate(kind, ends, 1, self._scan))
        return self._candidates[-1]

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


def _in_map(pose: Pose2D, ends: FloatArray) -> FloatArray:
    return pose.transform(ends).reshape(-1, 2, 2)


def _close(ends: FloatArray, others: FloatArray, slack: float, kind: Kind) -> BoolArray:
    """Return which of some things (N, 2, 2) are within `slack` [m] of which others (L, 2, 2)."""
    if kind is CORNER:
        away = np.linalg.norm(ends[:, None, 0] - others[None, :, 0], axis=2)
        return away <= slack
    along = others[:, 1] - others[:, 0]
    length = np.linalg.norm(along, axis=1)
    along = along / np.maximum(length, 1e-9)[:, None]
    own = ends[:, 1] - ends[:, 0]
    own = own / np.maximum(np.linalg.norm(own, axis=1), 1e-9)[:, None]
    tilt = abs(own[:, None, 0] * along[None, :, 1] - own[:, None, 1] * along[None, :, 0])
    from_start = ends[:, None] - others[None, :, :1]
    place = (from_start * along[None, :, None]).sum(axis=3)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    off = abs((from_start * normal[None, :, None]).sum(axis=3)).mean(axis=2)
    gap = np.maximum(place.min(axis=2) - length, -place.max(axis=2))
    return (tilt <= math.sin(TILT)) & (off <= slack) & (gap <= APART)


def _joined(ends: FloatArray, more: FloatArray) -> FloatArray:
    """Return the farthest two of four points along a wall."""
    points = np.concatenate([ends, more])
    place = points @ (ends[1] - ends[0])
    return points[[int(np.argmin(place)), int(np.argmax(place))]]
