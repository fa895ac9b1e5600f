"""The main path: a line detector, then the two stages that all extractors share."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

from laserfeatures.data import Features, LaserScan, LineSegments
from laserfeatures.errors import PluginError
from laserfeatures.intersections import Intersections
from laserfeatures.segment_filter import SegmentFilter


class LineDetector(Protocol):
    """What a plugin provides: lines and segments out of a scan."""

    def __call__(self, scan: LaserScan, /) -> LineSegments:
        """Return the line segments in `scan`."""
        ...


@dataclass(frozen=True, kw_only=True)
class Pipeline:
    """An extractor: from a scan to its line segments and corners (the paper's Fig. 2).

    Parameters
    ----------
    name : str
        The name it was found by.
    detector : LineDetector
        Finds lines and cuts them into segments.
    segment_filter : SegmentFilter
        Removes what is no reliable segment.
    intersections : Intersections
        Crosses the remaining lines.
    """

    STAGES: ClassVar[Mapping[str, type[Any]]] = {
        "segment_filter": SegmentFilter,
        "intersections": Intersections,
    }

    name: str
    detector: LineDetector
    segment_filter: SegmentFilter = field(default_factory=SegmentFilter)
    intersections: Intersections = field(default_factory=Intersections)

    def __post_init__(self) -> None:
        """Check that each stage is one."""
        for stage, kind in self.STAGES.items():
            value = getattr(self, stage)
            if not isinstance(value, kind):
                raise TypeError(f"{stage} must be a {kind.__name__}, got {value!r}")

    def __call__(self, scan: LaserScan) -> Features:
        """Return the line segments and corners of `scan`."""
        detected = self.detector(scan)
        if not isinstance(detected, LineSegments):
            raise PluginError(
                f"extractor {self.name!r} must return LineSegments, got {type(detected).__name__}"
            )
        segments = self.segment_filter(detected)
        return Features(scan=scan, segments=segments, corners=self.intersections(segments))
