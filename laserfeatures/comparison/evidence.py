"""Corners found again by their evidence: what is gained by asking for more of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from laserfeatures.arrays import BoolArray, FloatArray, IntArray
from laserfeatures.comparison.matching import moved_on, near
from laserfeatures.data import LaserScan, PointFeatures

KEPT = (1.0, 0.75, 0.5, 0.25, 0.1)  # of the corners, by evidence
KINDS = ("real", "virtual")


@dataclass(frozen=True, eq=False, kw_only=True)
class Curve:
    """Corners found again over corners a scan, by least evidence.

    Parameters
    ----------
    thresholds : (K,) array
        Least evidence of the corners that count [nats], where all of them, 75, 50, 25 and 10 % have
        it; nan where there is no corner.
    corners : (K,) array
        Mean number of those corners in a scan.
    found, judged : (K,) int arrays
        So many were found again, of whatever evidence there, of so many in the next scan's view.
    """

    thresholds: FloatArray
    corners: FloatArray
    found: IntArray
    judged: IntArray

    @property
    def shares(self) -> FloatArray:
        """Found per judged, (K,); nan where none was judged."""
        shares: FloatArray = np.full(self.found.size, np.nan)
        np.divide(self.found, self.judged, out=shares, where=self.judged > 0)
        return shares


def by_evidence(
    scans: Sequence[LaserScan], corners: Sequence[PointFeatures], tolerance: float
) -> dict[str, Curve]:
    """Measure how many corners of a scan the next one shows again, by least evidence.

    As `repeatability` does for all corners: of those in view.

    Parameters
    ----------
    scans : sequence of LaserScan
        The scans in order.
    corners : sequence of PointFeatures
        The corners found in each.
    tolerance : float
        Greatest distance of a corner found again [m].

    Returns
    -------
    dict of str to Curve
        Of the "real" and of the "virtual" corners. A corner is found again as either, and with any
        evidence: one that is a little weaker in the next scan was no mistake in this one.

    Raises
    ------
    ValueError
        If there are not as many scans as corners of a scan.
    """
    positions = [each.positions for each in corners]
    judged = [np.zeros(len(each), np.bool_) for each in corners]
    found = [np.zeros(len(each), np.bool_) for each in corners]
    for i, _, moved, inside in moved_on(scans, positions):
        judged[i] = inside
        found[i] = inside & near(moved, positions[i + 1], tolerance)
    real = np.concatenate([each.real for each in corners])
    evidence = np.concatenate([each.evidence for each in corners])
    flags = np.stack([np.concatenate(judged), np.concatenate(found)])
    return {
        kind: _curve(evidence[chosen], flags[:, chosen], len(scans))
        for kind, chosen in zip(KINDS, (real, ~real), strict=True)
    }


def _curve(evidence: FloatArray, flags: BoolArray, scans: int) -> Curve:
    """Return the curve of corners by their evidence (A,); flags (2, A): judged, and found again."""
    thresholds = np.full(len(KEPT), np.nan)
    if evidence.size:  # the ranks are rounded down: at least that share is kept, and inf is no harm
        ranks = ((1.0 - np.array(KEPT)) * evidence.size).astype(np.int64)
        thresholds = np.sort(evidence)[ranks]
    enough = evidence >= thresholds[:, None]
    judged, found = flags
    return Curve(
        thresholds=thresholds,
        corners=enough.sum(axis=1) / scans,
        found=(enough & found).sum(axis=1),
        judged=(enough & judged).sum(axis=1),
    )
