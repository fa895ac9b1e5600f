"""Ten devices at once, for five seconds: no scan is lost."""

import subprocess
import sys
from pathlib import Path

BENCHMARK = Path(__file__).parents[1] / "benchmarks/driver_load.py"


def test_ten_devices_at_once_lose_no_scan():
    done = subprocess.run(  # noqa: S603 - our own script
        [sys.executable, BENCHMARK, "--seconds", "5"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    rows = [line.split("|") for line in done.stdout.splitlines()[2:12]]
    rates = {row[1].strip(): float(row[3]) for row in rows}
    assert rates["lms"] > 37
    assert rates["urg"] > 9.8
    assert rates["ld19"] > 9.8
    assert rates["rplidar"] > 5
