"""On what machine, and with which versions, something was measured."""

import os
import platform
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("laserfeatures", "numpy", "numba", "opencv-python-headless")


def machine() -> dict[str, str]:
    """Return the processor, the system, and the versions of what takes the time, by name."""
    cores = os.cpu_count() or 1
    versions = [f"Python {platform.python_version()}"]
    for package in PACKAGES:
        with suppress(PackageNotFoundError):  # OpenCV comes under several names
            versions.append(f"{package} {version(package)}")
    return {
        "processor": f"{_processor()}, {cores} core{'s' * (cores > 1)}",
        "system": f"{platform.system()} {platform.release()}",
        "versions": ", ".join(versions),
    }


def _processor() -> str:
    with suppress(OSError):  # Linux alone has the file, and not on every processor the line
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            name, _, value = line.partition(":")
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()
