"""Line segments and corners out of 2D laser scans.

>>> import laserfeatures as lf
>>> extractor = lf.get_extractor("direct_hough")
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from laserfeatures.data import Features, LaserScan, Lines, LineSegments, PointFeatures, Pose2D
from laserfeatures.errors import (
    DeviceLostError,
    DriveError,
    DriverError,
    DriverTimeoutError,
    LaserFeaturesError,
    MissingDependencyError,
    PluginError,
    ProtocolError,
    SourceError,
    UnknownExtractorError,
)
from laserfeatures.registry import get_extractor, list_extractors, register_extractor

if TYPE_CHECKING:
    from laserfeatures.intersections import Intersections
    from laserfeatures.pipeline import Pipeline
    from laserfeatures.segment_filter import SegmentFilter
    from laserfeatures.sources import open_source

    __version__: str

__all__ = [
    "DeviceLostError",
    "DriveError",
    "DriverError",
    "DriverTimeoutError",
    "Features",
    "Intersections",
    "LaserFeaturesError",
    "LaserScan",
    "LineSegments",
    "Lines",
    "MissingDependencyError",
    "Pipeline",
    "PluginError",
    "PointFeatures",
    "Pose2D",
    "ProtocolError",
    "SegmentFilter",
    "SourceError",
    "UnknownExtractorError",
    "__version__",
    "get_extractor",
    "list_extractors",
    "open_source",
    "register_extractor",
]

_LAZY = {  # these bring numba and all the readers, which not every program needs
    "Intersections": "laserfeatures.intersections",
    "Pipeline": "laserfeatures.pipeline",
    "SegmentFilter": "laserfeatures.segment_filter",
    "open_source": "laserfeatures.sources",
}


def __dir__() -> list[str]:
    """Return the public names, the lazy ones among them, and none that is here for our own use."""
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("laserfeatures")  # slow to import
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
