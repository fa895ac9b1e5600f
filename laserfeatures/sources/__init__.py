"""Everything that yields LaserScans from files: logs, tables and bags, one module per format.

`open_source` is the way in. A format is a function from a `Log` (path, options, bookkeeping) to an
iterator of scans; `formats.py` lists them and tells them apart.
"""

from laserfeatures.sources.source import Source, open_source

__all__ = ["Source", "open_source"]
