"""Let `python -m pytest benchmarks/test_speed.py` find the modules beside it."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
