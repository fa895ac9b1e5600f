"""Measure everything; write docs/benchmarks.md with its pictures, and docs/extractors.md's figures.

Run ``python benchmarks/report.py``; it takes some minutes. ``--quick`` repeats a tenth as often,
``--data`` says where the recordings are (../shared/data), ``--docs`` where the report goes. It
needs the extras `bench` and `ros`, and scipy.
"""

import argparse
import os
import platform
import shutil
import sys
import tempfile
import textwrap
import time
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("numpy", "numba", "opencv-python-headless", "scikit-image", "scipy")

HEAD = """# Benchmarks

Every figure here was measured by one run of `python benchmarks/report.py`{quick}, on {processor},
{cores} cores that others use as well, Linux, Python {python}, {packages}. Times are medians;
ratios are of times measured in turns in one process. `python -m pytest benchmarks/test_speed.py`
measures the speed alone.

Defaults: {detectors}; `{stages}`."""


def main():
    """Run all sections in turn."""
    parser = argparse.ArgumentParser(description="Measure everything, write docs/benchmarks.md.")
    parser.add_argument("--data", type=Path, default=ROOT / "../shared/data")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs")
    parser.add_argument("--quick", action="store_true", help="repeat a tenth as often")
    arguments = parser.parse_args()
    # numba does not see that a kernel's helper in another file has changed: start without a cache.
    cache = tempfile.mkdtemp()
    os.environ["NUMBA_CACHE_DIR"] = cache
    try:
        arguments.docs.mkdir(exist_ok=True)
        write(arguments)
    finally:
        shutil.rmtree(cache)


def write(arguments):
    """Write the report."""
    # The sections bring numba, which reads the cache's place when it is imported.
    import accuracy  # noqa: PLC0415
    import arena  # noqa: PLC0415
    import extractors_page  # noqa: PLC0415
    import memory  # noqa: PLC0415
    import real_logs  # noqa: PLC0415
    import speed  # noqa: PLC0415
    import speed_all  # noqa: PLC0415
    import start  # noqa: PLC0415
    import suites  # noqa: PLC0415
    from page import Options  # noqa: PLC0415

    options = Options(arguments.data.resolve(), arguments.docs, arguments.quick)
    paragraphs = [head(arguments.quick)]
    parts = (speed, speed_all, start, memory, real_logs, arena, suites, accuracy, extractors_page)
    for part in parts:
        start = time.perf_counter()
        paragraphs += part.section(options)
        print(f"{part.__name__}: {time.perf_counter() - start:.0f} s", file=sys.stderr)
    report = arguments.docs / "benchmarks.md"
    report.write_text("\n\n".join(map(wrapped, paragraphs)) + "\n")
    print(f"wrote {report}")


def wrapped(paragraphs):
    """Return text with lines of at most 100 characters; tables and pictures stay as they are."""
    return "\n\n".join(
        text
        if text.startswith(("|", "!", "#"))
        else textwrap.fill(text, 100, break_long_words=False, break_on_hyphens=False)
        for text in paragraphs.split("\n\n")
    )


def head(quick):
    """Say what was run, and on what."""
    import laserfeatures as lf  # noqa: PLC0415 - as in write

    extractors = [lf.get_extractor(name) for name in lf.list_extractors()]
    return HEAD.format(
        quick=" --quick" * quick,
        processor=processor(),
        cores=os.cpu_count(),
        python=platform.python_version(),
        packages=", ".join(f"{name} {version(name)}" for name in PACKAGES),
        detectors=", ".join(f"`{each.detector!r}`" for each in extractors),
        stages=f"{extractors[0].segment_filter!r}`, `{extractors[0].intersections!r}",
    )


def processor():
    """Return the processor's name."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))


if __name__ == "__main__":
    main()
