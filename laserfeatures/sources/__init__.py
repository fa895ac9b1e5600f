"""Everything that yields LaserScans: logs, tables and bags, one module per format, and ports.

`open_source` is the way in. A format is a function from a `Log` (path, options, bookkeeping) to an
iterator of scans; `formats.py` lists them and tells them apart.
"""

from laserfeatures.sources.opening import open_source
from laserfeatures.sources.source import Source

__all__ = ["Source", "open_source"]
