"""The main path: a detector, then the two stages that all extractors of lines share."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from laserfeatures.compiled import interruption
from laserfeatures.data import Features, LaserScan, LineSegments, PointFeatures
from laserfeatures.engine.detector import WallDetector
from laserfeatures.errors import PluginError
from laserfeatures.intersections import Intersections
from laserfeatures.parameters import settle
from laserfeatures.segment_filter import SegmentFilter

if TYPE_CHECKING:
    from laserfeatures.noise_model import RangeNoise


class Detector(Protocol):
    """What a plugin provides: line segments out of a scan, or points at once.

    One whose ``__call__`` has a parameter named ``noise`` is told with it the `RangeNoise` of the
    scan, or None where it is not known.
    """

    def __call__(self, scan: LaserScan, /) -> LineSegments | PointFeatures:
        """Return the line segments in `scan`, or its corners if they are found without lines."""
        ...


@dataclass(frozen=True, kw_only=True)
class Pipeline:
    """An extractor: from a scan to its line segments and corners (the paper's Fig. 2).

    Parameters
    ----------
    name : str
        The name it was found by.
    detector : Detector
        Finds lines and cuts them into segments, or finds corners at once.
    segment_filter : SegmentFilter
        Removes what is no reliable segment.
    intersections : Intersections
        Crosses the remaining lines.

    Raises
    ------
    TypeError
        If a stage is none.
    """

    STAGES: ClassVar[Mapping[str, type[Any]]] = {
        "segment_filter": SegmentFilter,
        "intersections": Intersections,
    }

    name: str
    detector: Detector
    segment_filter: SegmentFilter = field(default_factory=SegmentFilter)
    intersections: Intersections = field(default_factory=Intersections)

    def __post_init__(self) -> None:
        """Check that each stage is one."""
        for stage, kind in self.STAGES.items():
            value = getattr(self, stage)
            if not isinstance(value, kind):
                raise TypeError(f"{stage} must be a {kind.__name__}, got {value!r}")
        if isinstance(self.detector, WallDetector):  # whatever its own __post_init__ checks
            settle(self.detector)

    def __call__(self, scan: LaserScan, *, noise: "RangeNoise | None" = None) -> Features:
        """Return the line segments and corners of `scan`.

        Corners that the detector found without lines pass both stages as they are.

        Parameters
        ----------
        scan : LaserScan
            The scan.
        noise : RangeNoise, optional
            The noise of its ranges, such as a `NoiseModel` tells it. A detector that is given a
            `range_sigma` of its own, or takes no noise, does without.

        Raises
        ------
        PluginError
            If the detector returns anything else.
        TypeError
            If `scan` is no LaserScan, with a message that says how to make one, or `noise` is no
            RangeNoise.
        """
        detected = self.detect(scan, noise=noise)
        if isinstance(detected, PointFeatures):
            return Features(scan=scan, segments=LineSegments.none(len(scan)), corners=detected)
        if not isinstance(detected, LineSegments):
            raise PluginError(
                f"extractor {self.name!r} must return LineSegments or PointFeatures, "
                f"got {type(detected).__name__}"
            )
        # 9. Remove what is no reliable segment.
        segments = self.segment_filter(detected)
        # 10. Cross the lines.
        corners = self.intersections(segments, limit=scan.range_max)
        return Features.trusted(scan=scan, segments=segments, corners=corners)

    def detect(
        self, scan: LaserScan, *, noise: "RangeNoise | None" = None
    ) -> LineSegments | PointFeatures:
        """Return what the detector finds, before the other stages; parameters as of a call."""
        if not isinstance(scan, LaserScan):
            raise TypeError(_no_scan(scan))
        if noise is not None and not hasattr(noise, "sigma"):
            raise TypeError(f"noise must be a RangeNoise, as a NoiseModel tells, got {noise!r}")
        detector: Callable[..., LineSegments | PointFeatures] = self.detector
        try:
            return detector(scan, noise=noise) if self._takes_noise else detector(scan)
        except SystemError as error:  # maybe Ctrl-C, in compiled code of the detector's own
            raise interruption(error) from None

    @cached_property
    def _takes_noise(self) -> bool:
        try:
            return "noise" in inspect.signature(self.detector).parameters
        except ValueError:  # compiled code may tell no signature
            return False


def _no_scan(value: object) -> str:
    """Say what was expected in place of a value, which has the directions of no beam."""
    shape = getattr(value, "shape", None)
    got = type(value).__name__ + ("" if shape is None else f" of shape {tuple(shape)}")
    return (
        f"expected a LaserScan, got {got}; make one of ranges [m] with "
        "LaserScan.uniform(ranges, angle_min, angle_increment), or of angles [rad] and ranges with "
        "LaserScan(angles=..., ranges=...)"
    )
