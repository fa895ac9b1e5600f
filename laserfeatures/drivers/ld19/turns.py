"""From frames of twelve clockwise measurements to scans of one turn."""

import math

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray
from laserfeatures.drivers.decoder import Sweep
from laserfeatures.drivers.ld19.frames import CLOCK_MS, POINTS, Frame
from laserfeatures.drivers.losses import Losses
from laserfeatures.scan import LaserScan

ENOUGH = 180.0  # [deg] of a turn that make a scan; less says little of where the walls are
RANGE_MIN = 0.02  # [m]


class Turns:
    """Puts measurements together to scans, from angle 0 to angle 0.

    The device turns clockwise; scans have angles in (-pi, pi], counter-clockwise, 0 at the front.
    What a lost frame held is not in its scan: the beams are not there. A turn of which more than
    half is missing is not delivered but counted as missed, but for the one that the port is opened
    in. The stamp is the time of the turn's first measurement, taken from the arrival of its frame.

    Parameters
    ----------
    losses : Losses
        Where turns that did not come are counted.
    range_max : float
        Of the sensor [m].
    min_intensity : int
        Measurements with less intensity are no returns.
    """

    def __init__(self, losses: Losses, range_max: float, min_intensity: int) -> None:
        self._losses = losses
        self._range_max = range_max
        self._min_intensity = min_intensity
        self.reset()

    def reset(self) -> None:
        """Begin anew, in the middle of a turn."""
        self._last: Frame | None = None
        self._whole = False  # whether the turn has been followed from its begin
        self._clear()

    def _clear(self) -> None:
        self._angles: list[FloatArray] = []
        self._ranges: list[FloatArray] = []
        self._covered = 0.0
        self._arrival = self._stamp = math.nan

    def add(self, frame: Frame, arrival: float) -> list[Sweep]:
        """Add a frame whose first byte came at `arrival` [s]; return the finished scans."""
        scans = self._lost_since(frame)
        angles = frame.angles
        new = angles >= 360.0
        self._keep(frame, angles, ~new, arrival)
        if new.any():
            scans += self._close()
            self._keep(frame, angles - 360.0, new, arrival)
        self._last = frame
        return scans

    def _lost_since(self, frame: Frame) -> list[Sweep]:
        """Close the turn if its end was lost between the last frame and this one."""
        if self._last is None:
            return []
        period = 360.0 / max(frame.speed, 1)
        elapsed = (frame.time - self._last.time) % CLOCK_MS / 1000
        turns = elapsed / period
        if turns < 1 and frame.start >= self._last.start:
            return []
        if turns < 1 and self._last.angles[-1] >= 360.0:  # that turn is closed already
            return []
        self._losses.missed += max(round(turns) - 1, 0)
        return self._close()

    def _keep(self, frame: Frame, angles: FloatArray, which: BoolArray, arrival: float) -> None:
        if not which.any():
            return
        step = (angles[-1] - angles[0]) / (POINTS - 1)
        if not self._angles:
            # A frame leaves when its last point is measured.
            first = int(np.argmax(which))
            self._arrival = arrival
            self._stamp = arrival - (POINTS - 1 - first) * step / max(frame.speed, 1)
        valid = (frame.ranges > 0) & (frame.intensities >= self._min_intensity)
        ranges = np.where(valid, frame.ranges / 1000.0, math.nan)
        self._angles.append(angles[which])
        self._ranges.append(ranges[which])
        self._covered += int(which.sum()) * step

    def _close(self) -> list[Sweep]:
        """Return the scan of the turn so far and begin the next one."""
        angles, ranges = self._angles, self._ranges
        stamp, arrival, covered, whole = self._stamp, self._arrival, self._covered, self._whole
        self._clear()
        self._whole = True
        if covered < ENOUGH or not whole:
            self._losses.missed += whole
            return []
        clockwise = np.radians(np.concatenate(angles))
        counter = math.pi - (clockwise + math.pi) % math.tau  # in (-pi, pi]
        sorted_, first = np.unique(counter, return_index=True)
        scan = LaserScan(
            angles=sorted_,
            ranges=np.concatenate(ranges)[first],
            range_min=RANGE_MIN,
            range_max=self._range_max,
            stamp=stamp,
        )
        return [Sweep(scan, arrival)]
