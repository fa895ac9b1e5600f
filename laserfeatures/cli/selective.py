"""An extractor that leaves out corners which are not wanted."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from laserfeatures.arrays import FloatArray
from laserfeatures.data import Features, LaserScan
from laserfeatures.pipeline import Pipeline

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise


@dataclass(frozen=True, kw_only=True)
class Selective(Pipeline):
    """An extractor whose corners are looked through once more.

    The stages see to lines, and to corners that are crossings of lines; here are left out virtual
    corners, and those of detectors that find corners without lines, which pass the stages.

    Parameters
    ----------
    real_only : bool
        Whether virtual corners are left out.
    max_sigma : float
        Largest standard deviation of a corner along its worst direction [m].
    min_evidence : float
        Least evidence of a corner [nats].
    """

    real_only: bool = False
    max_sigma: float = math.inf
    min_evidence: float = 0.0

    @classmethod
    def of(
        cls,
        pipeline: Pipeline,
        real_only: bool,
        max_sigma: float | None,
        min_evidence: float | None,
    ) -> Pipeline:
        """Return a pipeline with such limits, or as it is if there are none.

        Raises
        ------
        ValueError
            If a limit makes no sense.
        """
        if not real_only and max_sigma is None and min_evidence is None:
            return pipeline
        segments, crossings = pipeline.segment_filter, pipeline.intersections
        if min_evidence is not None:
            segments = replace(segments, min_evidence=min_evidence)
        if max_sigma is not None:
            crossings = replace(crossings, max_sigma=max_sigma)
        return cls(
            name=pipeline.name,
            detector=pipeline.detector,
            segment_filter=segments,
            intersections=crossings,
            real_only=real_only,
            max_sigma=math.inf if max_sigma is None else max_sigma,
            min_evidence=min_evidence or 0.0,
        )

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> Features:
        """Return what is wanted of the features of `scan`."""
        features = super().__call__(scan, noise=noise)
        corners = features.corners
        wanted = _worst(corners.covariance) <= self.max_sigma
        wanted &= corners.evidence >= self.min_evidence
        if self.real_only:
            wanted &= corners.real
        return replace(features, corners=corners.select(wanted))


def _worst(covariance: FloatArray) -> FloatArray:
    """Return the largest standard deviation (F,) [m] of covariances (F, 2, 2) [m^2]."""
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    worst: FloatArray = np.sqrt((xx + yy) / 2 + np.hypot((xx - yy) / 2, xy))
    return worst
