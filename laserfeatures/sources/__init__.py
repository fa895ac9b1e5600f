"""Everything that yields LaserScans from files."""
from typing import Any
def open_source(*a: Any, **k: Any) -> Any:
    raise SystemExit("being written")
