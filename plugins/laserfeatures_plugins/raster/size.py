"""The limits of an image of a scan."""

import math

MAX_PIXELS = 64_000_000


def check_size(width: float, height: float, resolution: float) -> None:
    """Check the size of an image [pixels].

    Raises
    ------
    ValueError
        If it has more than `MAX_PIXELS` pixels.
    """
    if width * height > MAX_PIXELS:
        raise ValueError(
            f"an image of {width * resolution:.0f} m x {height * resolution:.0f} m at a resolution "
            f"of {resolution:g} m has {width * height:.0f} pixels, more than {MAX_PIXELS}: "
            "take a coarser resolution or a smaller max_range"
        )


def check_image(resolution: float, max_range: float, min_incidence: float) -> None:
    """Check the parameters that all detectors in images of scans have.

    Raises
    ------
    ValueError
        If one is out of its range, or if the image could be too large.
    """
    if not 1e-4 <= resolution <= 10:
        raise ValueError(f"resolution must be in [0.0001, 10] m, got {resolution!r}")
    if not max_range > 0:
        raise ValueError(f"max_range must be > 0 m, got {max_range!r}")
    if not 0 < min_incidence <= math.pi / 4:
        raise ValueError(f"min_incidence must be in (0, pi/4] rad, got {min_incidence!r}")
    if max_range < math.inf:  # else the first scan tells
        check_size(2 * max_range / resolution, 2 * max_range / resolution, resolution)
