"""Settings of the whole test session, made before numba is imported."""

import atexit
import os
import shutil
import tempfile

if "NUMBA_CACHE_DIR" not in os.environ:
    # An empty one, so that all is compiled as it is; shared with the processes that tests start.
    _cache = tempfile.mkdtemp(prefix="laserfeatures-numba-")
    os.environ["NUMBA_CACHE_DIR"] = _cache
    atexit.register(shutil.rmtree, _cache, ignore_errors=True)

import pytest
from hypothesis import HealthCheck, settings

_common = {
    "deadline": None,  # the first example compiles
    "derandomize": True,
    "database": None,
    "suppress_health_check": [HealthCheck.too_slow],
}
settings.register_profile("ci", max_examples=100, **_common)
settings.register_profile("nojit", max_examples=40, **_common)
settings.load_profile("nojit" if os.environ.get("NUMBA_DISABLE_JIT") == "1" else "ci")


@pytest.fixture(autouse=True)
def _quick_questions(monkeypatch):
    """Let drivers wait less for a device of another protocol: emulators answer at once."""
    monkeypatch.setattr("laserfeatures.drivers.identify.ANSWER_TIME", 0.1)
