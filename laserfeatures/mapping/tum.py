"""Trajectory files in TUM format: `stamp x y z qx qy qz qw`, one pose a line, metres and seconds.

A trajectory in the plane has z = 0 and turns about z alone. A pose whose stamp is not known is
written with its number in its place; one whose heading is not known has the quaternion 0 0 0 0.

References
----------
Sturm et al., A Benchmark for the Evaluation of RGB-D SLAM Systems, IROS 2012: the format.
"""

import math
from pathlib import Path
from typing import IO

import numpy as np

from laserfeatures.mapping.rows import Row, read_rows
from laserfeatures.mapping.trajectory import Trajectory

FIELDS = 8
TILT = math.radians(5)  # more than this is no trajectory in a plane


def is_tum(head: bytes) -> bool:
    """Return whether a file that starts with `head` is a trajectory in TUM format."""
    lines = (line.split() for line in head.splitlines() if not line.startswith(b"#"))
    first = next((tokens for tokens in lines if tokens), [])
    return len(first) == FIELDS and all(_is_number(token) for token in first)


def write_tum(file: IO[str], trajectory: Trajectory) -> None:
    """Write a trajectory with all its digits.

    Parameters
    ----------
    file : text file
        Open for writing.
    trajectory : Trajectory
        What to write. If no stamp is known, the poses are numbered instead.
    """
    known = np.isfinite(trajectory.stamps).all()
    stamps = trajectory.stamps.tolist() if known else range(len(trajectory))
    for stamp, (x, y, theta) in zip(stamps, trajectory.poses.tolist(), strict=True):
        turn = math.sin(theta / 2), math.cos(theta / 2)
        z, w = turn if math.isfinite(theta) else (0.0, 0.0)
        file.write(f"{stamp!r} {x!r} {y!r} 0 0 0 {z!r} {w!r}\n")


def read_tum(path: Path) -> Trajectory:
    """Read a trajectory; lines that start with # are left out.

    Raises
    ------
    SourceError
        If the file cannot be read, holds no pose, or a line does not hold a pose in the plane; the
        message names it.
    """
    return read_rows(path, _pose, "poses in TUM format")


def _pose(tokens: list[bytes]) -> Row:
    """Return the stamp and the pose of a line.

    Raises
    ------
    ValueError
        If it does not hold them.
    """
    if len(tokens) != FIELDS:
        raise ValueError(f"expected stamp x y z qx qy qz qw, got {len(tokens)} fields")
    stamp, x, y, _, qx, qy, qz, qw = (float(token) for token in tokens)
    if not all(map(math.isfinite, (stamp, x, y, qx, qy, qz, qw))):
        raise ValueError("expected finite numbers stamp x y z qx qy qz qw, got nan or inf")
    size = math.hypot(qx, qy, qz, qw)
    if not size:
        return stamp, x, y, math.nan
    if not 0.99 < size < 1.01:
        raise ValueError(f"expected a quaternion qx qy qz qw of length 1, got one of {size:.3g}")
    if 2 * math.asin(min(math.hypot(qx, qy) / size, 1.0)) > TILT:
        raise ValueError(
            f"expected a pose in the plane, which turns about z alone, got qx = {qx:.3g} and "
            f"qy = {qy:.3g}"
        )
    return stamp, x, y, math.remainder(2 * math.atan2(qz, qw), math.tau)


def _is_number(token: bytes) -> bool:
    try:
        float(token)
    except ValueError:
        return False
    return True
