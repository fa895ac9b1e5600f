"""Which ranges of a SICK log are no returns, where the log does not say.

A CARMEN log writes "no return" as a number, and which one differs per log: a code of the LMS2xx
(8183..8191 in centimetres, or 8183.., 16375.., 32759..32767 in millimetres, for the 13, 14 and 15
bits of the field) or a maximum at which some software cut all ranges, such as 50. Scans are
therefore looked at in blocks before they are given out, and the limit is found in each block and
kept from then on:

- the largest range is a code in 81.83..81.91, or in 32.759..32.767 with a millimetre digit (a log
  in centimetres may hold a true 32.76): the limit is the lower end of that band, above which the
  sensor cannot measure;
- otherwise the largest range (or the shorter codes' band that it is in) is a *plateau* if it is at
  least 4 m, occurs 10 times (5 if it is a third longer than all else, 3 if it is whole tens of
  metres, which software chooses) on as many beams (5 suffice), at least 5 times as often as all
  ranges up to 1 % below it together, and is not nearly all there is. A true largest range is rare,
  and nearly as long ones are more frequent. The limit is then the plateau's lower end;
- what is left below a limit is looked at again, for logs that hold both;
- a *cloud* of ranges at the top counts as well, where software has added noise or offsets to the
  maximum: ten times as many within 3 % of the largest as in the quarter below, from 20 m on, on a
  fifth of all beams. Where the limit is known, ranges just below it are such a cloud if they are
  ten times as many as those below them, become more up to the limit, and go on beyond it;
- a later block with true ranges beyond the limit shows that there was none.

One number is one limit: `range_max` of the scans, and a range at or beyond it is no return.
"""

import math
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import FloatArray, IntArray

# Lowest and highest code, half a unit wider.
CENTIMETRE_BAND = (81.825, 81.915)
MILLIMETRE_BAND = (32.7585, 32.7675)
SHORT_BANDS = ((16.3745, 16.3835), (8.1825, 8.1915))
SHORTEST_PLATEAU = 4.0
SHORTEST_CLOUD = 20.0  # [m]; a round hall may be smaller
WIDTH = 0.03  # of the largest range
FEWEST = 10


@dataclass
class RangeLimit:
    """The range at and beyond which a log's ranges are no returns, as far as it was read."""

    value: float = math.inf

    def update(self, scans: list[FloatArray]) -> float:
        """Return the limit [m] for a block of scans' ranges, and keep what it shows for later."""
        ranges = np.concatenate(scans)
        beams = np.concatenate([np.arange(scan.size) for scan in scans])
        keep = (ranges > 0) & np.isfinite(ranges)
        ranges, beams = ranges[keep], beams[keep]
        found = math.inf
        count = int(beams.max(initial=0)) + 1
        while ranges.size and (limit := _limit(ranges, beams, count)) < found:
            found = limit
            below = ranges < found
            ranges, beams = ranges[below], beams[below]
        if ranges.size and ranges.max() > self.value:
            self.value = found
        self.value = min(self.value, found)
        return self.value


def _limit(ranges: FloatArray, beams: IntArray, count: int) -> float:
    """Return the lower end of the no-return values at the top of `ranges`, or inf."""
    top = float(ranges.max())
    if _within(top, CENTIMETRE_BAND):
        return CENTIMETRE_BAND[0]
    if _within(top, MILLIMETRE_BAND) and not _is_whole(top / 0.01):
        return MILLIMETRE_BAND[0]
    low = next((band[0] for band in SHORT_BANDS if _within(top, band)), top)
    return low if _is_plateau(ranges, beams, low) else _cloud(ranges, beams, count)


def _cloud(ranges: FloatArray, beams: IntArray, count: int) -> float:
    """Return the lower end of a cloud of ranges at the top, far from all others, or inf."""
    edge = (1 - WIDTH) * float(ranges.max())
    on_top = ranges >= edge
    low = float(ranges[on_top].min())
    below = np.count_nonzero((ranges >= 0.75 * low) & ~on_top)
    many = int(np.count_nonzero(on_top))
    is_cloud = (
        low >= SHORTEST_CLOUD
        and many >= FEWEST
        and many >= 10 * below
        and many <= 0.9 * ranges.size
        and np.unique(beams[on_top]).size >= count / 5
    )
    return low if is_cloud else math.inf


def below_limit(ranges: FloatArray, limit: float) -> float:
    """Return the lower end of the no-returns with noise around a known limit [m], or that limit."""
    if not limit < math.inf:
        return limit
    beyond = np.count_nonzero((ranges >= limit) & (ranges <= (1 + WIDTH) * limit))
    near = ranges[(ranges >= (1 - WIDTH) * limit) & (ranges < limit)]
    if not near.size:
        return limit
    low = float(near.min())
    farther = np.count_nonzero((ranges >= 0.9 * limit) & (ranges < (1 - WIDTH) * limit))
    is_cloud = (
        near.size >= FEWEST
        and near.size >= 10 * farther
        and beyond >= 0.3 * near.size
        and np.mean(near >= (low + limit) / 2) >= 0.8
    )
    return low if is_cloud else limit


def _is_plateau(ranges: FloatArray, beams: IntArray, low: float) -> bool:
    on_top = ranges >= low
    count = int(np.count_nonzero(on_top))
    below = ranges[~on_top]
    isolated = low > 4 / 3 * below.max(initial=0)
    times = 3 if _is_whole(low / 10) else 5 if isolated else 10
    return bool(
        low >= SHORTEST_PLATEAU
        and count >= times
        and count >= 5 * np.count_nonzero(below >= 0.99 * low)
        and count <= 0.9 * ranges.size
        and np.unique(beams[on_top]).size >= min(times, 5)
    )


def _within(value: float, band: tuple[float, float]) -> bool:
    return band[0] <= value <= band[1]


def _is_whole(value: float) -> bool:
    return math.isclose(value, round(value), abs_tol=1e-3)
