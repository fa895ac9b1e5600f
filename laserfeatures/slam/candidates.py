"""What was seen and is no landmark yet."""

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.slam.closeness import close
from laserfeatures.slam.kinds import Kind

DOUBLE = 0.25  # [m]; what appears this near to something is not another one
RECENT = 4  # scans after which what was not seen again is forgotten


class Candidates:
    """Things of one kind that may become landmarks: where each was seen last, and how often."""

    def __init__(self) -> None:
        self._ends = np.empty((0, 2, 2))
        self._counts = np.empty(0, dtype=np.int64)
        self._last = np.empty(0, dtype=np.int64)

    def count(self, ends: FloatArray, kind: Kind, scan: int, sightings: int) -> BoolArray:
        """Return which of some things (N,) seen in a scan were now seen often enough.

        Parameters
        ----------
        ends : (N, 2, 2) array
            Both ends of each [m], in the frame of the map.
        kind : Kind
            What they are.
        scan : int
            The scan's number.
        sightings : int
            How often is enough.
        """
        self._keep(scan - self._last < RECENT)
        known = close(ends, self._ends, DOUBLE, kind)
        twice = np.tril(close(ends, ends, DOUBLE, kind), -1).any(axis=1)  # in this scan
        ripe = np.zeros(len(ends), dtype=bool)
        gone = np.zeros(len(self._ends), dtype=bool)
        for i in np.flatnonzero(~twice).tolist():
            (near,) = np.nonzero(known[i] & ~gone)
            counts = int(self._counts[near].max(initial=0)) + 1
            gone[near] = True
            ripe[i] = counts >= sightings
            if not ripe[i]:
                self._ends = np.concatenate([self._ends, ends[i : i + 1]])
                self._counts = np.append(self._counts, counts)
                self._last = np.append(self._last, scan)
        self._keep(np.append(~gone, np.ones(len(self._ends) - len(gone), dtype=bool)))
        return ripe

    def _keep(self, which: BoolArray) -> None:
        self._ends = self._ends[which]
        self._counts = self._counts[which]
        self._last = self._last[which]
