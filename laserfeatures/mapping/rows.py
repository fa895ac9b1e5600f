"""Reading text files of poses, one a line."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from laserfeatures.errors import SourceError
from laserfeatures.mapping.trajectory import Trajectory
from laserfeatures.sources.files import DAMAGE, open_stream

Row = tuple[float, float, float, float]


def read_rows(path: Path, parse: Callable[[list[bytes]], Row | None], wanted: str) -> Trajectory:
    """Read a file of poses; empty lines and those that start with # are left out.

    Parameters
    ----------
    path : Path
        The file, packed with gzip or not.
    parse : callable
        From the words of a line to stamp [s], x, y [m] and heading [rad], or to None where the line
        holds none; raises a ValueError that says what was expected and what came.
    wanted : str
        What the lines are, for an error.

    Raises
    ------
    SourceError
        If the file cannot be read, a line is broken, or there is none.
    """
    rows: list[Row] = []
    number = 1
    try:
        with open_stream(path) as stream:
            for line in stream:
                words = [] if line.startswith(b"#") else line.split()
                if words and (row := parse(words)):
                    rows.append(row)
                number += 1
    except ValueError as error:
        raise SourceError(f"{path}:{number}: {error}") from error
    except DAMAGE as error:
        raise SourceError(
            f"{path}:{number}: the file is cut or damaged from here on ({error})"
        ) from error
    if not rows:
        raise SourceError(f"{path}: expected {wanted}, got none")
    table = np.array(rows)
    return Trajectory(stamps=table[:, 0], poses=table[:, 1:])
