"""What the first run after an installation has to do once, done on a second core.

Run as a program, it compiles the shared stages and lists the fonts for pictures. Both go to caches
on disk.
"""

import contextlib
import gc
import subprocess
import sys
from collections.abc import Iterator

import numpy as np

from laserfeatures.data import Lines, LineSegments


@contextlib.contextmanager
def prepared_aside() -> Iterator[None]:
    """Prepare in a process of its own while this one compiles the line detector.

    What this process needs before the other one has it, it prepares itself.
    """
    command = [sys.executable, "-m", "laserfeatures.cli.warm_up"]
    with subprocess.Popen(  # noqa: S603 - our own module
        command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        gc.disable()  # compiling makes millions of objects that all live on
        try:
            yield
        finally:
            gc.enable()
            process.terminate()


def _prepare() -> None:
    from laserfeatures.intersections import Intersections  # noqa: PLC0415 - brings numba
    from laserfeatures.segment_filter import SegmentFilter  # noqa: PLC0415 - brings numba

    none = np.empty(0)
    nothing = LineSegments(
        lines=Lines(theta=none, d=none, support=none, covariance=np.empty((0, 2, 2))),
        line=np.empty(0, np.int64),
        endpoints=np.empty((0, 2, 2)),
        support=none,
        rms=none,
        points=np.empty((0, 0), np.bool_),
    )
    Intersections()(SegmentFilter()(nothing))
    with contextlib.suppress(ImportError):
        import matplotlib.font_manager  # noqa: F401, PLC0415 - an extra


if __name__ == "__main__":
    _prepare()
